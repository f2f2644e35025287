//! Vectors of known length.

use gravcal_estimation::{
    Block, BlockId, Constraint, Estimate, Factor, Noise, Problem, ProblemBuilder, SolveContext, Solver, Sphere, Values,
};
use gravcal_solvers::{Clarabel, SolverName};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::build::{Function, active, block, near, readings, solve};

/// Hock and Schittkowski 42: Σ (x_i − i)² with x1 = 2 and x3² + x4² = 2 is 28 − 10 √2 at (2, 2, 0.6 √2, 0.8 √2). By the
/// length L of (x3, x4) the cost is ½ (5 − L)²: it falls by 5 − √2 for each unit of L, and rises by 1 for each of x1.
#[test]
fn number_42_of_hock_and_schittkowski() {
    let mut builder = ProblemBuilder::new();
    let first = builder.add_block(block("first", 2), &[2.0, 1.0]);
    let second = builder.add_block(block("second", 2), &[1.0, 1.0]);
    readings(&mut builder, first, &[1.0, 2.0]);
    readings(&mut builder, second, &[3.0, 4.0]);
    builder.add_constraint(Constraint::bound("x1", first, 0, 2.0, 2.0));
    builder.add_constraint(Constraint::length("circle", second, 2f64.sqrt()));
    let (problem, initial) = builder.build().unwrap();
    let estimate = solve(&problem, &initial).unwrap();
    let root = 2f64.sqrt();
    assert!(estimate.termination.converged(), "{}", estimate.termination);
    assert!(near(estimate.values.as_slice(), &[2.0, 2.0, 0.6 * root, 0.8 * root], 1e-9), "{:?}", estimate.values);
    assert!((2.0 * estimate.cost - (28.0 - 10.0 * root)).abs() < 1e-12);
    let [("x1", of_x1), ("circle", of_circle)] = active(&estimate)[..] else { panic!("{:?}", estimate.active) };
    assert!((of_x1 + 1.0).abs() < 1e-9 && (of_circle - (5.0 - root)).abs() < 1e-8, "{of_x1}, {of_circle}");
}

const LENGTH: f64 = 9.81;

/// Readings `k_i a_ijᵀ g + b_i` of gravity by three sensors of unknown gain and bias, one gain known by a reading of its own,
/// with errors of 5 %: residuals stay.
fn sensors(seed: u64, on_sphere: bool) -> (Problem, Values, BlockId) {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut uniform = |size: f64| random.random_range(-size..size);
    let truth: [f64; 3] = std::array::from_fn(|_| uniform(1.0));
    let size = truth.iter().map(|c| c * c).sum::<f64>().sqrt();
    let rows: Vec<[f64; 3]> = (0..30).map(|_| std::array::from_fn(|_| uniform(1.0))).collect();
    let reading = |row: &[f64; 3]| 1.3 * LENGTH / size * (0..3).map(|i| row[i] * truth[i]).sum::<f64>() + 0.2;
    let read: Vec<f64> = rows.iter().map(|row| reading(row) + uniform(0.5)).collect();
    let mut builder = ProblemBuilder::new();
    let gravity = Block::vector("g", "m/s²", &["x", "y", "z"]);
    // Within half a radian of the truth: methods that go different ways may else end in different minima.
    let aside: [f64; 3] = std::array::from_fn(|i| truth[i] / size + uniform(0.25));
    let start = aside.map(|c| LENGTH * c / aside.iter().map(|c| c * c).sum::<f64>().sqrt());
    let gravity = if on_sphere {
        builder.add_block(gravity.on(Sphere { radius: LENGTH }), &start)
    } else {
        let id = builder.add_block(gravity, &start);
        builder.add_constraint(Constraint::length("magnitude of gravity", id, LENGTH));
        id
    };
    let gain = builder.add_block(Block::scalar("k", ""), &[1.0]);
    readings(&mut builder, gain, &[1.0]);
    let bias = builder.add_block(Block::scalar("b", ""), &[0.0]);
    let model = move |x: &[f64], r: &mut [f64], j: &mut [f64]| {
        for (i, row) in rows.iter().enumerate() {
            let torque: f64 = (0..3).map(|c| row[c] * x[c]).sum();
            r[i] = x[3] * torque + x[4] - read[i];
            (0..3).for_each(|c| j[5 * i + c] = x[3] * row[c]);
            (j[5 * i + 3], j[5 * i + 4]) = (torque, 1.0);
        }
    };
    let residual = Function { blocks: vec![gravity, gain, bias], rows: 30, model: Box::new(model) };
    builder.add_factor(Factor::new(residual, Noise::independent(&[0.3; 30]).unwrap()));
    let (problem, initial) = builder.build().unwrap();
    (problem, initial, gravity)
}

#[test]
fn a_length_as_equation_agrees_with_the_sphere() {
    for seed in 0..20 {
        let (problem, initial, gravity) = sensors(seed, true);
        let on_sphere = |solver: &dyn Solver| solver.solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        let reference: Estimate = on_sphere(SolverName::LevenbergMarquardt.build().as_ref());
        let same: Estimate = on_sphere(&Clarabel::default());
        let (problem, initial, _) = sensors(seed, false);
        let equation = solve(&problem, &initial).unwrap();
        for (what, other) in [("sphere", &same), ("equation", &equation)] {
            assert!(other.termination.converged(), "{what}, seed {seed}: {}", other.termination);
            let ratio = other.cost / reference.cost;
            assert!(reference.cost > 1.0 && (ratio - 1.0).abs() < 1e-12, "{what}, seed {seed}: {ratio}");
            let (found, expected) = (other.values.as_slice(), reference.values.as_slice());
            assert!(near(found, expected, 1e-8), "{what}, seed {seed}: {found:?}, not {expected:?}");
        }
        let size = equation.values.get(gravity).iter().map(|c| c * c).sum::<f64>().sqrt();
        assert!((size - LENGTH).abs() < 1e-14, "{size}");
    }
}
