//! What an estimator is handed: the method that minimises, who is told how far it is, and who may stop it.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

use gravcal_estimation::{Estimate, IterationRecord, Problem, SolveContext, SolveError, Solver, Termination, Values};

/// A brief solve ends where an iteration lowers the cost by no more than this share of it.
const SETTLED: f64 = 1e-4;

/// So many iterations that lower the cost by no more than this, for residuals of unit size, end a solve that has had [`PATIENCE`] of them. Before,
/// less ends it, and afterwards more, by the cube of their number.
const STILL: usize = 10;
const NOTHING: f64 = 1e-5;
/// Damping, relative to the column norms, of the step whose promise is looked at.
const WEIGHING_DAMPING: f64 = 1e-8;
/// An iteration that lowers the cost by less does not matter where ends are compared. Where residuals are far larger than noise, it is small: from
/// there the way to an end that explains them may be long.
const ROUGH: f64 = 1e-2;
/// Iterations after which a solve that creeps far above the noise is given up; the share of the cost that the second half of them must
/// take off; and the rms of whitened residuals that no noise explains.
const PATIENCE: usize = 100;
const LITTLE: f64 = 0.05;
const BEYOND_NOISE: f64 = 3.0;

/// A solver and a listener.
pub struct SolveEnvironment<'a> {
    solver: &'a dyn Solver,
    progress: &'a (dyn Fn(&str) + Sync),
    observer: &'a (dyn Fn(&IterationRecord) + Sync),
    stop: Option<&'a AtomicBool>,
    iterations: Option<usize>,
    enough: f64,
    /// A cost, and the iterations after which a solve is given up that is still above it.
    given_up: Option<(f64, usize)>,
}

impl<'a> SolveEnvironment<'a> {
    /// `progress` is told in a few words what is being done.
    pub fn new(solver: &'a dyn Solver, progress: &'a (dyn Fn(&str) + Sync)) -> Self {
        SolveEnvironment {
            solver,
            progress,
            observer: &|_| {},
            stop: None,
            iterations: None,
            enough: 0.0,
            given_up: None,
        }
    }

    /// The same with someone who is told of every iteration of the solver.
    #[must_use]
    pub fn observed_by(self, observer: &'a (dyn Fn(&IterationRecord) + Sync)) -> Self {
        SolveEnvironment { observer, ..self }
    }

    /// The same with another method.
    pub fn by<'b>(&self, solver: &'b dyn Solver) -> SolveEnvironment<'b>
    where
        'a: 'b,
    {
        SolveEnvironment { solver, ..*self }
    }

    /// The same with a flag that, set from elsewhere, stops the solver after its current iteration. What was being solved
    /// then has failed: its termination says so.
    #[must_use]
    pub fn stopped_by(self, stop: &'a AtomicBool) -> Self {
        SolveEnvironment { stop: Some(stop), ..self }
    }

    /// The same for solves of so many iterations at most.
    pub fn within(&self, iterations: usize) -> SolveEnvironment<'a> {
        let iterations = self.iterations.map_or(iterations, |most| most.min(iterations));
        SolveEnvironment { iterations: Some(iterations), ..*self }
    }

    /// The same for solves whose cost need not be known better than this: an iteration that lowers it by less is the last.
    pub fn to_within(&self, enough: f64) -> SolveEnvironment<'a> {
        SolveEnvironment { enough, ..*self }
    }

    /// The same for solves that are given up where after so many iterations they are still above this cost.
    pub(crate) fn unless_above(&self, cost: f64, iterations: usize) -> SolveEnvironment<'a> {
        SolveEnvironment { given_up: Some((cost, iterations)), ..*self }
    }

    /// How well the cost of solves need be known.
    pub(crate) fn enough(&self) -> f64 {
        self.enough
    }

    /// The same for solves whose ends are only compared (`ROUGH`).
    pub fn roughly(&self) -> SolveEnvironment<'a> {
        self.to_within(ROUGH)
    }

    /// Whether ends are only compared.
    pub fn is_rough(&self) -> bool {
        self.enough >= ROUGH
    }

    /// Whether someone asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Tells what is being done.
    pub fn report(&self, stage: &str) {
        (self.progress)(stage);
    }

    /// The method that minimises.
    pub fn solver(&self) -> &'a dyn Solver {
        self.solver
    }

    /// A few iterations from `initial`, of which nobody is told: so many at most, and no more where the cost is no higher than
    /// `enough`, or where one lowers it by next to nothing (`SETTLED`).
    pub fn solve_briefly(
        &self,
        problem: &Problem,
        initial: &Values,
        iterations: usize,
        enough: f64,
    ) -> Result<Estimate, SolveError> {
        let ends = AtomicBool::new(false);
        let mut before = f64::INFINITY;
        let mut observer = |record: &IterationRecord| {
            let stopped = self.stopped();
            let settled = before - record.cost <= SETTLED * record.cost;
            before = record.cost;
            let reached = record.cost <= enough || record.iteration >= iterations;
            ends.store(stopped || settled || reached, Ordering::Relaxed);
        };
        let mut context = SolveContext { observer: Some(&mut observer), stop: Some(&ends), checkpoint: None };
        self.solver.solve(problem, initial, &mut context)
    }

    /// Solves to the end.
    ///
    /// Along a curved valley of hardly any slope a method may creep for thousands of iterations. It has converged where `STILL` of them
    /// lowered the cost by next to nothing; and where the model contradicts the readings, one that has had `PATIENCE` of them at a cost
    /// beyond all noise, and has lowered it by little since half as many, ends without convergence.
    pub fn solve(&self, problem: &Problem, initial: &Values) -> Result<Estimate, SolveError> {
        self.solver.check(problem)?;
        let still = 2.0 * NOTHING / problem.rows().max(1) as f64;
        let hopeless = 0.5 * BEYOND_NOISE * BEYOND_NOISE * problem.rows() as f64;
        let (ends, end) = (AtomicBool::new(false), Cell::new(None));
        let mut costs: Vec<f64> = Vec::new();
        let mut observer = |record: &IterationRecord| {
            (self.observer)(record);
            costs.push(record.cost);
            let share_since = |iterations: usize| {
                let before = costs[costs.len().checked_sub(1 + iterations)?];
                (before > 0.0).then(|| (before - record.cost) / before)
            };
            let stopped = self.stopped();
            let lowered = costs.len().checked_sub(2).map_or(f64::INFINITY, |before| costs[before] - record.cost);
            end.set(match (share_since(STILL), share_since(PATIENCE / 2)) {
                _ if stopped => None,
                _ if (0.0..self.enough).contains(&lowered) => {
                    Some(Termination::Cost { relative: lowered / record.cost })
                }
                (Some(relative), _) if relative < still * (costs.len() as f64 / PATIENCE as f64).powi(3) => {
                    Some(Termination::Cost { relative })
                }
                (_, Some(share)) if costs.len() > PATIENCE && record.cost > hopeless && share < LITTLE => {
                    Some(Termination::IterationLimit { limit: costs.len() - 1 })
                }
                _ if self.given_up.is_some_and(|(cost, most)| costs.len() > most && record.cost > cost) => {
                    Some(Termination::IterationLimit { limit: costs.len() - 1 })
                }
                _ if self.iterations.is_some_and(|most| costs.len() > most) => {
                    Some(Termination::IterationLimit { limit: costs.len() - 1 })
                }
                _ => None,
            });
            ends.store(stopped || end.get().is_some(), Ordering::Relaxed);
        };
        let mut context = SolveContext { observer: Some(&mut observer), stop: Some(&ends), checkpoint: None };
        let estimate = self.solver.solve(problem, initial, &mut context)?;
        Ok(match (estimate.termination, end.get()) {
            (Termination::Stopped, Some(termination)) => Estimate { termination, ..estimate },
            (Termination::NoProgress, _) => at_rest(problem, estimate),
            _ => estimate,
        })
    }
}

