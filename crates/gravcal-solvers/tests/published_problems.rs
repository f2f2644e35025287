//! Problems with published solutions, each written once with its source and optimum, run by every solver.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use gravcal_estimation::{
    Block, BlockId, EvaluateError, Factor, LocalValues, Manifold, Noise, Problem, ProblemBuilder, Residual, RowsMut,
    SolveContext, Spectrum, Values, check_derivatives,
};
use gravcal_solvers::SolverName;

/// Residual and Jacobian (row-major) of one problem over one block.
type Model = fn(&[f64], &mut [f64], &mut [f64]);

#[derive(Debug)]
struct Published {
    block: BlockId,
    rows: usize,
    model: Model,
}

impl Residual for Published {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.block)
    }

    fn len(&self) -> usize {
        self.rows
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let columns = x.block(0).len();
        let mut full = vec![0.0; self.rows * columns];
        (self.model)(x.block(0), residual, &mut full);
        if let Some(mut rows) = jacobian {
            for row in 0..self.rows {
                rows.row(row).copy_from_slice(&full[row * columns..(row + 1) * columns]);
            }
        }
        Ok(())
    }
}

fn pose(block: Block, start: &[f64], rows: usize, model: Model) -> (Problem, Values, BlockId) {
    let mut builder = ProblemBuilder::new();
    let id = builder.add_block(block, start);
    let residual = Published { block: id, rows, model };
    check_derivatives(&residual, &[start.len()], start, 1e-7).unwrap();
    builder.add_factor(Factor::new(residual, Noise::independent(&vec![1.0; rows]).unwrap()));
    let (problem, initial) = builder.build().unwrap();
    (problem, initial, id)
}

/// The methods that take a problem.
fn solvers(problem: &Problem) -> Vec<SolverName> {
    let taken: Vec<SolverName> =
        SolverName::ALL.into_iter().filter(|solver| solver.build().check(problem).is_ok()).collect();
    assert!(taken.len() >= 3);
    taken
}

