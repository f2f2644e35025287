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
//! Three things keep it honest where the cost alone does not:
//!
//! - The first step is bounded by `‖D δ‖ ≤ 0.2 ‖D x‖` (Moré, section 3, with a smaller factor): without it a start with
//!   one parameter far too small is left for a plateau at infinity.
//! - Where rounding hides whether a step lowers the cost, better is where the linear model sees less to gain: the cost
//!   tells a minimum to half of its digits, the gradient to all.
//! - `λ` and `D` remember the way. Before a step counts as too small, the method starts afresh from where it stands.
//!
//! Left out of the sources: Moré's trust-region radius (λ is damped directly) and geodesic acceleration.

use std::cell::RefCell;

use argmin::core::{
    CostFunction, Error, Executor, IterState, KV, Problem as Counted, Solver as ArgminSolver, State, TerminationReason,
};
use gravcal_estimation::{
    DenseLinearization, Estimate, EvaluateError, IterationRecord, Linearization, Problem, SolveContext, SolveError,
    Solver, Termination, Unsupported, Values,
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
    /// Ends where predicted and actual reduction are at most this share of the cost, unless ever less is left to gain.
    pub cost_tolerance: f64,
}

impl Default for LevenbergMarquardt {
    fn default() -> Self {
        LevenbergMarquardt {
            // Curved valleys take thousands of steps: NIST's MGH10 from its far start 7,600.
            max_iterations: 10_000,
            cosine_tolerance: 1e-10,
            step_tolerance: 1e-13,
            cost_tolerance: 1e-14,
        }
    }
}

impl Solver for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, _problem: &Problem) -> Result<(), Unsupported> {
        Ok(()) // takes every problem: fewer rows than unknowns and lost rank are left to the damping
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
struct Run {
    options: LevenbergMarquardt,
    damping: f64,
    /// Factor by which the damping grows after the next rejected step.
    growth: f64,
    /// D: the largest norm of each column so far.
    scaling: Vec<f64>,
    current: Option<Current>,
    /// Cost where the method last started afresh.
    fresh_cost: f64,
    termination: Termination,
    records: Vec<IterationRecord>,
}

struct Current {
    values: Values,
    linearization: DenseLinearization,
}

impl Current {
    fn new(problem: &Problem, values: Values) -> Result<Self, EvaluateError> {
        let linearization = DenseLinearization::new(problem, &values)?;
        if !linearization.cost().is_finite() {
            return Err(EvaluateError(format!("the cost is {}", linearization.cost())));
        }
        Ok(Current { values, linearization })
    }

    /// The damped step, and the reduction of the cost that the linear model predicts for it.
    fn step(&mut self, damping: f64, scaling: &[f64]) -> (Vec<f64>, f64) {
        let mut step = vec![0.0; scaling.len()];
        let info = self.linearization.damped_step(damping, scaling, &mut step);
        (step, info.predicted_reduction)
    }

    fn cosine(&self) -> f64 {
        self.linearization.largest_cosine()
    }
}

/// What came of a step.
enum Outcome {
    /// It leads to a better point; the ratio of actual to predicted reduction.
    Better { next: Current, ratio: f64 },
    /// By its cost the point cannot be told from the current one, and as much is left to gain there.
    Same,
    /// It leads to a worse point.
    Worse,
}

/// Damping at the start, relative to the column norms.
const INITIAL_DAMPING: f64 = 1e-3;
/// The first step is at most this share of what it moves.
const FIRST_STEP: f64 = 0.2;
/// Growth of the damping while the first step is too long, and where it ends.
const LEAP_DAMPING: f64 = 3.0;
const MAX_LEAP_DAMPING: f64 = 1e4;
/// Share of the cost that rounding may hide where the model's values are much larger than its residuals.
const ROUNDING: f64 = 1e-8;
/// Less is left to gain where the predicted reduction is at most this share of what it was.
const LESS_TO_GAIN: f64 = 0.9;
/// D hinders where it exceeds a column's present norm this many times.
const INFLATED: f64 = 10.0;

impl Run {
    fn new(options: LevenbergMarquardt) -> Self {
        Run {
            options,
            damping: INITIAL_DAMPING,
            growth: 2.0,
            scaling: Vec::new(),
            current: None,
            fresh_cost: f64::INFINITY,
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
        }
    }

    /// Takes a point as the current one and tells the observer.
    fn move_to(&mut self, lent: &Lend<'_, '_, '_>, next: Current, step: f64) {
        let scales = next.linearization.column_scales();
        self.scaling.resize(scales.len(), 0.0);
        self.scaling.iter_mut().zip(scales).for_each(|(largest, scale)| *largest = largest.max(scale));
        let record = IterationRecord {
            iteration: self.records.len(),
            cost: next.linearization.cost(),
            cosine: next.cosine(),
            step,
            damping: self.damping,
        };
        lent.context.borrow_mut().tell(&record);
        self.records.push(record);
        self.current = Some(next);
    }

