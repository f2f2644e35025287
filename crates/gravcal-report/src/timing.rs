//! `timing.json`: how long the parts of a calibration took. Apart from the results, whose bytes are compared.

use serde::Serialize;

use crate::json::{JsonError, json};

/// Milliseconds that each part took, as measured by the caller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Timing {
    /// Reading the session and all that it names.
    pub read_ms: f64,
    /// Finding starting values.
    pub start_ms: f64,
    /// Solving.
    pub solve_ms: f64,
    /// Judging the solutions.
    pub judge_ms: f64,
}

impl Timing {
    /// The contents of `timing.json`, to the microsecond.
    ///
    /// # Errors
    /// None that is known of.
    pub fn to_json(&self) -> Result<String, JsonError> {
        let rounded = |ms: f64| (ms * 1e3).round() / 1e3;
        json(&Timing {
            read_ms: rounded(self.read_ms),
            start_ms: rounded(self.start_ms),
            solve_ms: rounded(self.solve_ms),
            judge_ms: rounded(self.judge_ms),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn microseconds_are_enough() {
        let timing = Timing { read_ms: 1.234_567_8, start_ms: 0.0, solve_ms: 250.0, judge_ms: 3.5 };
        assert_eq!(
            timing.to_json().unwrap(),
            "{\n  \"read_ms\": 1.235,\n  \"start_ms\": 0.0,\n  \"solve_ms\": 250.0,\n  \"judge_ms\": 3.5\n}\n"
        );
    }
}
