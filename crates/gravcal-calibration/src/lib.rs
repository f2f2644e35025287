//! Identification of joint sensors and gravity from static poses.
//!
//! From static poses of a robot (readings of its joint position and torque sensors) this crate finds each torque
//! sensor's gain and bias, each position sensor's gain and offset, and gravity in the base frame:
//!
//! ```text
//!     reading of torque    y_i = k_i τ_i(θ; g, moments, load) + b_i        (paper, eqs. (5)–(8))
//!     joint coordinate     θ_i = s_i q_i + o_i                             (paper, eq. (3))
//! ```
//!
//! after Ma, Hollerbach and Xu, *Gravity Based Autonomous Calibration for Robot Manipulators*, 1994. Two estimators
//! share the residuals of [`gravcal_robot_model::residuals`]: the paper's [`sequential`] steps, and the [`joint`] problem over everything, whose
//! readings enter together or [group by group](joint::Order).
//!
//! Inside: SI units and radians; torque readings in the unit of their sensor. A [`Session`](gravcal_robot_model::Session) is what a user says,
//! [`calibrate`] what the estimators answer.

mod calibrate;
mod closed_form;
mod judgement;
mod plan;

pub mod application;
pub mod check;
pub mod comparison;
pub mod joint;
pub mod result;
pub mod sequential;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use calibrate::{UnsuitableChoice, calibrate, calibrate_briefly, check_choice};
pub use gravcal_identification::SolveEnvironment;
pub use judgement::doubts_of_results;
