//! Static poses: what every sensor reads while the robot stands still.

use crate::conditions::Conditions;
use crate::orientation::Orientation;

/// A measured value and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The value, in N·m (N at a prismatic joint) or the sensor's own unit (count, V).
    pub value: f64,
    /// Standard deviation of `value`, in the same unit, greater than 0: of the mean, where the value is a mean.
    /// `None` if neither table nor mapping gives one.
    pub std: Option<f64>,
}

/// One standstill of the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StaticPose {
    /// Line in the file, counted from 1; of the first row, if rows were merged.
    pub line: u64,
    /// Position reading of every joint, in rad, m, or the sensor's own unit (count, V).
    pub position: Vec<f64>,
    /// How the body that carries the instruments stood, where the mapping has columns of it.
    pub orientation: Option<Orientation>,
    /// Torque reading of every joint; `None` where there is none, or none that is usable.
    pub torque: Vec<Option<Reading>>,
    /// Reading of every instrument column, in its own unit; `None` where it is missing or not usable.
    pub instruments: Vec<Option<Reading>>,
    /// Joints whose torque reading is at an end of its range, and therefore none: see [`is_saturated`](crate::is_saturated).
    pub saturated: Vec<usize>,
    /// Label of the sweep that the pose belongs to.
    pub sweep: Option<String>,
    /// Under which conditions it was read.
    pub conditions: Conditions,
    /// How many rows of the table became this pose, at least 1. A joint may have fewer readings.
    pub merged: u32,
}
