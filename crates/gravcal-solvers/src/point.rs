//! A point on the way, linearized, and what a step from it comes to.

use gravcal_estimation::{
    ActiveConstraint, BlockId, Column, EvaluateError, Linearization, Problem, Termination, Values,
};

use crate::clarabel::{ConstrainedStep, Optimality, active_constraints, settle};
use crate::stopping::StoppingRules;

/// The relative offset may be so many times the cosine tolerance: it takes all directions together, and is larger than the largest
/// cosine of a single column, typically by the square root of their number.
const OFFSET: f64 = 10.0;
/// However large the cosine tolerance, an offset above this ends nothing: that of Bates and Watts.
const LARGEST_OFFSET: f64 = 1e-3;
/// Damping of the fullest step, relative to the column norms: see [`Point::fullest_step`].
pub(crate) const FAINT_DAMPING: f64 = 1e-14;
/// Damping of the step whose promise tells how far off the minimum is, and the better of two points where their costs are the same but
/// for rounding.
const WEIGHING_DAMPING: f64 = 1e-8;
/// No less damping than this: the square of a rounding error.
const FAINTEST_DAMPING: f64 = 1e-32;
/// Rounding of a sum of squares, relative to it, and the most of the cost that is ever taken for rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
const MOST_ROUNDING: f64 = 1e-8;
/// A promise is less than another where it is at most this share of it.
const LESS: f64 = 0.9;
/// A linear model's minimum this near (share of the block or of the residual) is as good as reached.
const NEAR_STEP: f64 = 1e-8;
/// So is one that would lower the cost by no more than this share: the square of a relative offset of 1e-6.
const NEAR_COST: f64 = 1e-12;

/// A point on the way.
#[non_exhaustive]
pub struct Point<'p> {
    /// The problem.
    pub problem: &'p Problem,
    /// The values of its blocks.
    pub values: Values,
    /// The problem linearized there.
    pub linearization: Box<dyn Linearization + 'p>,
    /// D: the largest norm that each column of J has had so far (Moré, *The Levenberg-Marquardt algorithm:
    /// implementation and theory*, 1978, eq. 6.3).
    pub scaling: Vec<f64>,
    /// The fullest step and its promise, once they were asked for.
    fullest: Option<(Vec<f64>, f64)>,
    /// How far it is from optimal, once that was asked for; only under constraints.
    optimality: Option<Optimality>,
    /// Whether a step from here was refused, or none will be taken: the derivatives where steps lead are then not asked for.
    refused: bool,
}

/// A step that was tried.
#[non_exhaustive]
pub struct Trial<'p> {
    /// Where it leads.
    pub values: Values,
    /// Its relative length, see [`StoppingRules`].
    pub length: f64,
    /// Reduction of the cost that the linear model predicts.
    pub predicted: f64,
    /// Reduction of the cost; −∞ where the model has no value.
    pub actual: f64,
    /// Larger of both, relative to the cost.
    change: f64,
    /// The change that may be rounding only.
    rounding: f64,
    /// The point where it leads, if it was looked at.
    pub(crate) there: Option<Point<'p>>,
}

impl Trial<'_> {
    /// Actual over predicted reduction: near 1 where the linear model can be trusted, and 1 where rounding hides it.
    pub fn ratio(&self) -> f64 {
        if self.change <= self.rounding { 1.0 } else { self.actual / self.predicted }
    }
}

/// What is to be done after a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// Go there; and end there, if there is a reason.
    Accept(Option<Termination>),
    /// Stay: no step is worth taking.
    End(Termination),
    /// Try a shorter step.
    Shorten,
}

