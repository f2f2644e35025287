//! The constrained method: sequential conic programming, each step solved by Clarabel.
//!
//! At `x`, with the linear model of the residuals, the step is the minimum of
//!
//! ```text
//!     ½ ‖J δ + r‖² + ½ λ ‖D δ‖²     such that every constraint holds at x + δ
//! ```
//!
//! a quadratic function over ranges and second-order cones. `D` and `λ` are those of
//! [`LevenbergMarquardt`](crate::LevenbergMarquardt), and so are the tests of convergence; a step is taken if the cost falls.
//! The start obeys the constraints, they are convex, and each step obeys them: so do all points on the way, and the cost
//! alone tells progress; where its digits end, the cosine below does. A vector of known length is moved along its tangent
//! plane and scaled back to its length.
//!
//! **Optimality.** It ends where the Lagrangian `½ ‖r‖² − zᵀ s` is stationary, `Jᵀ r = Gᵀ z`, with `s` and `z` in their cones
//! and `zᵀ s = 0` (Karush, Kuhn and Tucker; Nocedal and Wright, *Numerical optimization*, 2006, theorem 12.1). The cosine of
//! the trace and of the termination is that of `Jᵀ r − Gᵀ z`, or `zᵀ s / ‖r‖²` where that is larger.
//!
//! **Digits.** A problem without constraints is Levenberg-Marquardt's. A step that no constraint stops comes from the
//! linearization, as there. Else `JᵀJ` is formed: directions that the data hardly determine (singular values below 1e-6 of
//! the largest, columns scaled) are then walked along slowly. The gradient loses no digit by it, and neither does the optimum.
//!
//! **Not taken.** Ranges and cones over blocks of a fixed length: such sets are not convex, and "the nearest point
//! inside" is not one.

mod active;
mod model;
mod programme;
mod refine;
mod rows;
mod start;
mod trial;

use gravcal_estimation::{
    BlockId, Constraint, ConstraintKind, Estimate, EvaluateError, IterationRecord, Manifold, Problem, SolveContext,
    SolveError, Solver, Termination, Unsupported, Values,
};
use serde::Deserialize;

use crate::{LevenbergMarquardt, StoppingRules};
use active::active_constraints;
use start::scale_to_length;
use trial::{Damping, Point, Trial};

pub(crate) const NAME: &str = "clarabel";

/// Columns at most: JᵀJ is dense, and its factorization takes time with their cube.
const MAX_COLUMNS: usize = 2000;

/// The method with its options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Clarabel {
    /// When it ends. The cosine is that between the residual and a column of J, the constraints' part taken off.
    pub stopping: StoppingRules,
}

impl Solver for Clarabel {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        let refuse = |reason| Err(Unsupported { solver: NAME, reason });
        let columns = problem.columns().len();
        if columns > MAX_COLUMNS && !problem.constraints().is_empty() {
            return refuse(format!(
                "{columns} unknowns are more than {MAX_COLUMNS}: with constraints their Hessian is stored whole, and \
                 factored in time that grows with their cube"
            ));
        }
        match problem.constraints().iter().find_map(|c| not_convex(problem, c)) {
            Some(reason) => refuse(reason),
            None => Ok(()),
        }
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        self.check(problem)?;
        if problem.constraints().is_empty() {
            return LevenbergMarquardt { stopping: self.stopping }.solve(problem, initial, context);
        }
        start::check(problem, initial)?;
        Run::new(self, problem, context).go(initial)
    }
}

/// Why the set of values that obey a constraint together with the others is not convex, if it is not.
fn not_convex(problem: &Problem, constraint: &Constraint) -> Option<String> {
    let Constraint { name, kind } = constraint;
    let free = |id: &BlockId| !problem.columns_of(*id).is_empty();
    let curved = |id: &BlockId| free(id) && problem.block(*id).manifold != Manifold::Euclidean;
    let of_length = |id: &BlockId, other: &Constraint| {
        matches!(other.kind, ConstraintKind::Length { block, .. } if block == *id) && other != constraint && free(id)
    };
    constraint.blocks().iter().find_map(|id| {
        let block = &problem.block(*id).name;
        match (kind, problem.constraints().iter().find(|other| of_length(id, other))) {
            (ConstraintKind::Length { .. }, _) if curved(id) => Some(format!(
                "`{name}` fixes the length of `{block}`, whose manifold already does: drop one of the two"
            )),
            (ConstraintKind::Length { .. }, Some(other)) => {
                Some(format!("`{name}` and `{}` both fix the length of `{block}`: drop one of them", other.name))
            }
            (_, Some(_)) => Some(fixed_length(name, block)),
            _ if curved(id) => Some(fixed_length(name, block)),
            _ => None,
        }
    })
}

