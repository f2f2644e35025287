//! A session as it truly is.

use nalgebra::Vector3;

use super::arm::Arm;

/// Magnitude of gravity, m/s².
pub const GRAVITY: f64 = 9.80665;
/// Names of the two placements of the load.
pub const PLACEMENTS: [&str; 2] = ["a", "b_place"];

/// An arm, what its sensors truly are, where it stood, and what the session says of it.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The arm.
    pub arm: Arm,
    /// Gravity in base coordinates, m/s².
    pub gravity: Vector3<f64>,
    /// By joint.
    pub sensors: Sensors,
    /// The sensor between the last link and the tool, if there is one.
    pub wrist: Option<Wrist>,
    /// Of each channel's readings, in their unit: the joints' torques, and the wrist's axes behind them.
    pub noise: Vec<f64>,
    /// Mass of the load, kg.
    pub mass: f64,
    /// Its centre at each placement that a table names, in the tip's frame, m. Of two, the session says how far they are apart.
    pub placements: Vec<Vector3<f64>>,
    /// The poses.
    pub tables: Vec<Table>,
    /// Errors of the readings, in units of their noise, in the order in which the model predicts them.
    pub errors: Vec<f64>,
    /// What the session says.
    pub said: Said,
}

/// `reading = torque_gain · torque + torque_bias`, `coordinate = position_gain · reading + position_offset`.
#[derive(Clone, Debug)]
pub struct Sensors {
    /// In the torque readings' unit for each newton metre.
    pub torque_gain: Vec<f64>,
    /// In the torque readings' unit.
    pub torque_bias: Vec<f64>,
    /// Without unit.
    pub position_gain: Vec<f64>,
    /// rad; that of the first joint, which defines the base's heading, is zero.
    pub position_offset: Vec<f64>,
}

/// A six-axis sensor in the tip's frame, read in N and N·m, and the tool beyond it.
#[derive(Clone, Debug)]
pub struct Wrist {
    /// Of each axis.
    pub gain: [f64; 6],
    /// Of each axis, N and N·m.
    pub bias: [f64; 6],
    /// Mass, kg, and first moment, kg·m, of the tool in the tip's frame.
    pub tool: [f64; 4],
    /// Whether the session says the tool's mass.
    pub mass_said: bool,
}

impl Wrist {
    /// Its name in the session.
    pub const NAME: &str = "wrist";
    /// Its axes.
    pub const AXES: [&str; 6] = ["fx", "fy", "fz", "nx", "ny", "nz"];
    /// What is unknown of the tool.
    pub const TOOL: [&str; 4] = ["tool_mass", "tool_moment_x", "tool_moment_y", "tool_moment_z"];
}

/// Poses with one load, or none.
#[derive(Clone, Debug)]
pub struct Table {
    /// Index of the placement.
    pub placement: Option<usize>,
    /// Coordinates of each pose, rad.
    pub angles: Vec<Vec<f64>>,
}

/// What the session says beyond what it must.
#[derive(Clone, Copy, Debug)]
pub struct Said {
    /// Torques are read in counts, else in newton metres.
    pub counts: bool,
    /// Angles are read in degrees, else in radians.
    pub degrees: bool,
    /// The noise of the torque readings.
    pub std: bool,
    /// The rough direction of gravity.
    pub hemisphere: bool,
}

impl Truth {
    /// How many readings a pose has.
    pub fn channels(&self) -> usize {
        self.noise.len()
    }

    /// Whether an unknown is none: the first joint's position offset, which defines the base's heading, and what the session says exactly.
    pub fn knows(&self, name: &str) -> bool {
        let said = self.wrist.as_ref().is_some_and(|wrist| wrist.mass_said);
        name == format!("{}.position_offset", self.arm.joints[0].name)
            || said && name == format!("{}.{}", Wrist::NAME, Wrist::TOOL[0])
    }

    /// How many readings.
    pub fn readings(&self) -> usize {
        self.channels() * self.tables.iter().map(|table| table.angles.len()).sum::<usize>()
    }

    /// What the position sensors read at a pose, rad.
    pub fn position_readings(&self, angles: &[f64]) -> Vec<f64> {
        let Sensors { position_gain, position_offset, .. } = &self.sensors;
        let sensors = position_gain.iter().zip(position_offset);
        angles.iter().zip(sensors).map(|(angle, (gain, offset))| (angle - offset) / gain).collect()
    }
}
