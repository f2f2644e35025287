//! Where joints were found not to be where their position sensors say.

use serde::Serialize;

/// How far a standing joint was from where its calibrated position sensor says, in all poses of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeflectionResult {
    /// File name of the table.
    pub table: String,
    /// Lines of the first and last pose in it.
    pub lines: [u64; 2],
    /// The joint.
    pub joint: String,
    /// Unit of value and standard deviations.
    pub unit: String,
    /// `null` where the readings say hardly more than was known: where `std` exceeds half of `prior_std`.
    pub value: Option<f64>,
    /// Its standard deviation, readings and prior together.
    pub std: f64,
    /// The standard deviation before any reading.
    pub prior_std: f64,
}

/// Errors of one joint's positions that differ from pose to pose, in short.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PositionErrorResult {
    /// The joint.
    pub joint: String,
    /// Unit of the following.
    pub unit: String,
    /// In how many poses.
    pub poses: usize,
    /// Root mean square of the errors found.
    pub rms: f64,
    /// Root mean square of their standard deviations, readings and prior together.
    pub std: f64,
    /// The same before any reading.
    pub prior_std: f64,
    /// Whether the readings tell them: whether `std` is at most half of `prior_std`.
    pub observable: bool,
}
