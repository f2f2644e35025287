//! A robot as everything else sees it.

use gravcal_dynamics::Chain;
use gravcal_recording::{PositionUnit, TorqueUnit};

/// A robot with the nominal values of its sensors.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name, for output.
    pub name: String,
    /// Joints, links, and the links' assumed masses.
    pub chain: Chain,
    /// One for each joint that has a coordinate of its own.
    pub sensors: Vec<NominalSensors>,
}

/// What a maker's sheet says of the sensors of one joint. Absent where the robot file is silent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NominalSensors {
    /// The torque sensor: `reading = gain · torque + bias`.
    pub torque: Option<NominalTorqueSensor>,
    /// The position sensor: `coordinate = gain · reading + offset`.
    pub position: Option<NominalPositionSensor>,
}

/// Nominal `reading = gain · torque + bias` (paper, eq. (8)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalTorqueSensor {
    /// Unit of the reading.
    pub unit: TorqueUnit,
    /// Reading units a N·m (or a N).
    pub gain: f64,
    /// Reading at no torque.
    pub bias: f64,
}

/// Nominal `coordinate = gain · reading + offset` (paper, eq. (3)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalPositionSensor {
    /// Unit of the reading.
    pub unit: PositionUnit,
    /// rad (or m) a unit of the reading *in SI*: a pure number for readings of an angle, rad/count for counts.
    pub gain: f64,
    /// rad (or m).
    pub offset: f64,
}
