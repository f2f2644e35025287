//! What users write: robots, sessions and simulations in TOML, and URDF; sessions drawn up from recordings, and simulated ones.
//!
//! [`read_session`] makes a [`Session`](gravcal_robot_model::Session) of a `session.toml` and all that it names, [`read_robot`] a robot of
//! a `robot.toml`; [`Simulation`](simulation::Simulation) draws sessions whose truth is known, and [`Draft`](draft::Draft) writes one to
//! start from. What is wrong in a file is told with its name, line and field ([`document`]). No estimator is known here.

mod file;

pub mod document;
pub mod draft;
pub mod robot_file;
pub mod sensor_models;
pub mod simulation;

#[cfg(test)]
extern crate self as gravcal_session;

#[cfg(test)]
mod doubts_tests;
#[cfg(test)]
mod testing;

pub use file::{
    SessionError, read_session, read_session_document, read_session_in_memory, read_session_watched, read_session_with,
    read_solver_options, solver_name_error, solver_option_error,
};
pub use robot_file::{read_robot, read_urdf};
