//! `[[force_torque_sensor]]` and `[[accelerometer]]`: instruments that read gravity besides the joints.
//!
//! Gains and biases that are written once hold for three axes, each of which is a parameter of its own.

mod found;
mod resolve;
mod section;
mod tables;

pub(crate) use found::Instruments;
pub(crate) use resolve::read_instruments;
pub(super) use resolve::{check_conditions, resolve};
pub(crate) use tables::{AccelerometerTable, ForceTorqueTable};