fn numbers(count: usize) -> Block {
    let names: Vec<String> = (0..count).map(|i| i.to_string()).collect();
    Block::vector("x", "", &names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Moré, Garbow, Hillstrom (1981), problem 1: Rosenbrock.
fn rosenbrock(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    r.copy_from_slice(&[10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
    j.copy_from_slice(&[-20.0 * x[0], 10.0, -1.0, 0.0]);
}

/// The same, problem 13: Powell's singular function, whose Jacobian loses rank at the solution.
fn powell_singular(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    let (a, b) = (x[1] - 2.0 * x[2], x[0] - x[3]);
    let (five, ten) = (5f64.sqrt(), 10f64.sqrt());
    r.copy_from_slice(&[x[0] + 10.0 * x[1], five * (x[2] - x[3]), a * a, ten * b * b]);
    #[rustfmt::skip]
    j.copy_from_slice(&[
        1.0, 10.0, 0.0, 0.0,
        0.0, 0.0, five, -five,
        0.0, 2.0 * a, -4.0 * a, 0.0,
        2.0 * ten * b, 0.0, 0.0, -2.0 * ten * b,
    ]);
}

/// The same, problem 8: Bard. Minimum Σr² = 8.21487e-3.
fn bard(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    const Y: [f64; 15] = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    for i in 0..15 {
        let u = (i + 1) as f64;
        let (v, w) = (16.0 - u, u.min(16.0 - u));
        let d = v * x[1] + w * x[2];
        r[i] = Y[i] - (x[0] + u / d);
        j[3 * i..3 * i + 3].copy_from_slice(&[-1.0, u * v / (d * d), u * w / (d * d)]);
    }
}

/// The same, problem 15: Kowalik and Osborne. Minimum Σr² = 3.07505e-4.
fn kowalik_osborne(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    const Y: [f64; 11] = [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
    const U: [f64; 11] = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];
    for i in 0..11 {
        let (n, d) = (U[i] * U[i] + U[i] * x[1], U[i] * U[i] + U[i] * x[2] + x[3]);
        r[i] = Y[i] - x[0] * n / d;
        let f = x[0] * n / (d * d);
        j[4 * i..4 * i + 4].copy_from_slice(&[-n / d, -x[0] * U[i] / d, f * U[i], f]);
    }
}

#[test]
fn published_minima_are_reached_from_the_standard_starts() {
    let problems: [(&str, Vec<f64>, usize, Model, f64); 4] = [
        ("Rosenbrock", vec![-1.2, 1.0], 2, rosenbrock, 0.0),
        ("Powell singular", vec![3.0, -1.0, 0.0, 1.0], 4, powell_singular, 0.0),
        ("Bard", vec![1.0, 1.0, 1.0], 15, bard, 8.21487e-3),
        ("Kowalik-Osborne", vec![0.25, 0.39, 0.415, 0.39], 11, kowalik_osborne, 3.07505e-4),
    ];
    for (name, start, rows, model, minimum) in &problems {
        let (problem, initial, _) = pose(numbers(start.len()), start, *rows, *model);
        for solver in solvers(&problem) {
            let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
            let found = 2.0 * estimate.cost;
            assert!(estimate.termination.converged(), "{solver} on {name}: {}", estimate.termination);
            assert!(
                (found - minimum).abs() <= 1e-5 * minimum + 1e-20,
                "{solver} on {name}: {found:e}, not {minimum:e}"
            );
        }
    }
}

/// Closest point to (1, 2, 2) on the sphere of radius 6: (2, 4, 4).
fn towards_a_point(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    r.copy_from_slice(&[x[0] - 1.0, x[1] - 2.0, x[2] - 2.0]);
    j.copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_vector_on_a_sphere_stays_there_and_reaches_the_closest_point() {
    let block = Block::vector("v", "m", &["x", "y", "z"]).on(Manifold::Sphere { radius: 6.0 });
    let (problem, initial, id) = pose(block, &[6.0, 0.0, 0.0], 3, towards_a_point);
    for solver in solvers(&problem) {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        assert!(estimate.termination.converged());
        let found = estimate.values.get(id);
        assert!(found.iter().zip([2.0, 4.0, 4.0]).all(|(f, e)| (f - e).abs() < 1e-7), "{found:?}");
    }
}

/// Only the sum is measured.
fn sum_of_two(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    r.copy_from_slice(&[x[0] + x[1] - 3.0, 2.0 * (x[0] + x[1]) - 6.2]);
    j.copy_from_slice(&[1.0, 1.0, 2.0, 2.0]);
}

#[test]
fn a_direction_without_information_is_left_alone_and_named() {
    let (problem, initial, id) = pose(numbers(2), &[5.0, 1.0], 2, sum_of_two);
    for solver in solvers(&problem) {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        let found = estimate.values.get(id);
        assert!(estimate.termination.converged());
        assert!((found[0] + found[1] - 3.08).abs() < 1e-9 && (found[0] - found[1] - 4.0).abs() < 1e-9);
        let spectrum = Spectrum::new(&problem, &estimate.values).unwrap();
        assert_eq!(spectrum.rank(), 1);
        let null = spectrum.null_space_within(&[0, 1]);
        assert!((null[0][0] + null[0][1]).abs() < 1e-12);
        let determined = spectrum.determined_within(&[0, 1]);
        assert!((determined[0][0] - determined[0][1]).abs() < 1e-12);
        assert!((spectrum.covariance().std_of(&[(0, 1.0), (1, 1.0)]) - 0.2f64.sqrt()).abs() < 1e-12);
    }
}

/// No value beyond 2: a solver must shorten its step, not fail.
#[derive(Debug)]
struct Bounded(BlockId);

impl Residual for Bounded {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.0)
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let x = x.scalar(0);
        if x >= 2.0 {
            return Err(EvaluateError("beyond 2".into()));
        }
        residual[0] = (2.0 - x).ln();
        if let Some(mut rows) = jacobian {
            rows.row(0)[0] = -1.0 / (2.0 - x);
        }
        Ok(())
    }
}

#[test]
fn a_step_to_where_the_model_has_no_value_is_shortened() {
    let mut builder = ProblemBuilder::new();
    let id = builder.add_block(Block::scalar("x", ""), &[-50.0]);
    builder.add_factor(Factor::new(Bounded(id), Noise::independent(&[1.0]).unwrap()));
    let (problem, initial) = builder.build().unwrap();
    for solver in solvers(&problem) {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        assert!((estimate.values.scalar(id) - 1.0).abs() < 1e-9, "{}", estimate.termination);
        let mut outside = initial.clone();
        outside.set(id, &[3.0]);
        let error = solver.build().solve(&problem, &outside, &mut SolveContext::default()).unwrap_err();
        assert_eq!(error.to_string(), "the start cannot be evaluated: beyond 2");
    }
}