    /// Tries steps of growing damping until one is taken. `None` while there is reason to go on.
    fn iterate(&mut self, lent: &mut Counted<Lend<'_, '_, '_>>) -> Result<Option<Termination>, Error> {
        let Some(mut current) = self.current.take() else {
            return Ok(Some(Termination::NoProgress));
        };
        let cost = current.linearization.cost();
        loop {
            let (step, predicted) = current.step(self.damping, &self.scaling);
            let lengths = lent.problem("lengths", |l| Ok(lengths(l.problem, &current.values, &step, &self.scaling)))?;
            if self.records.len() == 1 && self.damping < MAX_LEAP_DAMPING && leaps(&lengths) {
                self.damping *= LEAP_DAMPING;
                continue;
            }
            let length = relative_length(&lengths, cost);
            let outcome = lent.problem("cost_count", |l| Ok(self.attempt(l, &current, &step, predicted)))?;
            // A step that is small because it is damped proves nothing by itself.
            let free = self.damping <= INITIAL_DAMPING || current.cosine() <= self.options.cosine_tolerance.sqrt();
            let too_small = length <= self.options.step_tolerance;
            let end = match outcome {
                Outcome::Better { next, ratio } => {
                    self.accept(ratio);
                    lent.problem("jacobian_count", |l| {
                        self.move_to(l, next, length);
                        Ok(())
                    })?;
                    return Ok((too_small && free).then_some(Termination::Step { relative: length }));
                }
                Outcome::Same if free => Termination::Cost { relative: predicted / cost },
                Outcome::Worse if too_small && free => Termination::Step { relative: length },
                Outcome::Worse if !too_small && self.damping.is_finite() => {
                    self.damping *= self.growth;
                    self.growth *= 2.0;
                    continue;
                }
                Outcome::Same | Outcome::Worse => Termination::NoProgress,
            };
            if !self.start_afresh(&current) {
                self.current = Some(current);
                return Ok(Some(end));
            }
        }
    }

    /// Where a step leads. A point where the model or its derivatives have no value is worse than any other.
    fn attempt(&self, lent: &Lend<'_, '_, '_>, current: &Current, step: &[f64], predicted: f64) -> Outcome {
        let values = lent.problem.retract(&current.values, step);
        let cost = current.linearization.cost();
        let actual = cost - lent.problem.cost(&values).unwrap_or(f64::INFINITY);
        let change = predicted.max(actual.abs()) / cost;
        if actual <= 0.0 && change > ROUNDING {
            return Outcome::Worse;
        }
        let Ok(mut next) = Current::new(lent.problem, values) else { return Outcome::Worse };
        let same = change <= self.options.cost_tolerance;
        if actual > 0.0 && !same {
            Outcome::Better { next, ratio: actual / predicted }
        } else if next.step(self.damping, &self.scaling).1 <= LESS_TO_GAIN * predicted {
            Outcome::Better { next, ratio: 1.0 }
        } else if same {
            Outcome::Same
        } else {
            Outcome::Worse
        }
    }

    /// Nielsen's update after an accepted step.
    fn accept(&mut self, ratio: f64) {
        self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
        self.growth = 2.0;
    }

    /// Forgets damping and scaling, unless that would change little or did not help the last time.
    fn start_afresh(&mut self, current: &Current) -> bool {
        let scales = current.linearization.column_scales();
        let inflated = self.scaling.iter().zip(&scales).any(|(largest, scale)| *largest > INFLATED * scale);
        let cost = current.linearization.cost();
        let worthwhile = (inflated || self.damping > INITIAL_DAMPING) && cost < (1.0 - 1e-6) * self.fresh_cost;
        if worthwhile {
            (self.damping, self.growth, self.scaling, self.fresh_cost) = (INITIAL_DAMPING, 2.0, scales, cost);
        }
        worthwhile
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

/// The size of every free block and of its step, as the block's columns see them.
fn lengths(problem: &Problem, values: &Values, step: &[f64], scaling: &[f64]) -> Vec<[f64; 2]> {
    let norm = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let free = problem.block_ids().map(|id| (id, problem.columns_of(id))).filter(|(_, columns)| !columns.is_empty());
    free.map(|(id, columns)| {
        let weight = scaling[columns.clone()].iter().fold(0.0, |m: f64, s| m.max(*s));
        [weight * norm(values.get(id)), weight * norm(&step[columns])]
    })
    .collect()
}

/// Largest step of a block, relative to the block's own size or to the residual, whichever is larger. A pure number
/// that does not change with the units, and that one block of wandering values cannot make small.
fn relative_length(lengths: &[[f64; 2]], cost: f64) -> f64 {
    let residual = (2.0 * cost).sqrt().max(f64::MIN_POSITIVE);
    lengths.iter().map(|[size, step]| step / size.max(residual)).fold(0.0, f64::max)
}

/// Whether a step is too long for a first one.
fn leaps(lengths: &[[f64; 2]]) -> bool {
    let square = |which: usize| lengths.iter().map(|pair| pair[which] * pair[which]).sum::<f64>();
    let (size, step) = (square(0), square(1));
    step > FIRST_STEP * FIRST_STEP * size && size > 0.0
}

impl ArgminSolver<Lend<'_, '_, '_>, IterationState> for Run {
    fn name(&self) -> &str {
        NAME
    }

    fn init(
        &mut self,
        problem: &mut Counted<Lend<'_, '_, '_>>,
        state: IterationState,
    ) -> Result<(IterationState, Option<KV>), Error> {
        problem.problem("jacobian_count", |l| {
            let start = Current::new(l.problem, l.initial.clone())?;
            self.move_to(l, start, 0.0);
            Ok(())
        })?;
        let cost = self.records[0].cost;
        Ok((state.cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Counted<Lend<'_, '_, '_>>,
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
