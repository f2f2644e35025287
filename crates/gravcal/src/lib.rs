//! Calibration of a robot's joint torque and position sensors, and of gravity in its base frame, from static poses.
//!
//! This crate gives the library crates one name. Read a session, choose a method, run the estimators (`examples/without_files.rs` does it
//! with arrays and no file; the other examples show a study, a solver of one's own, and sensors that are no robot's):
//!
//! ```
//! use std::path::Path;
//!
//! use gravcal::calibration::{EstimatorName, SolveEnvironment, calibrate, read_session};
//! use gravcal::solvers::SolverName;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let session = read_session(Path::new("../../experiments/sarcos-shoulder/session.toml"))?;
//! let solver = SolverName::LevenbergMarquardt.build();
//! let environment = SolveEnvironment::new(solver.as_ref(), &|_stage| {});
//!
//! for result in calibrate(&session, &EstimatorName::DEFAULT, &environment) {
//!     println!("{}: {:?}", result.name, result.verdict);
//!     for parameter in result.parameters.iter().filter(|parameter| parameter.determined) {
//!         println!("  {} {:?} ± {:?} {}", parameter.name, parameter.value, parameter.std, parameter.unit);
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! | module | owns |
//! |---|---|
//! | `calibration` | sensor models, the session, the sequential and joint estimators, simulation, verdicts |
//! | [`estimation`] | nonlinear least squares: problem, covariance, identifiability; knows no robot |
//! | [`identification`] | from a problem to a judged answer: fit, noise, starts, profiles, what is determined; knows no robot |
//! | [`dynamics`] | robots from DH rows or URDF, gravity torque and inverse dynamics with their derivatives |
//! | `recording` | tables of static poses with units, in and out |
//! | `report` | summaries, tables, `calibration.json`, pages, exports to URDF, ROS 2, C and Python |
//! | [`solvers`] | the methods that minimise |
//! | `study` | simulated calibrations by the thousand, and what they come to |
//!
//! Those without a link need a feature: `calibration` brings `calibration` and `recording`, `report` (the default) all of them.
//! With `default-features = false` the mathematics alone is left, which reads no file; `urdf` adds robots from URDFs to it.

/// Robots and their sensors, sessions from files, arrays and simulation, and what the estimators answer.
#[cfg(feature = "calibration")]
pub mod calibration {
    pub use gravcal_calibration::*;
    pub use gravcal_robot_model::*;
    pub use gravcal_session::*;

    /// Robots, and their files.
    pub mod robot {
        pub use gravcal_robot_model::robot::*;
        pub use gravcal_session::robot_file::*;
    }

    /// Sessions, their files, and drafts of them.
    pub mod session {
        pub use gravcal_robot_model::session::*;
        pub use gravcal_session::draft::*;
        pub use gravcal_session::{
            SessionError, read_session, read_session_document, read_session_in_memory, read_session_watched,
            read_session_with, read_solver_options, solver_name_error, solver_option_error,
        };
    }
}

pub use gravcal_dynamics as dynamics;
pub use gravcal_estimation as estimation;
pub use gravcal_identification as identification;
#[cfg(feature = "calibration")]
pub use gravcal_recording as recording;
#[cfg(feature = "report")]
pub use gravcal_report as report;
pub use gravcal_solvers as solvers;
#[cfg(feature = "report")]
pub use gravcal_study as study;
