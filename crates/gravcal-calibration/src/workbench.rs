//! What an estimator is handed: the method that minimises, who is told how far it is, and who may stop it.

use std::sync::atomic::{AtomicBool, Ordering};

use gravcal_estimation::{Estimate, IterationRecord, Problem, SolveContext, SolveError, Solver, Termination, Values};

/// A brief solve ends where an iteration lowers the cost by no more than this share of it.
const SETTLED: f64 = 1e-4;

/// Iterations after which a solve that creeps far above the noise is given up; the share of the cost that the second half of them must
/// take off; and the rms of whitened residuals that no noise explains.
const PATIENCE: usize = 100;
const LITTLE: f64 = 0.05;
const BEYOND_NOISE: f64 = 3.0;

/// A solver and a listener.
pub struct Workbench<'a> {
    solver: &'a dyn Solver,
    progress: &'a (dyn Fn(&str) + Sync),
    observer: &'a (dyn Fn(&IterationRecord) + Sync),
    stop: Option<&'a AtomicBool>,
}

impl<'a> Workbench<'a> {
    /// `progress` is told in a few words what is being done.
    pub fn new(solver: &'a dyn Solver, progress: &'a (dyn Fn(&str) + Sync)) -> Self {
        Workbench { solver, progress, observer: &|_| {}, stop: None }
    }

    /// The same with someone who is told of every iteration of the solver.
    pub fn observed_by(self, observer: &'a (dyn Fn(&IterationRecord) + Sync)) -> Self {
        Workbench { observer, ..self }
    }

    /// The same with a flag that, set from elsewhere, stops the solver after its current iteration. What was being solved
    /// then has failed: its termination says so.
    pub fn stopped_by(self, stop: &'a AtomicBool) -> Self {
        Workbench { stop: Some(stop), ..self }
    }

    /// Tells what is being done.
    pub(crate) fn tell(&self, stage: &str) {
        (self.progress)(stage);
    }

    pub(crate) fn solver(&self) -> &dyn Solver {
        self.solver
    }

    /// A few iterations from `initial`, of which nobody is told: so many at most, and no more where the cost is no higher than
    /// `enough`, or where one lowers it by next to nothing ([`SETTLED`]).
    pub(crate) fn solve_briefly(
        &self,
        problem: &Problem,
        initial: &Values,
        iterations: usize,
        enough: f64,
    ) -> Result<Estimate, SolveError> {
        let ends = AtomicBool::new(false);
        let mut before = f64::INFINITY;
        let mut observer = |record: &IterationRecord| {
            let stopped = self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
            let settled = before - record.cost <= SETTLED * record.cost;
            before = record.cost;
            let reached = record.cost <= enough || record.iteration >= iterations;
            ends.store(stopped || settled || reached, Ordering::Relaxed);
        };
        let mut context = SolveContext { observer: Some(&mut observer), stop: Some(&ends), checkpoint: None };
        self.solver.solve(problem, initial, &mut context)
    }

    /// Solves to the end. Where the model contradicts the readings a method may creep for thousands of iterations: one that has had
    /// [`PATIENCE`] of them at a cost beyond all noise, and has lowered it by little since half as many, ends without convergence.
    pub(crate) fn solve(&self, problem: &Problem, initial: &Values) -> Result<Estimate, SolveError> {
        self.solver.check(problem)?;
        let hopeless = 0.5 * BEYOND_NOISE * BEYOND_NOISE * problem.rows() as f64;
        let (ends, given_up) = (AtomicBool::new(false), AtomicBool::new(false));
        let mut costs: Vec<f64> = Vec::new();
        let mut observer = |record: &IterationRecord| {
            (self.observer)(record);
            costs.push(record.cost);
            let before = costs.len().checked_sub(PATIENCE).map(|first| costs[first + PATIENCE / 2]);
            let creeps = before.is_some_and(|before| record.cost > hopeless && before - record.cost < LITTLE * before);
            let stopped = self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed));
            given_up.store(creeps && !stopped, Ordering::Relaxed);
            ends.store(creeps || stopped, Ordering::Relaxed);
        };
        let mut context = SolveContext { observer: Some(&mut observer), stop: Some(&ends), checkpoint: None };
        let estimate = self.solver.solve(problem, initial, &mut context)?;
        Ok(match (estimate.termination, given_up.into_inner()) {
            (Termination::Stopped, true) => {
                let limit = estimate.iterations.len() - 1;
                Estimate { termination: Termination::IterationLimit { limit }, ..estimate }
            }
            _ => estimate,
        })
    }
}
