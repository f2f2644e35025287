//! Damping that follows the ratio of actual to predicted reduction.
//!
//! ```text
//!     accepted   λ ← λ max(1/10, 1 − (2ρ − 1)³)     growth ← 2
//!     rejected   λ ← λ · growth                     growth ← 2 · growth
//! ```
//!
//! Nielsen, *Damping parameter in Marquardt's method*, IMM-REP-1999-05, eq. 2.5. Beyond the source, λ falls to a tenth (there
//! to a third) and grows by at most 2 after an accepted step.
//!
//! Where no step of growing damping lowers the cost, rounding may hide what so short a step gains, while a less damped one still gains something:
//! at the end of a bent valley. So less damped ones are tried then, down to that of the first.
//!
//! A start may be near the end already (the one of a fit that was handed down, or of the same fit to fewer readings). So a step that is
//! all but undamped is tried first, and taken where it is short and does what the linear model says; from there on it is the method of
//! Gauss and Newton. Else λ starts as if it had not been tried.
//!
//! The first step from afar is bounded by `‖D δ‖ ≤ 0.2 ‖D x‖` (Moré, *The Levenberg-Marquardt algorithm: implementation and theory*,
//! 1978, section 3, with a smaller factor): without it a start with one parameter far too small is left for a plateau at
//! infinity, as with NIST's BoxBOD from its far start.

use gravcal_estimation::{SolveError, Termination};
use serde::{Deserialize, Serialize};

use crate::{Decision, Move, Point, StoppingRules};

/// Damping beyond which a step is shorter than rounding.
const MAX_DAMPING: f64 = 1e32;
/// Damping at the start, relative to the column norms.
const INITIAL_DAMPING: f64 = 1e-3;
/// Damping of a first step that is tried before, as the start may be near the end already.
const NEAR_DAMPING: f64 = 1e-8;
/// The start is near where that step is at most this share of what it moves, and does what the linear model says but for so much.
const NEAR_START: f64 = 0.005;
const NEAR_RATIO: f64 = 0.1;
/// The first step is at most this share of what it moves.
const FIRST_STEP: f64 = 0.2;
/// What less damped steps have of the damping of those before, where none of more damping lowers the cost.
const LESS_DAMPED: f64 = 0.1;
/// Growth of the damping while a step is too long, and where that ends.
const LONG_GROWTH: f64 = 3.0;
const MAX_LONG_DAMPING: f64 = 1e4;

/// λ, and by what it grows after the next rejected step.
#[derive(Debug, Serialize, Deserialize)]
pub struct Damping {
    lambda: f64,
    growth: f64,
    /// Whether the start may still turn out to be near the end.
    #[serde(default)]
    near: bool,
    /// Whether the first step has been bounded.
    bounded: bool,
}

impl Default for Damping {
    fn default() -> Self {
        Damping { lambda: NEAR_DAMPING, near: true, ..Damping::from_afar() }
    }
}

impl Damping {
    /// Of a start that is not taken to be near the end.
    pub(crate) fn from_afar() -> Self {
        Damping { lambda: INITIAL_DAMPING, growth: 2.0, near: false, bounded: false }
    }

    /// λ.
    pub(crate) fn lambda(&self) -> f64 {
        self.lambda
    }

    /// Whether the first step should be tried shorter: it is too long, and λ was raised. Asked of no later step.
    pub(crate) fn shortens_first_step(&mut self, here: &Point<'_>, step: &[f64]) -> bool {
        if self.near {
            let is_far = here.scaled_length(step) > NEAR_START * here.size();
            if is_far {
                *self = Damping::from_afar();
            }
            return is_far;
        }
        if self.bounded {
            return false;
        }
        let longest = FIRST_STEP * here.size();
        self.bounded = longest == 0.0 || here.scaled_length(step) <= longest || !self.raise();
        !self.bounded
    }

    /// Whether the first step was tried as if the start were near the end, and must be tried anew, as it is not.
    pub(crate) fn begins_from_afar(&mut self, ratio: f64) -> bool {
        let as_predicted = (ratio - 1.0).abs() <= NEAR_RATIO; // which no NaN is
        let begins = self.near && !as_predicted;
        if begins {
            *self = Damping::from_afar();
        }
        begins
    }