fn fixed_length(constraint: &str, block: &str) -> String {
    format!(
        "`{constraint}` reads `{block}`, whose length is fixed: what obeys both is not convex; drop the constraint, or let \
         the length be measured by a residual"
    )
}

/// Damping beyond which a step is shorter than rounding.
const MAX_DAMPING: f64 = 1e32;
/// A point is nearer to the optimum if its cosine is at most this share of the other's.
const NEARER: f64 = 0.9;
/// Damping at the start, relative to the column norms.
const INITIAL_DAMPING: f64 = 1e-3;

/// The method at work.
struct Run<'r, 'o> {
    options: &'r Clarabel,
    problem: &'r Problem,
    context: &'r mut SolveContext<'o>,
    damping: Damping,
    /// Factor by which the damping grows after the next rejected step.
    growth: f64,
    records: Vec<IterationRecord>,
    /// Places of the rows on which the last step leaned.
    leaning: Vec<usize>,
}

/// Where the method is, and what it tries next; nothing where the conic programme had no answer.
struct Current<'p> {
    point: Point<'p>,
    trial: Option<Trial>,
}

impl Current<'_> {
    fn cost(&self) -> f64 {
        self.point.linearization.cost()
    }

    /// How far from optimal it is.
    fn cosine(&self) -> f64 {
        let unknown = if self.cost() > 0.0 { f64::INFINITY } else { 0.0 };
        self.trial.as_ref().map_or(unknown, |trial| trial.cosine)
    }
}

impl<'r, 'o> Run<'r, 'o> {
    fn new(options: &'r Clarabel, problem: &'r Problem, context: &'r mut SolveContext<'o>) -> Self {
        let damping = Damping { lambda: INITIAL_DAMPING, scaling: Vec::new() };
        Run { options, problem, context, damping, growth: 2.0, records: Vec::new(), leaning: Vec::new() }
    }

    fn go(mut self, initial: &Values) -> Result<Estimate, SolveError> {
        let mut current = self.look(initial.clone())?;
        self.record(&current, 0.0);
        let termination = loop {
            if let Some(end) = self.ended(&current) {
                break end;
            }
            if let Some(end) = self.advance(&mut current)? {
                break self.stationary(&current).unwrap_or(end);
            }
        };
        let leaning = current.trial.as_ref().map_or(&[][..], |trial| &trial.leaning);
        Ok(Estimate {
            cost: current.cost(),
            active: active_constraints(self.problem, &current.point.values, leaning),
            values: current.point.values,
            termination,
            iterations: self.records,
        })
    }

