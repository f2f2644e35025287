//! Two groups of readings, of which the first leaves a direction open: a product, then its factors.

use super::*;
use crate::testing::{Line, Newton};
use crate::{
    Block, BlockId, EvaluateError, LocalValues, Noise, Problem, ProblemBuilder, Residual, RowsMut, SolveContext,
    Solver, Sphere, check_derivatives,
};

const UNREAD: &str = "not read yet";

/// `a b sin(q s) − y` for several q.
#[derive(Debug)]
struct Product {
    blocks: [BlockId; 3],
    rows: Vec<(f64, f64)>,
}

impl Residual for Product {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let [a, b, s] = [0, 1, 2].map(|block| x.scalar(block));
        for (row, (q, y)) in self.rows.iter().enumerate() {
            let (sin, cos) = (q * s).sin_cos();
            residual[row] = a * b * sin - y;
            if let Some(rows) = jacobian.as_mut() {
                rows.row(row).copy_from_slice(&[b * sin, a * sin, a * b * q * cos]);
            }
        }
        Ok(())
    }
}

/// Rows of the product, whose errors have the given size; then `a` and `b` themselves. Truth: a = 2, b = 3, s = 1.
fn problem(error: f64) -> (Problem, Values, usize) {
    let mut builder = ProblemBuilder::new();
    let blocks =
        [("a", 0.5), ("b", 5.0), ("s", 1.1)].map(|(name, start)| builder.add_block(Block::scalar(name, ""), &[start]));
    let errors = [0.3, -1.2, 0.8, 1.1, -0.6, -0.4, 0.9, -1.5];
    let rows: Vec<(f64, f64)> = errors
        .iter()
        .enumerate()
        .map(|(i, e)| {
            let q = 0.25 * (i + 1) as f64;
            (q, 6.0 * q.sin() + error * e)
        })
        .collect();
    let count = rows.len();
    builder.add_factor(Factor::new(Product { blocks, rows }, Noise::independent(&vec![error; count]).unwrap()));
    for (block, reading) in [(0, 2.0 + 0.7 * error), (1, 3.0 + 0.9 * error)] {
        let known = Line::new(&blocks[block..=block], &[1.0], reading);
        builder.add_factor(Factor::new(known, Noise::independent(&[error]).unwrap()));
    }
    let (problem, initial) = builder.build().unwrap();
    (problem, initial, count)
}

fn solve(problem: &Problem, from: &Values) -> Values {
    Newton.solve(problem, from, &mut SolveContext::default()).unwrap().values
}

/// Largest difference from the solution of everything at once, in units of the noise, where the product is passed on in
/// one form and then `a` and `b` are read.
fn departure(error: f64, passed_on: impl Fn(&Problem, &Problem, &Values, &[usize]) -> Factor) -> f64 {
    let (problem, initial, count) = problem(error);
    let rows: Vec<usize> = (0..count).collect();
    let first = problem.with_only(vec![selected(&problem, &rows)], UNREAD).unwrap();
    let after_first = solve(&first, &initial);
    let product = passed_on(&problem, &first, &after_first, &rows);
    let then = problem.with_only(vec![product, selected(&problem, &[count, count + 1])], UNREAD).unwrap();
    let [found, all] = [solve(&then, &after_first), solve(&problem, &initial)];
    let apart = found.as_slice().iter().zip(all.as_slice()).map(|(found, all)| (found - all).abs() / error);
    apart.fold(0.0, f64::max)
}

#[test]
fn what_is_condensed_stays_right_however_far_an_open_direction_is_moved() {
    let departure = |error| {
        departure(error, |problem, _, values, rows| {
            let condensed = condensed(problem, rows, values).unwrap().unwrap();
            assert_eq!(condensed.residual.len(), 2, "the product and s");
            condensed
        })
    };
    let (rough, fine) = (departure(1e-2), departure(1e-4));
    assert!(rough < 0.05 && fine < 0.02 * rough, "{rough:e} {fine:e}");
}

#[test]
fn what_is_linearized_does_not() {
    let departure = |error| departure(error, |_, first, values, _| linearized(first, values).unwrap());
    assert!(departure(1e-4) > 100.0, "{:e}", departure(1e-4));
}

