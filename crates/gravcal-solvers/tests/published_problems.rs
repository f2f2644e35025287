//! Small problems whose solutions are known, run by every solver: a few published ones, a manifold, lost rank, and a model
//! that is not defined everywhere. The whole published collections are in `more_garbow_hillstrom.rs` and `nist.rs`.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use gravcal_estimation::published::more_garbow_hillstrom;
use gravcal_estimation::{
    Block, BlockId, EvaluateError, Factor, LocalValues, Noise, Problem, ProblemBuilder, RankAnalysis, Residual,
    Rotation, RowsMut, SolveContext, Sphere, Values, check_derivatives,
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

fn build(block: Block, start: &[f64], rows: usize, model: Model) -> (Problem, Values, BlockId) {
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

#[test]
fn published_minima_are_reached_from_the_standard_starts_and_called_converged() {
    let names = ["Rosenbrock", "Powell singular", "Bard", "Kowalik-Osborne"];
    let problems = more_garbow_hillstrom();
    for name in names {
        let problem = problems.iter().find(|p| p.name == name).unwrap();
        let (built, initial) = problem.build(&problem.starts[0]).unwrap();
        for solver in solvers(&built) {
            let estimate = solver.build().solve(&built, &initial, &mut SolveContext::default()).unwrap();
            assert!(estimate.termination.converged(), "{solver} on {name}: {}", estimate.termination);
            assert!(problem.minimum_at(2.0 * estimate.cost).is_some(), "{solver} on {name}: {:e}", estimate.cost);
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
    let block = Block::vector("v", "m", &["x", "y", "z"]).on(Sphere { radius: 6.0 });
    let (problem, initial, id) = build(block, &[6.0, 0.0, 0.0], 3, towards_a_point);
    for solver in solvers(&problem) {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        assert!(estimate.termination.converged());
        let found = estimate.values.get(id);
        assert!(found.iter().zip([2.0, 4.0, 4.0]).all(|(f, e)| (f - e).abs() < 1e-7), "{found:?}");
    }
}

/// `R(q)ᵀ a` of three vectors, less what it is for a third of a turn about (1, 1, 1): x is read as z was, y as x, z as y.
fn turned_vectors(q: &[f64], r: &mut [f64], j: &mut [f64]) {
    let [w, x, y, z] = [q[0], q[1], q[2], q[3]];
    let vectors = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 3.0]];
    for (k, [a, b, c]) in vectors.into_iter().enumerate() {
        let expected = [b, c, a];
        let value = [
            (w * w + x * x - y * y - z * z) * a + 2.0 * (x * y + w * z) * b + 2.0 * (x * z - w * y) * c,
            2.0 * (x * y - w * z) * a + (w * w - x * x + y * y - z * z) * b + 2.0 * (y * z + w * x) * c,
            2.0 * (x * z + w * y) * a + 2.0 * (y * z - w * x) * b + (w * w - x * x - y * y + z * z) * c,
        ];
        let slopes = [
            [w * a + z * b - y * c, x * a + y * b + z * c, x * b - y * a - w * c, x * c - z * a + w * b],
            [w * b - z * a + x * c, y * a - x * b + w * c, x * a + y * b + z * c, y * c - z * b - w * a],
            [w * c + y * a - x * b, z * a - x * c - w * b, z * b - y * c + w * a, x * a + y * b + z * c],
        ];
        for row in 0..3 {
            r[3 * k + row] = value[row] - expected[row];
            j[12 * k + 4 * row..][..4].copy_from_slice(&slopes[row].map(|slope| 2.0 * slope));
        }
    }
}

#[test]
fn a_rotation_stays_one_and_reaches_what_turns_the_vectors() {
    let block = Block::vector("q", "", &["w", "x", "y", "z"]).on(Rotation);
    let (problem, initial, id) = build(block, &[1.0, 0.0, 0.0, 0.0], 9, turned_vectors);
    for solver in solvers(&problem) {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        assert!(estimate.termination.converged(), "{solver}");
        let found = estimate.values.get(id);
        assert!(found.iter().all(|c| (c.abs() - 0.5).abs() < 1e-7), "{solver}: {found:?}");
        assert_eq!(RankAnalysis::new(&problem, &estimate.values).unwrap().rank(), 3);
    }
}

/// Only the sum is measured.
fn sum_of_two(x: &[f64], r: &mut [f64], j: &mut [f64]) {
    r.copy_from_slice(&[x[0] + x[1] - 3.0, 2.0 * (x[0] + x[1]) - 6.2]);
    j.copy_from_slice(&[1.0, 1.0, 2.0, 2.0]);
}

#[test]
fn a_direction_without_information_is_left_alone_and_named() {
    let (problem, initial, id) = build(numbers(2), &[5.0, 1.0], 2, sum_of_two);
    for solver in solvers(&problem) {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        let found = estimate.values.get(id);
        assert!(estimate.termination.converged());
        assert!((found[0] + found[1] - 3.08).abs() < 1e-9 && (found[0] - found[1] - 4.0).abs() < 1e-9);
        let analysis = RankAnalysis::new(&problem, &estimate.values).unwrap();
        assert_eq!(analysis.rank(), 1);
        let null = analysis.null_space_within(&[0, 1]);
        assert!((null[0][0] + null[0][1]).abs() < 1e-12);
        let determined = analysis.determined_within(&[0, 1], &[]);
        assert!((determined[0][0] - determined[0][1]).abs() < 1e-12);
        assert!((analysis.covariance().std_of(&[(0, 1.0), (1, 1.0)]) - 0.2f64.sqrt()).abs() < 1e-12);
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

/// `a sin t + b t` at t = 0, 1, …, 19 for a = 3 and b = 2: columns of the scales given.
fn of_scales(first: f64, second: f64) -> (Problem, Values, [BlockId; 2]) {
    #[derive(Debug)]
    struct Sum {
        blocks: [BlockId; 2],
        slopes: [f64; 2],
        reading: f64,
    }
    impl Residual for Sum {
        fn blocks(&self) -> &[BlockId] {
            &self.blocks
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
            residual[0] = self.slopes[0] * x.scalar(0) + self.slopes[1] * x.scalar(1) - self.reading;
            jacobian.into_iter().for_each(|mut rows| rows.row(0).copy_from_slice(&self.slopes));
            Ok(())
        }
    }
    let mut builder = ProblemBuilder::new();
    let blocks = ["a", "b"].map(|name| builder.add_block(Block::scalar(name, "").linear(), &[0.0]));
    for t in (0..20).map(f64::from) {
        let sum = Sum { blocks, slopes: [first * t.sin(), second * t], reading: 3.0 * t.sin() + 2.0 * t };
        builder.add_factor(Factor::new(sum, Noise::independent(&[0.01]).unwrap()));
    }
    let (problem, initial) = builder.build().unwrap();
    (problem, initial, blocks)
}

#[test]
fn the_scales_of_columns_change_nothing_even_where_a_block_starts_at_zero() {
    const SCALES: [f64; 5] = [1e-20, 1e-3, 1.0, 1e10, 1e20];
    for (first, second) in SCALES.into_iter().flat_map(|first| SCALES.map(|second| (first, second))) {
        let (problem, initial, blocks) = of_scales(first, second);
        for solver in solvers(&problem) {
            let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
            let [a, b] = blocks.map(|id| estimate.values.scalar(id));
            let reported = format!("{solver}, scales {first:e} and {second:e}: {}", estimate.termination);
            assert!(estimate.termination.converged(), "{reported}");
            assert!((a * first - 3.0).abs() < 1e-6 && (b * second - 2.0).abs() < 1e-6, "{reported}");
            assert_eq!(RankAnalysis::new(&problem, &estimate.values).unwrap().rank(), 2, "{reported}");
        }
    }
}