    /// Linearizes at a point and finds the step from there.
    fn look(&mut self, values: Values) -> Result<Current<'r>, EvaluateError> {
        let linearization = self.problem.linearize(&values)?;
        let scales = linearization.column_scales();
        self.damping.scaling.resize(scales.len(), 0.0);
        self.damping.scaling.iter_mut().zip(scales).for_each(|(largest, scale)| *largest = largest.max(scale));
        let mut current = Current { point: Point { values, linearization }, trial: None };
        if current.cost() > 0.0 {
            self.aim(&mut current);
        }
        Ok(current)
    }

    /// Keeps a record of a new current point and tells the observer.
    fn record(&mut self, current: &Current<'_>, step: f64) {
        let iteration = self.records.len();
        let (cost, cosine) = (current.cost(), current.cosine());
        let record = IterationRecord { iteration, cost, cosine, step, damping: self.damping.lambda };
        self.context.tell(&record);
        self.records.push(record);
    }

    /// Finds the step at the present damping.
    fn aim(&mut self, current: &mut Current<'_>) {
        current.trial = Trial::new(self.problem, &mut current.point, &self.damping, &self.leaning);
        if let Some(trial) = &current.trial {
            self.leaning = trial.leaning.iter().map(|(rows, _)| rows.place).collect();
        }
    }

    fn ended(&self, current: &Current<'_>) -> Option<Termination> {
        let limit = self.options.stopping.max_iterations;
        let stopped = || self.context.stopped().then_some(Termination::Stopped);
        let used_up = || (self.records.len() > limit).then_some(Termination::IterationLimit { limit });
        self.stationary(current).or_else(stopped).or_else(used_up)
    }

    fn stationary(&self, current: &Current<'_>) -> Option<Termination> {
        if current.cost() == 0.0 {
            return Some(Termination::ZeroResidual);
        }
        let cosine = current.cosine();
        (cosine <= self.options.stopping.cosine_tolerance).then_some(Termination::Gradient { cosine })
    }

    /// Tries steps of growing damping until one is better. `None` while there is reason to go on.
    fn advance(&mut self, current: &mut Current<'r>) -> Result<Option<Termination>, EvaluateError> {
        loop {
            if let Some(trial) = &current.trial {
                let candidate = self.moved(&current.point.values, &trial.step);
                let relative_step = self.relative_length(&current.point, &trial.step);
                // A point where the model has no value is as bad as one of infinite cost.
                let moved = self.problem.cost(&candidate).unwrap_or(f64::INFINITY);
                let actual = current.cost() - moved;
                let end = self.judge(current.cost(), trial.predicted, actual, relative_step);
                if matches!(end, Some(Termination::Cost { .. })) {
                    return Ok(if self.moves_nearer(current, candidate, relative_step)? { None } else { end });
                }
                if actual > 0.0 && moved.is_finite() {
                    self.accept(actual / trial.predicted);
                    *current = self.look(candidate)?;
                    self.record(current, relative_step);
                    return Ok(end);
                }
                if end.is_some() {
                    return Ok(end);
                }
            }
            if self.damping.lambda > MAX_DAMPING {
                return Ok(Some(Termination::NoProgress));
            }
            self.damping.lambda *= self.growth;
            self.growth *= 2.0;
            self.aim(current);
        }
    }

    /// Where the cost has no more digits to tell which of two points is better, their cosines do.
    fn moves_nearer(&mut self, current: &mut Current<'r>, candidate: Values, step: f64) -> Result<bool, EvaluateError> {
        let next = self.look(candidate)?;
        let nearer = next.cosine() <= NEARER * current.cosine();
        if nearer {
            *current = next;
            self.record(current, step);
        }
        Ok(nearer)
    }

    /// Nielsen's update after an accepted step.
    fn accept(&mut self, ratio: f64) {
        self.damping.lambda *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
        self.growth = 2.0;
    }

    /// Whether a step is too small, or gains too little, to go on.
    fn judge(&self, cost: f64, predicted: f64, actual: f64, relative_step: f64) -> Option<Termination> {
        let gain = self.options.stopping.cost_tolerance * cost;
        if predicted <= gain && actual.abs() <= gain.max(f64::EPSILON * cost) {
            Some(Termination::Cost { relative: predicted / cost })
        } else if relative_step <= self.options.stopping.step_tolerance {
            Some(Termination::Step { relative: relative_step })
        } else {
            None
        }
    }

    /// The values after a step, freed of rounding errors: vectors of known length have it, bounds hold to the last bit.
    fn moved(&self, values: &Values, step: &[f64]) -> Values {
        let mut moved = self.problem.retract(values, step);
        scale_to_length(self.problem, &mut moved);
        for constraint in self.problem.constraints() {
            if let ConstraintKind::Range { function, lower, upper } = &constraint.kind
                && let [(id, component, 1.0)] = function.terms[..]
                && !self.problem.columns_of(id).is_empty()
            {
                let mut block = moved.get(id).to_vec();
                block[component] = block[component].max(lower - function.constant).min(upper - function.constant);
                moved.set(id, &block);
            }
        }
        moved
    }

    /// Largest step of a block, relative to the block's own size or to the residual, whichever is larger, each as the
    /// block's columns see it.
    fn relative_length(&self, point: &Point<'_>, step: &[f64]) -> f64 {
        let residual = (2.0 * point.linearization.cost()).sqrt();
        let free = self.problem.block_ids().map(|id| (id, self.problem.columns_of(id))).filter(|(_, c)| !c.is_empty());
        free.map(|(id, columns)| {
            let weight = self.damping.scaling[columns.clone()].iter().fold(0.0, |m: f64, s| m.max(*s));
            let size = (weight * rows::norm(point.values.get(id))).max(residual);
            weight * rows::norm(&step[columns]) / size.max(f64::MIN_POSITIVE)
        })
        .fold(0.0, f64::max)
    }
}
