//! What joint sensors do beyond gain and bias, gain and offset.
//!
//! ```text
//!     reading of torque    y_i = k_i τ_i + b_i + Σ_p a_p φ_p(τ, conditions)
//!     joint coordinate     θ_i = s_i q_i + o_i + Σ_p a_p ψ_p(q_i)
//! ```
//!
//! Each *term* is one named parameter `a_p` and one known function: `φ` of the torques of all joints and of the conditions
//! of the pose ([`TorqueFunction`]), or `ψ` of the joint's own position reading ([`PositionFunction`]). A model of a sensor
//! is the terms that one file here declares. Affine sensors have none, and cost nothing.
//!
//! **To add a model**: a file here with the functions and their declaration, and its name in [`SensorModelName`] and `models.rs`.

mod crosstalk;
mod declare;
mod drift;
mod file;
mod friction;
mod harmonics;
mod models;
mod name;
mod polynomial;
mod readings;
#[cfg(test)]
mod saturation;
mod terms;
#[cfg(test)]
pub(crate) mod testing;

#[cfg(test)]
pub(crate) use declare::Options;
pub(crate) use declare::{RefusedOption, Site};
pub use file::DeclaredModels;
pub(crate) use file::{DeclaredInFile, ModelTable, declare, to_unit_of};
pub use name::{Need, SensorModelName, UnknownSensorModel};
pub(crate) use terms::Term;
pub use terms::{Function, PositionFunction, SensorTerms, TorqueFunction};