/// With everything determined before it is passed on, what is linearized is as good.
#[test]
fn what_is_linearized_is_right_where_everything_was_determined() {
    let departure = |error: f64| {
        let (problem, initial, count) = problem(error);
        // The last two rows of the product come later.
        let [first, later] = [(0..count - 2).chain([count, count + 1]).collect(), vec![count - 2, count - 1]]
            .map(|rows: Vec<usize>| selected(&problem, &rows));
        let first = problem.with_only(vec![first], UNREAD).unwrap();
        let after_first = solve(&first, &initial);
        let factors = vec![linearized(&first, &after_first).unwrap(), later];
        let found = solve(&problem.with_only(factors, UNREAD).unwrap(), &after_first);
        let all = solve(&problem, &initial);
        found.as_slice().iter().zip(all.as_slice()).map(|(a, b)| (a - b).abs() / error).fold(0.0, f64::max)
    };
    let (rough, fine) = (departure(1e-2), departure(1e-4));
    assert!(rough < 0.2 && fine < 0.02 * rough, "{rough:e} {fine:e}");
}

/// All of the information, on a sphere and with correlated rows: the same covariance and, of a linear problem, the same cost.
#[test]
fn what_is_linearized_knows_as_much() {
    let mut builder = ProblemBuilder::new();
    let sphere = Block::vector("g", "m/s²", &["x", "y", "z"]).on(Sphere { radius: 5.0 });
    let blocks = [builder.add_block(sphere, &[3.0, 0.0, 4.0]), builder.add_block(Block::scalar("a", ""), &[2.0])];
    for (coefficients, reading) in
        [([1.0, 2.0, 0.0, 1.0], 4.9), ([0.0, 1.0, 1.0, -1.0], 2.2), ([1.0, 0.0, -1.0, 2.0], 3.1)]
    {
        let line = Line::new(&blocks, &coefficients, reading);
        builder.add_factor(Factor::new(line, Noise::correlated(&[0.04], 1).unwrap()));
    }
    let (problem, initial) = builder.build().unwrap();
    let values = solve(&problem, &initial);
    let summary = problem.with_only(vec![linearized(&problem, &values).unwrap()], UNREAD).unwrap();
    let [all, passed_on] = [&problem, &summary].map(|p| crate::RankAnalysis::new(p, &values).unwrap().covariance());
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        assert!((all.at(i, j) - passed_on.at(i, j)).abs() < 1e-12, "{i} {j}");
    }
    let step = [0.0, 0.0, 0.3];
    let grown = |p: &Problem| p.cost(&p.retract(&values, &step)).unwrap() - p.cost(&values).unwrap();
    assert!((grown(&problem) - grown(&summary)).abs() < 1e-9);
}

#[test]
fn derivatives() {
    let (problem, initial, count) = problem(0.1);
    let rows: Vec<usize> = (0..=count).collect();
    let condensed = condensed(&problem, &rows, &initial).unwrap().unwrap();
    check_derivatives(&*condensed.residual, &[1; 3], &[1.5, 2.5, 0.9], 1e-8).unwrap();
    let linearized = linearized(&problem, &initial).unwrap();
    check_derivatives(&*linearized.residual, &[1; 3], &[1.5, 2.5, 0.9], 1e-8).unwrap();
}

#[test]
fn eliminated_blocks_are_refused_and_rows_without_an_effect_give_nothing() {
    let mut builder = ProblemBuilder::new();
    let x = builder.add_block(Block::scalar("x", "m"), &[0.0]);
    let own = builder.add_block(Block::scalar("own", "m").eliminated(), &[0.0]);
    let unit = || Noise::independent(&[1.0]).unwrap();
    builder.add_factor(Factor::new(Line::new(&[x, own], &[1.0, 1.0], 1.0), unit()));
    builder.add_factor(Factor::new(Line::new(&[own], &[1.0], 0.0), unit()));
    builder.add_factor(Factor::new(Line::new(&[x], &[0.0], 1.0), unit()));
    let (problem, initial) = builder.build().unwrap();
    assert!(linearized(&problem, &initial).unwrap_err().to_string().contains("eliminated"));
    assert!(condensed(&problem, &[2], &initial).unwrap().is_none());
}