impl<'p> Point<'p> {
    /// Linearizes `problem` at `values`; `scaling` is that of the points before, or empty.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub(crate) fn new(problem: &'p Problem, values: Values, mut scaling: Vec<f64>) -> Result<Self, EvaluateError> {
        let linearization = problem.linearize(&values)?;
        let scales = linearization.column_scales();
        scaling.resize(scales.len(), 0.0);
        scaling.iter_mut().zip(scales).for_each(|(largest, scale)| *largest = largest.max(scale));
        Ok(Point { problem, values, linearization, scaling, fullest: None, optimality: None, refused: false })
    }

    /// The cost here.
    pub fn cost(&self) -> f64 {
        self.linearization.cost()
    }

    /// Reduction of the cost that the linear model predicts for a step: `−gᵀδ − ½ ‖J δ‖²`.
    pub fn predicted(&self, step: &[f64]) -> f64 {
        -dot(self.linearization.gradient(), step) - 0.5 * self.linearization.image_norm_squared(step)
    }

    /// Largest |cosine| between the residual and a column of J, what constraints hold back taken off: 0 where it is optimal.
    pub fn cosine(&mut self) -> f64 {
        if self.is_free() { self.linearization.largest_cosine() } else { self.optimality().cosine }
    }

    /// The constraints on which it leans.
    pub(crate) fn active(&mut self) -> Vec<ActiveConstraint> {
        if self.is_free() {
            return Vec::new();
        }
        let leaning = self.optimality().leaning;
        active_constraints(self.problem, &self.values, &leaning)
    }

    /// The unknowns whose columns are zero.
    pub(crate) fn without_effect(&self) -> Vec<Column> {
        let all = self.problem.columns().iter().zip(self.linearization.column_norms());
        all.filter(|(_, norm)| **norm == 0.0).map(|(column, _)| *column).collect()
    }

    fn is_free(&self) -> bool {
        self.problem.constraints().is_empty()
    }

    fn optimality(&mut self) -> Optimality {
        let known = self.optimality.take();
        let optimality = known.unwrap_or_else(|| Optimality::of(self));
        self.optimality.insert(optimality).clone()
    }

    /// The step that minimises the linear model with damping λ in units of D among those that obey the constraints, and the
    /// reduction of the cost that it promises. `None` where the conic programme has no answer.
    pub(crate) fn step(&mut self, lambda: f64) -> Option<(Vec<f64>, f64)> {
        let scaling = std::mem::take(&mut self.scaling);
        let step = self.step_in(lambda, &scaling);
        self.scaling = scaling;
        step
    }

    fn step_in(&mut self, lambda: f64, scaling: &[f64]) -> Option<(Vec<f64>, f64)> {
        if !self.is_free() {
            return ConstrainedStep::new(self, lambda, scaling).map(|found| (found.step, found.predicted));
        }
        let mut step = vec![0.0; scaling.len()];
        let info = self.linearization.damped_step(lambda, scaling, &mut step);
        Some((step, info.predicted_reduction))
    }

    /// The same in units of the present column norms. Where the conic programme has no answer, no step and an infinite promise.
    pub fn damped_step(&mut self, lambda: f64) -> (Vec<f64>, f64) {
        let scales = self.linearization.column_scales();
        self.step_in(lambda, &scales).unwrap_or_else(|| (vec![0.0; scales.len()], f64::INFINITY))
    }

    /// The step to the minimum of the linear model (Gauss-Newton), and the reduction of the cost that it promises. Where J
    /// has lost rank it is the shortest such step, in scaled coordinates.
    ///
    /// It is had from the least damping λ that the linearization bears as it is: 1e-10 for normal equations, so that the step along a
    /// direction 1e4 times weaker than the columns is shortened by a tenth, which the next step makes up for. To go further takes an orthogonal
    /// factorization, several times the work of all else in an iteration. What rounding puts along a direction without information is
    /// inversely proportional to λ, so the extrapolation `(10 δ(10 λ) − δ(λ)) / 9` is free of it.
    ///
    /// Only where the damping outweighs the model, `λ ‖D δ‖² > ‖J δ‖²`, though there is cost to be gained, is the model
    /// itself that weak (a Jacobian that loses rank at the solution), and the damping gives way.
    ///
    /// Under constraints it is the best of the steps that obey them; where the conic programme has no answer, none, with an
    /// infinite promise.
    pub fn full_step(&mut self) -> (Vec<f64>, f64) {
        match &self.fullest {
            Some(known) => known.clone(),
            None => self.full_step_from(self.linearization.least_damping()),
        }
    }

    /// The same from a damping of 1e-14, which lies above the rounding errors of `JᵀJ` (1e-16), so that there is a factorization, and below
    /// what readings determine: the step along a direction 1e6 times weaker than the columns is shortened by a tenth.
    pub(crate) fn fullest_step(&mut self) -> (Vec<f64>, f64) {
        if self.fullest.is_none() {
            self.fullest = Some(self.full_step_from(FAINT_DAMPING));
        }
        self.full_step()
    }

    fn full_step_from(&mut self, mut lambda: f64) -> (Vec<f64>, f64) {
        let scales = self.linearization.column_scales();
        loop {
            let (less, _) = self.damped_step(lambda);
            let (more, gain) = self.damped_step(10.0 * lambda);
            if gain.is_infinite() {
                return (more, gain);
            }
            let length: f64 = more.iter().zip(&scales).map(|(d, s)| (s * d).powi(2)).sum();
            let outweighs = lambda * length > self.linearization.image_norm_squared(&more);
            if !outweighs || gain <= NEAR_COST * self.cost() || lambda < FAINTEST_DAMPING {
                let step: Vec<f64> = less.iter().zip(&more).map(|(less, more)| (10.0 * more - less) / 9.0).collect();
                let predicted = self.predicted(&step);
                return (step, predicted);
            }
            lambda *= 0.01;
        }
    }

    /// Tries a step whose reduction of the cost the linear model puts at `predicted`.
    pub fn attempt(&self, step: &[f64], predicted: f64) -> Trial<'p> {
        let mut moved = self.problem.retract(&self.values, step);
        settle(self.problem, &mut moved);
        self.attempt_at(Some(moved), step, predicted)
    }

    /// The same where it is known to where the step leads; nowhere if the model has no value there.
    pub(crate) fn attempt_at(&self, values: Option<Values>, step: &[f64], predicted: f64) -> Trial<'p> {
        // Most steps are taken at the first try, and then the derivatives are wanted as well.
        let there = values.clone().filter(|_| !self.refused).and_then(|values| self.next(values).ok());
        // A point where the model has no value is as bad as one of infinite cost.
        let looked_at = || values.as_ref().and_then(|values| self.problem.cost(values).ok()).unwrap_or(f64::INFINITY);
        let actual = self.cost() - there.as_ref().map_or_else(looked_at, Point::cost);
        Trial {
            values: values.unwrap_or_else(|| self.values.clone()),
            length: self.relative_length(step),
            predicted,
            actual,
            change: predicted.max(actual.abs()) / self.cost(),
            rounding: self.rounding(),
            there,
        }
    }

    /// Steps from here are looked at for their cost alone: none is taken, or most are refused.
    pub(crate) fn for_cost_alone(self) -> Point<'p> {
        Point { refused: true, ..self }
    }

    /// The point at `values`, next after this one.
    pub(crate) fn next(&self, values: Values) -> Result<Point<'p>, EvaluateError> {
        Point::new(self.problem, values, self.scaling.clone())
    }

    /// Decides on a trial, which is good enough if it lowers the cost by `least` (zero or more).
    ///
    /// Where rounding may hide whether it does, the linear model decides: the cost tells a minimum to half of its digits, the
    /// gradient to all. Better is then where less is left to be gained; at a lower cost, where no more is.
    pub fn decide(&mut self, trial: &mut Trial<'p>, least: f64, rules: &StoppingRules) -> Decision {
        let decision = self.judge(trial, least, rules);
        self.refused |= decision == Decision::Shorten;
        decision
    }

    fn judge(&mut self, trial: &mut Trial<'p>, least: f64, rules: &StoppingRules) -> Decision {
        let lower = trial.actual > 0.0 && trial.actual >= least;
        let hidden = trial.change <= trial.rounding.max(rules.cost_tolerance);
        let short = trial.length <= rules.step_tolerance;
        let better = if hidden { self.promises_less(trial, lower) } else { lower };
        if !(short || hidden && !better) {
            return if better { Decision::Accept(None) } else { Decision::Shorten };
        }
        let end = match short {
            true => Termination::Step { relative: trial.length },
            false => Termination::Cost { relative: trial.change },
        };
        match (better, self.at_model_minimum()) {
            (true, found) => Decision::Accept(found.then_some(end)),
            // More damping may still bring the cosine down: the full steps of large residuals go around the minimum.
            (false, true) if !short && !self.is_free() => Decision::Shorten,
            (false, true) => Decision::End(end),
            (false, false) if short => Decision::End(Termination::NoProgress),
            (false, false) => Decision::Shorten,
        }
    }

    /// Whether there is less to gain where a trial leads than here.
    fn promises_less(&mut self, trial: &mut Trial<'p>, lower: bool) -> bool {
        let here = self.promise();
        if trial.there.is_none() {
            trial.there = self.next(trial.values.clone()).ok();
        }
        let limit = if lower { here } else { LESS * here };
        trial.there.as_mut().is_some_and(|there| there.promise() <= limit)
    }

    /// What is still to be gained, to be held against another point's: the promise of a step, damped so much that normal
    /// equations bear it. What is weighed is the gradient, in a norm, not the last digit of a faint direction. Under
    /// constraints most of the gradient is held back, and rounding of that hides a promise: there it is the cosine.
    fn promise(&mut self) -> f64 {
        if self.is_free() { self.damped_step(WEIGHING_DAMPING).1 } else { self.cosine() }
    }

    /// `‖J δ‖ / ‖r‖` of the step with [`WEIGHING_DAMPING`], ½ ‖r‖² being the cost; where there are constraints, or rounding is all that is
    /// left of it, nothing.
    pub(crate) fn relative_offset(&mut self) -> Option<f64> {
        let square = if self.is_free() { self.promise() / self.cost() } else { 0.0 };
        (square > 0.0).then(|| square.sqrt())
    }

    /// Share of the cost that rounding may hide: the terms of a residual, of the size of `D x`, may be far larger than it is.
    fn rounding(&self) -> f64 {
        let residual = (2.0 * self.cost()).sqrt();
        (ROUNDING * (1.0 + self.size() / residual)).min(MOST_ROUNDING)
    }

    /// Whether the minimum of the linear model is as good as reached: the fullest step is short (1e-8), or what it promises is
    /// next to nothing: `‖J δ‖ ≤ 1e-6 ‖r‖`, after the relative offset of Bates and Watts (*Technometrics* 23, 1981), who are
    /// content with 1e-3.
    pub fn at_model_minimum(&mut self) -> bool {
        let (step, predicted) = self.fullest_step();
        predicted <= NEAR_COST * self.cost() || predicted.is_finite() && self.relative_length(&step) <= NEAR_STEP
    }

    /// Why a method ends here before it looks for a step, if it does: the point is stationary.
    pub(crate) fn stationary(&mut self, rules: &StoppingRules) -> Option<Termination> {
        if self.cost() == 0.0 {
            return Some(Termination::ZeroResidual);
        }
        if self.linearization.column_norms().iter().all(|norm| *norm == 0.0) {
            return Some(Termination::NoEffect);
        }
        let cosine = self.cosine();
        if cosine <= rules.cosine_tolerance {
            return Some(Termination::Gradient { cosine });
        }
        // The offset is no less than the cosine, and need not be looked at before that is small.
        let tolerance = (OFFSET * rules.cosine_tolerance).min(LARGEST_OFFSET);
        let offset = (cosine <= tolerance).then(|| self.relative_offset()).flatten();
        offset.filter(|offset| *offset <= tolerance).map(|offset| Termination::Offset { offset })
    }

    /// Why a method ends here that has found no step to take. What the model still promises may be less than rounding can hide of the cost:
    /// then this is the minimum, as far as the cost can tell.
    pub(crate) fn at_rest(&mut self) -> Termination {
        if self.is_free() {
            let relative = self.promise() / self.cost();
            if relative <= self.rounding() {
                return Termination::Cost { relative };
            }
        }
        Termination::NoProgress
    }

    /// `‖D x‖` over the free blocks, each with the largest entry of D that is its own.
    pub fn size(&self) -> f64 {
        let squares = self.problem.block_ids().map(|id| (self.weight(id) * norm(self.values.get(id))).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// `‖D δ‖`.
    pub fn scaled_length(&self, step: &[f64]) -> f64 {
        self.scaling.iter().zip(step).map(|(d, s)| (d * s).powi(2)).sum::<f64>().sqrt()
    }

    /// Largest entry of D of a block; 0 where it is fixed.
    fn weight(&self, id: BlockId) -> f64 {
        self.scaling[self.problem.columns_of(id)].iter().fold(0.0, |m: f64, s| m.max(*s))
    }

    /// Largest step of a block, relative to the block's own size or to the residual, whichever is larger, each as the
    /// block's columns see it.
    pub(crate) fn relative_length(&self, step: &[f64]) -> f64 {
        let residual = (2.0 * self.cost()).sqrt().max(f64::MIN_POSITIVE);
        let of_block = |id: BlockId| {
            let weight = self.weight(id);
            let size = (weight * norm(self.values.get(id))).max(residual);
            weight * norm(&step[self.problem.columns_of(id)]) / size
        };
        self.problem.block_ids().map(of_block).fold(0.0, f64::max)
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}
