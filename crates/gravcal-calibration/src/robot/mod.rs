//! A robot: its chain of joints, and what is nominally known of its sensors.

mod branches_file;
mod file;
mod model;
mod sensors_file;
mod source;
#[cfg(test)]
mod tests;

pub use crate::document::FileError;
pub(crate) use branches_file::MountingTable;
pub use file::{read_robot, read_urdf};
pub use model::{NominalPositionSensor, NominalSensors, NominalTorqueSensor, Robot};
pub(crate) use sensors_file::{PositionSensorTable, SensorTables, TorqueSensorTable, ValueTable};
pub(crate) use source::{RobotSource, resolve_robot};
