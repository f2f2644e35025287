//! When a method ends: one set of rules for all of them.
//!
//! ```text
//!     gradient     max_j |j_jᵀ r| / (‖j_j‖ ‖r‖) ≤ cosine tolerance       r orthogonal to every column j_j of J
//!     offset       ‖J δ‖ / ‖r‖ ≤ 10 · cosine tolerance                   r orthogonal to whatever J δ there is
//!     step         max_b ‖D_b δ_b‖ / max(‖D_b x_b‖, ‖r‖) ≤ step tolerance    over the blocks b
//!     cost         predicted and actual reduction ≤ cost tolerance · cost or rounding, and no less to gain there than here
//! ```
//!
//! The offset (Bates and Watts, *Technometrics* 23, 1981) is that of a step with a damping of 1e-8: directions 1e4 times weaker than the
//! columns count for less in it than by themselves, though for more than in the cosine. It is not asked under constraints.
//!
//! Under constraints what they hold back is taken off the cosine, and the full step is the best of those that obey them.
//!
//! All are pure numbers: no unit and no scale of a parameter or a residual changes them. Three are those of MINPACK
//! (Moré, Garbow, Hillstrom, *User guide for MINPACK-1*, 1980: `gtol`, `xtol`, `ftol`), the second by block, so that one
//! block of wandering values cannot make the steps of the others look small.
//!
//! **A short step proves nothing by itself**: heavy damping, a small trust region or a line search that fails make any
//! step short. Step and cost are counted as convergence only where the full step says the same
//! ([`Point::at_model_minimum`](crate::Point::at_model_minimum)); otherwise the method has made no progress.

use gravcal_estimation::SolveError;
use serde::Deserialize;
use serde::de::{Deserializer, Error, Unexpected};

/// The options that every method has.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table of options")]
pub struct StoppingRules {
    /// Iterations allowed; at least 1.
    #[serde(deserialize_with = "count")]
    pub max_iterations: usize,
    /// Ends where the largest |cosine| between the residual and a column of J is at most this, or the relative offset ten times this;
    /// between 0 and 1.
    #[serde(deserialize_with = "tolerance")]
    pub cosine_tolerance: f64,
    /// Ends where the step of every block is at most this share of the block or of the residual, scaled by D.
    #[serde(deserialize_with = "tolerance")]
    pub step_tolerance: f64,
    /// Ends where predicted and actual reduction are at most this share of the cost, or as little as rounding hides.
    #[serde(deserialize_with = "tolerance")]
    pub cost_tolerance: f64,
}

impl Default for StoppingRules {
    fn default() -> Self {
        // Curved valleys take thousands of steps: NIST's MGH10 from its far start.
        StoppingRules { max_iterations: 10_000, cosine_tolerance: 1e-10, step_tolerance: 1e-13, cost_tolerance: 1e-14 }
    }
}

impl StoppingRules {
    /// # Errors
    /// Names an option outside of its range.
    pub(crate) fn check(&self, solver: &'static str) -> Result<(), SolveError> {
        if self.max_iterations == 0 {
            let (option, expected) = ("max_iterations", COUNT);
            return Err(SolveError::Option { solver, option, value: 0.0, expected });
        }
        let tolerances = [
            ("cosine_tolerance", self.cosine_tolerance),
            ("step_tolerance", self.step_tolerance),
            ("cost_tolerance", self.cost_tolerance),
        ];
        match tolerances.into_iter().find(|(_, value)| !is_tolerance(*value)) {
            Some((option, value)) => Err(SolveError::Option { solver, option, value, expected: TOLERANCE }),
            None => Ok(()),
        }
    }
}

const COUNT: &str = "a whole number of at least 1";
const TOLERANCE: &str = "a number between 0 and 1";

fn is_tolerance(value: f64) -> bool {
    value > 0.0 && value < 1.0
}

fn count<'de, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
    match usize::deserialize(deserializer)? {
        0 => Err(D::Error::invalid_value(Unexpected::Unsigned(0), &COUNT)),
        count => Ok(count),
    }
}

fn tolerance<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if is_tolerance(value) { Ok(value) } else { Err(D::Error::invalid_value(Unexpected::Float(value), &TOLERANCE)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<StoppingRules, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_not_said_has_its_default() {
        let rules = read(r#"{ "max_iterations": 7 }"#).unwrap();
        assert_eq!(rules, StoppingRules { max_iterations: 7, ..StoppingRules::default() });
    }

    #[test]
    fn senseless_options_are_refused_with_what_was_expected() {
        let refused = |text: &str, reported: &str| {
            let error = read(text).unwrap_err();
            assert!(error.contains(reported), "{error}");
        };
        refused(r#"{ "max_iterations": 0 }"#, "invalid value: integer `0`, expected a whole number of at least 1");
        refused(r#"{ "cosine_tolerance": 1 }"#, "expected a number between 0 and 1");
        refused(r#"{ "step_tolerance": -1e-9 }"#, "invalid value: floating point `-1e-9`");
        refused(r#"{ "radius": 1 }"#, "unknown field `radius`, expected one of `max_iterations`, `cosine_tolerance`");
    }
}
