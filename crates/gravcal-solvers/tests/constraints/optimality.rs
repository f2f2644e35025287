//! The conditions of Karush, Kuhn and Tucker, checked from outside on random problems.

use gravcal_estimation::{
    Affine, BlockId, Constraint, ConstraintKind, Estimate, Factor, Noise, Problem, ProblemBuilder, Values,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::build::{Function, block, solve};

/// Unknowns, in blocks of three.
const UNKNOWNS: usize = 9;
const ROWS: usize = 14;

/// r = A x + 0.3 sin(B x) − b in units that differ by `scale` from unknown to unknown, and constraints of every kind around
/// the start; `rank` of the unknowns' directions are read.
fn random_problem(seed: u64, rank: usize, spread: f64) -> (Problem, Values) {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut uniform = || random.random_range(-1.0..1.0);
    let mut builder = ProblemBuilder::new();
    let scales: Vec<f64> = (0..UNKNOWNS).map(|_| 10f64.powf(spread * uniform())).collect();
    let start: Vec<f64> = scales.iter().map(|s| s * uniform()).collect();
    let blocks: Vec<BlockId> =
        start.chunks(3).enumerate().map(|(i, x)| builder.add_block(block(&format!("b{i}"), 3), x)).collect();
    let read: Vec<f64> = (0..rank * UNKNOWNS).map(|_| uniform()).collect();
    let mut matrix = || -> Vec<f64> {
        let left: Vec<f64> = (0..ROWS * rank).map(|_| uniform()).collect();
        let entry = |i: usize, j: usize| (0..rank).map(|k| left[i * rank + k] * read[k * UNKNOWNS + j]).sum::<f64>();
        (0..ROWS * UNKNOWNS).map(|k| entry(k / UNKNOWNS, k % UNKNOWNS) / scales[k % UNKNOWNS]).collect()
    };
    let (linear, bent) = (matrix(), matrix());
    let target: Vec<f64> = (0..ROWS).map(|_| 3.0 * uniform()).collect();
    let model = move |x: &[f64], r: &mut [f64], j: &mut [f64]| {
        for i in 0..ROWS {
            let row = |m: &[f64]| (0..UNKNOWNS).map(|c| m[i * UNKNOWNS + c] * x[c]).sum::<f64>();
            let phase = row(&bent);
            r[i] = row(&linear) + 0.3 * phase.sin() - target[i];
            (0..UNKNOWNS).for_each(|c| {
                j[i * UNKNOWNS + c] = linear[i * UNKNOWNS + c] + 0.3 * phase.cos() * bent[i * UNKNOWNS + c]
            });
        }
    };
    let residual = Function { blocks: blocks.clone(), rows: ROWS, model: Box::new(model) };
    builder.add_factor(Factor::new(residual, Noise::independent(&[1.0; ROWS]).unwrap()));
    let affine = |uniform: &mut dyn FnMut() -> f64| {
        (0..UNKNOWNS).fold(Affine::default(), |f, c| f.plus(blocks[c / 3], c % 3, uniform() / scales[c]))
    };
    let values = builder.initial();
    for i in 0..UNKNOWNS {
        let room = 0.3 * scales[i] * (1.1 + uniform());
        builder.add_constraint(Constraint::bound(
            format!("bound {i}"),
            blocks[i / 3],
            i % 3,
            start[i] - room,
            start[i] + room,
        ));
    }
    for i in 0..3 {
        let function = affine(&mut uniform);
        let at = function.at(&values);
        builder.add_constraint(Constraint::range(format!("half-space {i}"), function, f64::NEG_INFINITY, at + 0.1));
        let norm_of: Vec<Affine> = (0..3).map(|_| affine(&mut uniform)).collect();
        let at_most = affine(&mut uniform);
        let length = norm_of.iter().map(|f| f.at(&values).powi(2)).sum::<f64>().sqrt();
        let room = length - at_most.at(&values) + 0.1;
        builder.add_constraint(Constraint::cone(format!("cone {i}"), norm_of, at_most.offset(room)));
    }
    let function = affine(&mut uniform);
    let at = function.at(&values);
    builder.add_constraint(Constraint::range("equation", function, at, at));
    builder.build().unwrap()
}

/// How far an estimate is from the conditions, in pure numbers: stationarity, feasibility, complementarity.
fn distances(problem: &Problem, estimate: &Estimate) -> [f64; 3] {
    let width = problem.columns().len() + 1;
    let rows = problem.augmented_jacobian(&estimate.values).unwrap();
    let residual = (2.0 * estimate.cost).sqrt();
    let column = |j: usize| rows.chunks_exact(width).map(move |row| (row[j], row[width - 1]));
    let norms: Vec<f64> = (0..width - 1).map(|j| column(j).map(|(a, _)| a * a).sum::<f64>().sqrt()).collect();
    let mut gradient: Vec<f64> = (0..width - 1).map(|j| column(j).map(|(a, r)| a * r).sum()).collect();
    let mut complementarity = 0.0_f64;
    for active in &estimate.active {
        let constraint = problem.constraints().iter().find(|c| c.name == active.name).unwrap();
        let slope = slope(problem, constraint, &estimate.values);
        slope.iter().for_each(|(j, c)| gradient[*j] += active.multiplier * c);
        if constraint.name != "equation" {
            assert!(active.multiplier > 0.0, "{active:?}");
        }
        let gap = constraint.violation(&estimate.values).abs() * active.multiplier.abs();
        complementarity = complementarity.max(gap / (residual * residual));
    }
    let stationarity = gradient.iter().zip(&norms).map(|(g, n)| g.abs() / (n * residual)).fold(0.0, f64::max);
    let violation = problem.constraints().iter().map(|c| c.violation(&estimate.values)).fold(0.0, f64::max);
    [stationarity, violation, complementarity]
}

/// Slope of what a constraint keeps from growing, at the limit that it is nearer to; of an equation, of its function.
fn slope(problem: &Problem, constraint: &Constraint, values: &Values) -> Vec<(usize, f64)> {
    let of = |f: &Affine, factor: f64| -> Vec<(usize, f64)> {
        f.terms.iter().map(|(id, i, c)| (problem.columns_of(*id).start + i, factor * c)).collect()
    };
    match &constraint.kind {
        ConstraintKind::Range { function, lower, upper } => {
            let value = function.at(values);
            let at_lower = lower < upper && value - lower < upper - value;
            of(function, if at_lower { -1.0 } else { 1.0 })
        }
        ConstraintKind::Cone { norm_of, at_most } => {
            let length = norm_of.iter().map(|f| f.at(values).powi(2)).sum::<f64>().sqrt();
            let side = norm_of.iter().flat_map(|f| of(f, f.at(values) / length));
            side.chain(of(at_most, -1.0)).collect()
        }
        ConstraintKind::Length { .. } => unreachable!(),
    }
}

fn check(name: &str, rank: usize, spread: f64) {
    let mut touched = 0;
    let mut worst = [0.0_f64; 3];
    for seed in 0..200 {
        let (problem, initial) = random_problem(seed, rank, spread);
        let estimate = solve(&problem, &initial).unwrap();
        assert!(estimate.termination.converged(), "{name} {seed}: {}", estimate.termination);
        let found = distances(&problem, &estimate);
        worst.iter_mut().zip(found).for_each(|(w, f)| *w = w.max(f));
        touched += estimate.active.len();
    }
    assert!(touched > 1000, "{name}: {touched} constraints touched");
    let [stationarity, violation, complementarity] = worst;
    assert!(stationarity < 1e-8 && violation < 1e-13 && complementarity < 1e-13, "{name}: {worst:?}");
}

#[test]
fn every_answer_obeys_the_conditions_of_optimality() {
    check("full rank", UNKNOWNS, 0.0);
    check("badly scaled", UNKNOWNS, 4.0);
    check("rank 4", 4, 0.0);
}
