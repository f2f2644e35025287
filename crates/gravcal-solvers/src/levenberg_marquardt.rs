//! Levenberg-Marquardt, as an argmin [`Solver`](argmin::core::Solver); the linear algebra is faer's.
//!
//! Each iteration minimises the damped linear model
//!
//! ```text
//!     ½ ‖J δ + r‖² + ½ λ ‖D δ‖²
//! ```
//!
//! and moves to `x ⊞ δ` if the cost falls. `D` holds the largest norm that each column of J has had so far (Moré,
//! *The Levenberg-Marquardt algorithm: implementation and theory*, 1978, eq. 6.3), so that the path does not
//! depend on units. `λ` follows the ratio of actual to predicted reduction as Nielsen proposes (*Damping parameter
//! in Marquardt's method*, IMM-REP-1999-05, eq. 2.5). Steps come from a QR factorization, so a direction without
//! information is simply not moved along: rank-deficient problems converge to a point of their valley.
//!
//! Left out of the sources: Moré's trust-region radius (λ is damped directly) and geodesic acceleration.

use std::cell::RefCell;

use argmin::core::{
    CostFunction, Error, Executor, IterState, KV, Problem as Counted, Solver as ArgminSolver, State, TerminationReason,
};
use gravcal_estimation::{
    Estimate, EvaluateError, IterationRecord, Linearization, Problem, SolveContext, SolveError, Solver, Termination,
    Unsupported, Values,
};

pub(crate) const NAME: &str = "levenberg-marquardt";

/// The method's options.
#[derive(Clone, Debug, PartialEq)]
pub struct LevenbergMarquardt {
    /// Iterations allowed.
    pub max_iterations: usize,
    /// Ends where the largest |cosine| between the residual and a column of J is at most this.
    pub cosine_tolerance: f64,
    /// Ends where the step of every block is at most this share of the block or of the residual, scaled by D.
    pub step_tolerance: f64,
    /// Ends where predicted and actual reduction are at most this share of the cost.
    pub cost_tolerance: f64,
}

impl Default for LevenbergMarquardt {
    fn default() -> Self {
        LevenbergMarquardt {
            max_iterations: 200,
            cosine_tolerance: 1e-10,
            step_tolerance: 1e-13,
            cost_tolerance: 1e-15,
        }
    }
}

impl Solver for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        NAME
    }

    /// Takes every problem without constraints: fewer rows than unknowns and lost rank are left to the damping.
    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        match problem.constraints().first() {
            None => Ok(()),
            Some(constraint) => Err(Unsupported {
                solver: NAME,
                reason: format!("it has constraints, such as `{}`, which only `clarabel` obeys", constraint.name),
            }),
        }
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        let lent = Lend { problem, initial, context: RefCell::new(context) };
        let state = IterationState::new().param(initial.as_slice().to_vec()).max_iters(u64::MAX);
        let run = Executor::new(lent, Run::new(self.clone())).configure(|_| state).ctrlc(false).timer(false).run();
        match run {
            Ok(result) => Ok(result.solver.into_estimate()),
            Err(error) => Err(match error.downcast::<EvaluateError>() {
                Ok(evaluate) => SolveError::Evaluate(evaluate),
                Err(other) => SolveError::Failed { solver: NAME, reason: other.to_string() },
            }),
        }
    }
}

type IterationState = IterState<Vec<f64>, (), (), (), (), f64>;

/// argmin owns its problem; ours is lent to it together with what accompanies the solve.
struct Lend<'p, 'c, 'o> {
    problem: &'p Problem,
    initial: &'p Values,
    context: RefCell<&'c mut SolveContext<'o>>,
}

impl CostFunction for Lend<'_, '_, '_> {
    type Param = Values;
    type Output = f64;

    fn cost(&self, values: &Values) -> Result<f64, Error> {
        Ok(self.problem.cost(values)?)
    }
}

/// The method at work.
struct Run<'p> {
    options: LevenbergMarquardt,
    damping: f64,
    /// Factor by which the damping grows after the next rejected step.
    growth: f64,
    /// D: the largest norm of each column so far.
    scaling: Vec<f64>,
    current: Option<Current<'p>>,
    termination: Termination,
    records: Vec<IterationRecord>,
}

struct Current<'p> {
    values: Values,
    linearization: Box<dyn Linearization + 'p>,
}

/// Damping beyond which a step is shorter than rounding.
const MAX_DAMPING: f64 = 1e32;
/// Damping at the start, relative to the column norms.
const INITIAL_DAMPING: f64 = 1e-3;

impl<'p> Run<'p> {
    fn new(options: LevenbergMarquardt) -> Self {
        Run {
            options,
            damping: INITIAL_DAMPING,
            growth: 2.0,
            scaling: Vec::new(),
            current: None,
            termination: Termination::NoProgress,
            records: Vec::new(),
        }
    }

    fn into_estimate(self) -> Estimate {
        let current = self.current.expect("argmin returns no result without having called `init`");
        Estimate {
            cost: current.linearization.cost(),
            values: current.values,
            termination: self.termination,
            iterations: self.records,
            active: Vec::new(),
        }
    }

