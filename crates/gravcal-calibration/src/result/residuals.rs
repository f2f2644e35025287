//! Every reading beside what a fitted model makes of it.

/// One reading and its residuals, in the unit of the reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingResidual {
    /// Index into [`Session::poses`](gravcal_robot_model::Session).
    pub pose: usize,
    /// Which reading of it: see [`Session::reading`](gravcal_robot_model::Session::reading).
    pub channel: usize,
    /// Prediction less reading.
    pub residual: f64,
    /// The same before the calibration: sensors at their nominal values, gravity, moments and placements as found.
    pub nominal_residual: f64,
    /// Standard deviation that the fit assumed.
    pub std: f64,
    /// How much a robust loss counts it: from 0 (not at all) to 1 (as without a loss).
    pub weight: f64,
}
