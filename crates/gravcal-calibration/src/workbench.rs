//! What an estimator is handed: the method that minimises, and who is told how far it is.

use gravcal_estimation::{Estimate, Problem, SolveContext, SolveError, Solver, Values};

/// A solver and a listener.
pub struct Workbench<'a> {
    solver: &'a dyn Solver,
    progress: &'a (dyn Fn(&str) + Sync),
}

impl<'a> Workbench<'a> {
    /// `progress` is told in a few words what is being done.
    pub fn new(solver: &'a dyn Solver, progress: &'a (dyn Fn(&str) + Sync)) -> Self {
        Workbench { solver, progress }
    }

    /// Tells what is being done.
    pub(crate) fn tell(&self, stage: &str) {
        (self.progress)(stage);
    }

    pub(crate) fn solver(&self) -> &dyn Solver {
        self.solver
    }

    pub(crate) fn solve(&self, problem: &Problem, initial: &Values) -> Result<Estimate, SolveError> {
        self.solver.check(problem)?;
        self.solver.solve(problem, initial, &mut SolveContext::default())
    }
}