/// An estimate from which no step was found that lowers the cost: converged if what the linear model still promises is next to nothing.
fn at_rest(problem: &Problem, estimate: Estimate) -> Estimate {
    let Ok(mut linearization) = problem.linearize(&estimate.values) else { return estimate };
    let scaling = linearization.column_scales();
    let mut step = vec![0.0; scaling.len()];
    let promise = linearization.damped_step(WEIGHING_DAMPING, &scaling, &mut step).predicted_reduction;
    let size = 2.0 * estimate.cost / problem.rows().max(1) as f64;
    let rests = promise <= NOTHING * size && problem.constraints().is_empty();
    let termination =
        if rests { Termination::Cost { relative: promise / estimate.cost } } else { estimate.termination };
    Estimate { termination, ..estimate }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Loss;

    use super::*;
    use crate::testing::{line, sensor, with_environment};

    const READINGS: [(f64, f64, f64); 4] = [(0.0, 1.2, 0.5), (1.0, 2.7, 0.5), (2.0, 5.3, 0.5), (3.0, 6.9, 0.5)];

    #[test]
    fn a_solve_that_may_not_go_on_says_why() {
        let (problem, start, _) = sensor(&READINGS, [100.0, 0.0, 0.0], &[1], Loss::None);
        let within =
            |environment: &SolveEnvironment<'_>| environment.within(5).within(1).solve(&problem, &start).unwrap();
        let estimate = with_environment(within);
        assert_eq!(estimate.termination, Termination::IterationLimit { limit: 1 });
        let unless_above = |cost: f64| with_environment(|w| w.unless_above(cost, 2).solve(&problem, &start)).unwrap();
        assert_eq!(unless_above(0.0).termination, Termination::IterationLimit { limit: 2 });
        assert!(unless_above(f64::INFINITY).termination.converged());
        let stop = AtomicBool::new(true);
        let stopped = with_environment(|w| w.within(100).stopped_by(&stop).solve(&problem, &start)).unwrap();
        assert_eq!(stopped.termination, Termination::Stopped);
    }

    #[test]
    fn a_solve_whose_cost_is_known_well_enough_is_over() {
        let (problem, start, _) = sensor(&READINGS, [100.0, 0.0, 0.0], &[1], Loss::None);
        let to_within =
            |enough: f64| with_environment(|w| w.within(50).to_within(enough).solve(&problem, &start)).unwrap();
        let [rough, exact] = [0.1, 0.0].map(to_within);
        assert!(rough.termination.converged() && rough.iterations.len() < exact.iterations.len());
        assert!((0.0..0.1).contains(&(rough.cost - exact.cost)), "{} {}", rough.cost, exact.cost);
    }

    #[test]
    fn a_brief_solve_ends_where_the_cost_is_low_enough() {
        let (problem, start, [gain, ..]) = sensor(&READINGS, [100.0, 0.0, 0.0], &[1], Loss::None);
        let brief =
            |most: usize, enough: f64| with_environment(|w| w.solve_briefly(&problem, &start, most, enough)).unwrap();
        assert!(brief(50, f64::INFINITY).iterations.len() < brief(50, 0.0).iterations.len());
        let (_, slope, _) = line(&READINGS);
        assert!((brief(50, 0.0).values.scalar(gain) - slope).abs() < 0.01);
    }
}