    /// Takes a point as the current one and tells the observer.
    fn move_to(&mut self, lent: &Lend<'p, '_, '_>, values: Values, step: f64) -> Result<(), EvaluateError> {
        let linearization = lent.problem.linearize(&values)?;
        let scales = linearization.column_scales();
        self.scaling.resize(scales.len(), 0.0);
        self.scaling.iter_mut().zip(scales).for_each(|(largest, scale)| *largest = largest.max(scale));
        let record = IterationRecord {
            iteration: self.records.len(),
            cost: linearization.cost(),
            cosine: linearization.largest_cosine(),
            step,
            damping: self.damping,
        };
        lent.context.borrow_mut().tell(&record);
        self.records.push(record);
        self.current = Some(Current { values, linearization });
        Ok(())
    }

    /// Tries steps of growing damping until one lowers the cost. `None` while there is reason to go on.
    fn iterate(&mut self, lent: &mut Counted<Lend<'p, '_, '_>>) -> Result<Option<Termination>, Error> {
        let Some(mut current) = self.current.take() else {
            return Ok(Some(Termination::NoProgress));
        };
        let scaling = self.scaling.clone();
        let cost = current.linearization.cost();
        let mut step = vec![0.0; scaling.len()];
        loop {
            let predicted = current.linearization.damped_step(self.damping, &scaling, &mut step).predicted_reduction;
            let candidate = lent.problem("moves", |l| Ok(l.problem.retract(&current.values, &step)))?;
            let relative_step =
                lent.problem("lengths", |l| Ok(relative_length(l.problem, &current, &step, &scaling)))?;
            // A point where the model has no value is as bad as one of infinite cost.
            let moved = lent.problem("cost_count", |l| Ok(l.cost(&candidate).unwrap_or(f64::INFINITY)))?;
            let actual = cost - moved;
            let end = self.judge(cost, predicted, actual, relative_step);
            if actual > 0.0 && moved.is_finite() {
                self.accept(actual / predicted);
                lent.problem("jacobian_count", |l| Ok(self.move_to(l, candidate, relative_step)?))?;
                return Ok(end);
            }
            if end.is_some() || self.damping > MAX_DAMPING {
                self.current = Some(current);
                return Ok(Some(end.unwrap_or(Termination::NoProgress)));
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
        }
    }

    /// Nielsen's update after an accepted step.
    fn accept(&mut self, ratio: f64) {
        self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
        self.growth = 2.0;
    }

    /// Whether a step is too small, or gains too little, to go on.
    fn judge(&self, cost: f64, predicted: f64, actual: f64, relative_step: f64) -> Option<Termination> {
        let gain = self.options.cost_tolerance * cost;
        if predicted <= gain && actual.abs() <= gain.max(f64::EPSILON * cost) {
            Some(Termination::Cost { relative: predicted / cost })
        } else if relative_step <= self.options.step_tolerance {
            Some(Termination::Step { relative: relative_step })
        } else {
            None
        }
    }

    fn stationary(&self) -> Option<Termination> {
        let linearization = &self.current.as_ref()?.linearization;
        if linearization.cost() == 0.0 {
            return Some(Termination::ZeroResidual);
        }
        let cosine = linearization.largest_cosine();
        (cosine <= self.options.cosine_tolerance).then_some(Termination::Gradient { cosine })
    }
}

/// Largest step of a block, relative to the block's own size or to the residual, whichever is larger, each as the
/// block's columns see it. A pure number that does not change with the units, and that one block of wandering values
/// cannot make small.
fn relative_length(problem: &Problem, current: &Current<'_>, step: &[f64], scaling: &[f64]) -> f64 {
    let residual = (2.0 * current.linearization.cost()).sqrt();
    let norm = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    problem
        .block_ids()
        .filter(|id| !problem.columns_of(*id).is_empty())
        .map(|id| {
            let columns = problem.columns_of(id);
            let weight = scaling[columns.clone()].iter().fold(0.0, |m: f64, s| m.max(*s));
            let size = (weight * norm(current.values.get(id))).max(residual);
            weight * norm(&step[columns]) / size.max(f64::MIN_POSITIVE)
        })
        .fold(0.0, f64::max)
}

impl<'p> ArgminSolver<Lend<'p, '_, '_>, IterationState> for Run<'p> {
    fn name(&self) -> &str {
        NAME
    }

    fn init(
        &mut self,
        problem: &mut Counted<Lend<'p, '_, '_>>,
        state: IterationState,
    ) -> Result<(IterationState, Option<KV>), Error> {
        problem.problem("jacobian_count", |l| Ok(self.move_to(l, l.initial.clone(), 0.0)?))?;
        let cost = self.records[0].cost;
        Ok((state.cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Counted<Lend<'p, '_, '_>>,
        state: IterationState,
    ) -> Result<(IterationState, Option<KV>), Error> {
        let mut end = self.stationary();
        if end.is_none() && problem.problem("stop", |l| Ok(l.context.borrow().stopped()))? {
            end = Some(Termination::Stopped);
        }
        if end.is_none() && state.get_iter() >= self.options.max_iterations as u64 {
            end = Some(Termination::IterationLimit { limit: self.options.max_iterations });
        }
        if end.is_none() {
            end = self.iterate(problem)?;
        }
        let Some(current) = &self.current else {
            return Err(Error::msg("no current point"));
        };
        let mut state = state.param(current.values.as_slice().to_vec()).cost(current.linearization.cost());
        if let Some(termination) = end {
            self.termination = termination;
            let reason = if termination.converged() {
                TerminationReason::SolverConverged
            } else {
                TerminationReason::SolverExit(termination.to_string())
            };
            state = state.terminate_with(reason);
        }
        Ok((state, None))
    }
}