    /// For a step that is too long to be tried. `false` where more damping would be of no use.
    pub(crate) fn raise(&mut self) -> bool {
        let go_on = self.lambda < MAX_LONG_DAMPING;
        if go_on {
            self.lambda *= LONG_GROWTH;
        }
        go_on
    }

    /// After an accepted step with this ratio of actual to predicted reduction.
    pub(crate) fn accept(&mut self, ratio: f64) {
        (self.near, self.bounded) = (false, true);
        self.lambda *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(0.1, 2.0);
        self.growth = 2.0;
    }

    /// After a rejected step. `false` where no step is left to try.
    pub(crate) fn reject(&mut self) -> bool {
        if self.near {
            *self = Damping::from_afar();
            return true;
        }
        let go_on = self.lambda <= MAX_DAMPING;
        self.lambda *= self.growth;
        self.growth *= 2.0;
        go_on
    }
}

/// Tries steps of growing damping until one lowers the cost; the first perhaps nearly undamped (see [`Damping`]). Where none does, of less
/// damping than at first.
pub(crate) fn damped_iteration<'p>(
    damping: &mut Damping,
    here: &mut Point<'p>,
    rules: &StoppingRules,
) -> Result<Move<'p>, SolveError> {
    let first = if damping.near { INITIAL_DAMPING } else { damping.lambda };
    loop {
        let lambda = damping.lambda();
        if let Some((step, predicted)) = here.step(lambda) {
            if damping.shortens_first_step(here, &step) {
                continue;
            }
            let mut trial = here.attempt(&step, predicted);
            if damping.begins_from_afar(trial.ratio()) {
                continue;
            }
            match here.decide(&mut trial, 0.0, rules) {
                Decision::Accept(end) => {
                    damping.accept(trial.ratio());
                    return Ok(Move::To { trial: Box::new(trial), damping: lambda, end });
                }
                Decision::End(Termination::NoProgress) => break,
                Decision::End(end) => return Ok(Move::Stay(end)),
                Decision::Shorten => {}
            }
        }
        if !damping.reject() {
            break;
        }
    }
    Ok(less_damped(damping, first, here, rules))
}

/// Tries steps of less damping than this until one lowers the cost.
fn less_damped<'p>(damping: &mut Damping, first: f64, here: &mut Point<'p>, rules: &StoppingRules) -> Move<'p> {
    *damping = Damping { lambda: first, growth: 2.0, near: false, bounded: true };
    while damping.lambda > NEAR_DAMPING {
        damping.lambda *= LESS_DAMPED;
        let lambda = damping.lambda;
        let Some((step, predicted)) = here.step(lambda) else { continue };
        let mut trial = here.attempt(&step, predicted);
        match here.decide(&mut trial, 0.0, rules) {
            Decision::Accept(end) => {
                damping.accept(trial.ratio());
                return Move::To { trial: Box::new(trial), damping: lambda, end };
            }
            Decision::End(end) => return Move::Stay(end),
            Decision::Shorten => {}
        }
    }
    Move::Stay(Termination::NoProgress)
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{EvaluateError, SolveContext, Solver};

    use crate::LevenbergMarquardt;
    use crate::testing::{built, scalar};

    /// `y = x²` to within 0.1, `x = 1` to within 100, and a level of which two readings are 2000 apart: their misfit is most of the cost, and its rounding,
    /// here 2e-8, hides what steps gain that are damped as at the start. The undamped one leaves the valley.
    fn bent_valley(x: &[f64], r: &mut [f64], j: &mut [f64]) -> Result<(), EvaluateError> {
        let rounding = 2e-11 * (1e9 * (x[0] - 0.5)).sin().abs();
        r.copy_from_slice(&[10.0 * (x[1] - x[0] * x[0]), 0.01 * (1.0 - x[0]), x[2] + 1e3, x[2] - 1e3 - rounding]);
        j.copy_from_slice(&[-20.0 * x[0], 10.0, 0.0, -0.01, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        Ok(())
    }

    #[test]
    fn what_rounding_hides_of_heavily_damped_steps_less_damped_ones_gain() {
        let (problem, start) = built(vec![scalar("x", 0.5), scalar("y", 0.25), scalar("level", 0.0)], 4, bent_valley);
        let found = LevenbergMarquardt::default().solve(&problem, &start, &mut SolveContext::default()).unwrap();
        let x = found.values.scalar(problem.find("x").unwrap());
        assert!((x - 1.0).abs() < 0.05, "{} {x}", found.termination);
    }
}
