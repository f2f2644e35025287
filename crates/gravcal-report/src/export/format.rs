//! The formats by their names.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// The formats that a user can choose by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Parameters of a ROS 2 node.
    Ros2,
    /// The robot's description, corrected.
    Urdf,
    /// The arm for MuJoCo.
    Mujoco,
    /// Loads of unknown mass and the mount's gravity, as drivers take them.
    Payload,
    /// Every parameter, for programs.
    Csv,
    /// A header with functions.
    C,
    /// A module with functions.
    Python,
    /// A table.
    Markdown,
    /// A table.
    Latex,
}

impl ExportFormat {
    /// Every format.
    pub const ALL: [ExportFormat; 9] = [
        ExportFormat::Ros2,
        ExportFormat::Urdf,
        ExportFormat::Mujoco,
        ExportFormat::Payload,
        ExportFormat::Csv,
        ExportFormat::C,
        ExportFormat::Python,
        ExportFormat::Markdown,
        ExportFormat::Latex,
    ];

    /// The name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            ExportFormat::Ros2 => "ros2",
            ExportFormat::Urdf => "urdf",
            ExportFormat::Mujoco => "mujoco",
            ExportFormat::Payload => "payload",
            ExportFormat::Csv => "csv",
            ExportFormat::C => "c",
            ExportFormat::Python => "python",
            ExportFormat::Markdown => "markdown",
            ExportFormat::Latex => "latex",
        }
    }

    /// Whether it describes the robot itself, in which torque sensors and instruments have no place.
    pub fn is_robot(self) -> bool {
        matches!(self, ExportFormat::Urdf | ExportFormat::Mujoco)
    }
}

impl fmt::Display for ExportFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No format has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown format `{name}`; there is: {}", ExportFormat::ALL.map(ExportFormat::as_str).join(", "))]
pub struct UnknownFormat {
    name: String,
}

impl FromStr for ExportFormat {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        let found = ExportFormat::ALL.into_iter().find(|format| format.as_str() == name);
        found.ok_or_else(|| UnknownFormat { name: name.to_owned() })
    }
}
