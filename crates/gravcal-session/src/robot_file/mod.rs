//! Robots from files: `robot.toml` and URDF.

mod branches_file;
mod file;
mod sensors_file;
mod source;
#[cfg(test)]
mod tests;

pub use crate::document::FileError;
pub(crate) use branches_file::MountingTable;
pub use file::{read_robot, read_urdf};
pub(crate) use sensors_file::{PositionSensorTable, SensorTables, TorqueSensorTable, ValueTable};
pub(crate) use source::{RobotSource, resolve_robot};
