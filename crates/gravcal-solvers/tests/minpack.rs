//! Agreement with MINPACK, in its Rust port (crate `levenberg-marquardt`), on the problems of Moré, Garbow and Hillstrom.
//!
//! Both methods are local, so that from a far start each may end in another minimum. Ours must end no higher; where it
//! ends lower, the differences are printed.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use gravcal_estimation::published::{PublishedProblem, Start, more_garbow_hillstrom};
use gravcal_estimation::{Problem, SolveContext, Values};
use gravcal_solvers::SolverName;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// Sums of squares agree to this share; both methods stop when theirs falls no further.
const AGREEMENT: f64 = 1e-7;

/// Sums of squares below this are zero.
const ZERO: f64 = 1e-16;

/// A problem as MINPACK takes it.
struct Lent<'p> {
    problem: &'p Problem,
    values: Values,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Lent<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        for (id, value) in self.problem.block_ids().zip(x.iter()) {
            self.values.set(id, &[*value]);
        }
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_row_slice(self.values.as_slice())
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.problem.residuals(&self.values).ok().map(DVector::from_vec)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns = self.problem.columns().len();
        let rows = self.problem.augmented_jacobian(&self.values).ok()?;
        Some(DMatrix::from_row_slice(self.problem.rows(), columns + 1, &rows).remove_column(columns))
    }
}

/// The sum of squares where MINPACK ends with its own tolerances and limits: infinite where it meets a point at which
/// the residuals are not finite, for its port ends there.
fn minpack(problem: &PublishedProblem, start: &Start) -> f64 {
    let (built, values) = problem.build(start).unwrap();
    let (end, _) = LevenbergMarquardt::new().minimize(Lent { problem: &built, values });
    built.cost(&end.values).map_or(f64::INFINITY, |cost| 2.0 * cost)
}

fn ours(problem: &PublishedProblem, start: &Start) -> f64 {
    let (built, initial) = problem.build(start).unwrap();
    let estimate = SolverName::LevenbergMarquardt.build().solve(&built, &initial, &mut SolveContext::default());
    estimate.map_or(f64::INFINITY, |estimate| 2.0 * estimate.cost)
}

#[test]
fn levenberg_marquardt_ends_no_higher_than_minpack() {
    let mut worse = Vec::new();
    for problem in more_garbow_hillstrom() {
        for start in problem.starts.iter().filter(|start| start.unreachable.is_none()) {
            let (ours, theirs) = (ours(&problem, start), minpack(&problem, start));
            let tolerance = (AGREEMENT * theirs.min(ours)).max(ZERO);
            let difference = format!("{}, {}: {ours:e}, MINPACK {theirs:e}", problem.name, start.name);
            if ours > theirs + tolerance {
                worse.push(difference);
            } else if ours < theirs - tolerance {
                println!("lower: {difference}");
            }
        }
    }
    assert!(worse.is_empty(), "{}", worse.join("\n"));
}

#[test]
fn what_is_said_to_be_out_of_reach_is_so_for_minpack_too() {
    for problem in more_garbow_hillstrom() {
        for start in problem.starts.iter().filter(|start| start.unreachable.is_some()) {
            let end = minpack(&problem, start);
            assert!(problem.minimum_at(end).is_none(), "{}, {}: MINPACK reaches {end:e}", problem.name, start.name);
        }
    }
}
