//! Gauss-Newton with a line search.
//!
//! Each iteration goes along the step to the minimum of the linear model (Nocedal and Wright, *Numerical optimization*, 2nd
//! edition, 2006, eq. 10.23),
//!
//! ```text
//!     J δ = −r in the sense of least squares,     x ← x ⊞ α δ
//! ```
//!
//! starting with `α = 1` and shortening until the decrease is sufficient (eq. 3.4, Armijo, with c₁ = 1e-4):
//!
//! ```text
//!     φ(α) = cost(x ⊞ α δ) ≤ φ(0) + c₁ α φ′(0),      φ′(0) = gᵀδ
//! ```
//!
//! The next α is the minimum of the parabola through φ(0), φ′(0) and the last φ (eq. 3.58), then of the cubic through the
//! last two (eq. 3.59), but between a tenth and a half of the last α. Where the model has no value, α is halved.
//!
//! The step is the shortest where J has lost rank ([`Point::full_step`]). Full steps converge fast where residuals are small
//! or the model is nearly linear. From afar, with J badly conditioned, δ can be so long and so nearly orthogonal to the
//! gradient that only an α next to nothing lowers the cost, and the iterates creep to where J is singular (Powell, *A hybrid
//! method for nonlinear equations*, 1970). Where α = 0.01 will not do, the iteration turns towards the gradient
//! by damping (Dennis and Schnabel, *Numerical methods for unconstrained optimization*, 1983, section 10.2, with λ = 1e-6,
//! 1e-4, 0.01, 1) and searches there; the record then shows λ.
//!
//! Left out: a curvature condition, which steps of length one make needless.

use gravcal_estimation::{Estimate, Problem, SolveContext, SolveError, Solver, Termination, Unsupported, Values};
use serde::Deserialize;

use crate::point::dot;
use crate::refusal::refuse_constraints;
use crate::{Decision, Descent, Dogleg, LevenbergMarquardt, Move, Point, StoppingRules, VariableProjection, minimise};

pub(crate) const NAME: &str = "gauss-newton";

/// c₁: share of the decrease along the slope that suffices.
const SUFFICIENT: f64 = 1e-4;
/// Shortest α worth trying along a direction while there is a better one.
const SHORTEST: f64 = 0.01;
/// Dampings of the directions that are tried after the full one; the last is nearly that of steepest descent.
const DAMPINGS: [f64; 4] = [1e-6, 1e-4, 1e-2, LAST_DAMPING];
const LAST_DAMPING: f64 = 1.0;

/// The method with its options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct GaussNewton {
    /// When it ends.
    pub stopping: StoppingRules,
}

impl Solver for GaussNewton {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        refuse_constraints(NAME, problem)
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        minimise(self, problem, initial, context)
    }

    fn companions(&self) -> Vec<Box<dyn Solver>> {
        vec![Box::new(Dogleg { stopping: self.stopping }), Box::new(VariableProjection { stopping: self.stopping })]
    }

    fn judge(&self) -> Option<Box<dyn Solver>> {
        Some(Box::new(LevenbergMarquardt { stopping: self.stopping }))
    }
}

impl Descent for GaussNewton {
    type Memory = ();

    fn stopping(&self) -> &StoppingRules {
        &self.stopping
    }

    fn iterate<'p>(&self, (): &mut (), here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        let direction = here.full_step();
        if let Some(next) = self.search(here, direction, 0.0) {
            return Ok(next);
        }
        for lambda in DAMPINGS {
            let direction = here.damped_step(lambda);
            if let Some(next) = self.search(here, direction, lambda) {
                return Ok(next);
            }
        }
        Ok(Move::Stay(Termination::NoProgress))
    }
}

impl GaussNewton {
    /// Searches along a direction, which promises a reduction of the cost. Nothing where not even a short step will do.
    fn search<'p>(&self, here: &mut Point<'p>, (direction, promise): (Vec<f64>, f64), lambda: f64) -> Option<Move<'p>> {
        let slope = dot(here.linearization.gradient(), &direction);
        let shortest = if lambda < LAST_DAMPING { SHORTEST } else { 0.0 };
        let mut search = LineSearch { slope, before: None };
        let mut alpha = 1.0;
        while slope < 0.0 && alpha > shortest {
            let step: Vec<f64> = direction.iter().map(|d| alpha * d).collect();
            // −α gᵀδ − ½ α² ‖J δ‖², with ‖J δ‖² from the promise for α = 1.
            let mut trial = here.attempt(&step, alpha * (alpha * promise - (1.0 - alpha) * slope));
            match here.decide(&mut trial, -SUFFICIENT * alpha * slope, &self.stopping) {
                Decision::Accept(end) => return Some(Move::To { trial: Box::new(trial), damping: lambda, end }),
                Decision::End(end) => return Some(Move::Stay(end)),
                Decision::Shorten => alpha = search.shorter(alpha, -trial.actual),
            }
        }
        None
    }
}

/// Backtracking by interpolation of `φ(α) − φ(0)`.
struct LineSearch {
    /// φ′(0).
    slope: f64,
    /// The α tried before, and its φ − φ(0).
    before: Option<(f64, f64)>,
}

impl LineSearch {
    /// The α to try after one with the given rise φ − φ(0), which may be infinite.
    fn shorter(&mut self, alpha: f64, rise: f64) -> f64 {
        if !rise.is_finite() {
            return 0.5 * alpha;
        }
        let lowest = match self.before.replace((alpha, rise)) {
            None => -self.slope * alpha * alpha / (2.0 * (rise - self.slope * alpha)),
            Some(before) => self.cubic_minimum(before, (alpha, rise)),
        };
        // An interpolation that fails (NaN) is no better than halving.
        if lowest.is_nan() { 0.5 * alpha } else { lowest.clamp(0.1 * alpha, 0.5 * alpha) }
    }

    /// Eq. 3.59: the minimum of `a α³ + b α² + φ′(0) α` through two points.
    fn cubic_minimum(&self, (alpha0, rise0): (f64, f64), (alpha1, rise1): (f64, f64)) -> f64 {
        let excess = |alpha: f64, rise: f64| (rise - self.slope * alpha) / (alpha * alpha);
        let (e0, e1) = (excess(alpha0, rise0), excess(alpha1, rise1));
        let a = (e1 - e0) / (alpha1 - alpha0);
        let b = e1 - a * alpha1;
        if a == 0.0 { -self.slope / (2.0 * b) } else { (-b + (b * b - 3.0 * a * self.slope).sqrt()) / (3.0 * a) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search() -> LineSearch {
        LineSearch { slope: -1.0, before: None }
    }

    #[test]
    fn a_parabola_is_shortened_to_its_minimum() {
        // φ(α) − φ(0) = −α + 1.5 α², lowest at 1/3.
        assert!((search().shorter(1.0, 0.5) - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_cubic_is_shortened_to_its_minimum() {
        // −α + 2 α² + 3 α³, lowest at (−2 + √13)/9.
        let rise = |alpha: f64| -alpha + 2.0 * alpha * alpha + 3.0 * alpha.powi(3);
        let mut search = search();
        let second = search.shorter(1.0, rise(1.0));
        assert!((second - 0.1).abs() < 1e-15, "no further than a tenth");
        search.before = Some((1.0, rise(1.0)));
        assert!((search.shorter(0.4, rise(0.4)) - (13f64.sqrt() - 2.0) / 9.0).abs() < 1e-12);
    }

    #[test]
    fn where_the_model_has_no_value_the_step_is_halved() {
        assert_eq!(search().shorter(1.0, f64::INFINITY), 0.5);
    }
}
