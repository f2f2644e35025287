//! The constrained method on problems without constraints: under a bound that is far from everything.

use gravcal_estimation::{Constraint, Estimate, Problem, SolveContext, SolveError, Solver, Unsupported, Values};
use gravcal_solvers::Clarabel;

/// Farther than any solution.
const FAR: f64 = 1e9;

/// `clarabel` with a bound on the first unknown that holds nothing.
#[derive(Default)]
pub struct InactiveBound(Clarabel);

impl Solver for InactiveBound {
    fn name(&self) -> &'static str {
        "clarabel, with a bound that is inactive"
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        self.0.check(problem)
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        let first = problem.block_ids().next().ok_or(SolveError::NoUnknowns)?;
        let inactive = Constraint::bound("far away", first, 0, -FAR, FAR);
        let bounded = problem
            .with_constraints(vec![inactive])
            .map_err(|error| SolveError::Failed { solver: self.name(), reason: error.to_string() })?;
        self.0.solve(&bounded, initial, context)
    }
}
