//! What a file is for that a result was made from.

use serde::{Deserialize, Serialize};

/// What a file is for that a result was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InputRole {
    /// It says what is calibrated, or simulated.
    Session,
    /// It describes the robot.
    Robot,
    /// It holds readings.
    Recording,
    /// An earlier calibration, whose knowledge enters.
    Calibration,
}
