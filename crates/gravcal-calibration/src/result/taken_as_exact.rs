//! What the session takes as exact.

use std::fmt;

use gravcal_robot_model::number::significant;
use serde::Serialize;

/// Something that the session takes as exact, and the number that hangs on it most. Residuals need not show that it is wrong.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TakenAsExact {
    /// How wrong it would be if nobody has measured it, in words.
    pub wrong: String,
    /// Name of the parameter that this moves most.
    pub parameter: String,
    /// By how many of its standard deviations.
    pub off_in_std: f64,
    /// What to do, in words.
    pub cure: String,
}

impl fmt::Display for TakenAsExact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TakenAsExact { wrong, parameter, off_in_std, cure } = self;
        let times = significant(*off_in_std, 2);
        write!(f, "{wrong}, {parameter} would be off by {times} of its standard deviations ({cure})")
    }
}
