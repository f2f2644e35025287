//! Every reading beside what a fitted model makes of it.

use gravcal_robot_model::session::ReadingId;

/// One reading and its residuals, in the unit of the reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingResidual {
    /// Which one.
    pub id: ReadingId,
    /// Prediction less reading.
    pub residual: f64,
    /// The same before the calibration: sensors at their nominal values, gravity, moments and placements as found.
    pub nominal_residual: f64,
    /// Standard deviation that the fit assumed.
    pub std: f64,
    /// How much a robust loss counts it: from 0 (not at all) to 1 (as without a loss).
    pub weight: f64,
    /// Of what the prediction is made, where an arm in motion was read.
    pub torque: Option<TorqueParts>,
}

/// Parts of the predicted reading of a joint in motion, in the unit of the reading; what is left of the prediction is friction and whatever else
/// its sensor does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueParts {
    /// What gravity makes it read.
    pub gravity: f64,
    /// What accelerations and velocities of bodies and rotors make it read.
    pub inertia: f64,
    /// Its bias.
    pub bias: f64,
}
