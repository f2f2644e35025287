//! What a study compares: `study.toml`, read and checked.
//!
//! ```toml
//! simulation = "../sarcos-shoulder/simulation.toml"   # robot, poses, truth, disturbances
//! # or random_arms = { know = "nominal" }    # a family of robots, one a trial; know = "nothing": see `gravcal_study::random_arms`
//! trials = 1000                              # at each point
//! seed = 1                                   # optional: that of the simulation without it
//! estimators = ["sequential", "joint"]
//! # besides those of a session: "sequential-true-step-1" and "sequential-true-steps-1-and-2", which are handed true results
//! solvers = ["levenberg-marquardt"]          # optional
//!
//! [[change]]                                 # optional: what is other than in the simulation's file, at every point
//! field = "torque.converter"                 # keys with dots between; 0, 1, … or * (every one) for the elements of a list
//! drop = true                                # or value = …
//!
//! [[change]]
//! field = "session.loss"                     # fields of `session` are those of session.toml: what the estimators are told
//! value = { kind = "huber" }
//!
//! [[vary]]                                   # optional: the points are the grid of all of these
//! name = "noise"
//! unit = "count"                             # optional
//! field = "torque.std"                       # or a list of fields, which all get the value
//! values = [0.1, 0.3, 1.0]
//!
//! [[vary]]
//! name = "range of motion"
//! unit = "deg"
//! cases = [                                  # several changes at once, with a name: a text or a number
//!     { name = 180, change = [{ field = "sweep.*.range_deg", value = [-90, 90] }] },
//!     { name = 60, change = [{ field = "sweep.*.range_deg", value = [-30, 30] }] },
//! ]
//!
//! [draw]                                     # optional: each trial has its own truth, within ± of the simulation's
//! torque_gain_relative = 0.3
//! torque_bias = 100                          # unit of the torque reading
//! position_gain_relative = 0.03
//! position_offset_deg = 20                   # but for the offsets that are choices of frames
//! gravity_deg = 10                           # angle by which gravity's direction is off
//! ```
//!
//! Paths are relative to the study, and in `session` too.

mod change;
mod compared;
mod draw;
mod file;
mod point;
mod point_files;
mod read;
mod source;

use std::path::{Path, PathBuf};

use gravcal_robot_model::Registry;
use gravcal_session::document::{Document, Field, FileError};

pub use compared::Compared;
pub use point::{Axis, Point};
pub(crate) use point::{Instance, places, reported};
pub use read::StudyError;
pub(crate) use read::{MOST_POINTS, MOST_TRIALS};

/// A study, with everything that its results depend on.
#[derive(Debug)]
pub struct Study {
    document: Document,
    /// Trials at each point.
    pub trials: u64,
    /// What is compared.
    pub estimators: Vec<Compared>,
    /// Names of the solvers that each estimator runs with.
    pub solvers: Vec<String>,
    /// What is varied.
    pub axes: Vec<Axis>,
    /// The grid, the last axis running fastest; one point where nothing is varied.
    pub points: Vec<Point>,
    /// Name and unit of each quantity whose errors are measured.
    pub quantities: Vec<(String, String)>,
    /// Every file that was read, the study first.
    pub inputs: Vec<PathBuf>,
    /// SHA-256 of all that the results depend on: the version of the program, what is said, the contents of the files that
    /// are named.
    pub fingerprint: String,
}

impl Study {
    /// Reads `study.toml` and everything it names.
    ///
    /// # Errors
    /// Names the file, the line and the field, and the point where a varied value does not fit.
    pub fn read(path: &Path) -> Result<Study, StudyError> {
        Study::read_with(path, &Registry::standard())
    }

    /// The same; `registry` says what simulations and sessions may name.
    ///
    /// # Errors
    /// As for [`Study::read`].
    pub fn read_with(path: &Path, registry: &Registry) -> Result<Study, StudyError> {
        read::read(path, registry)
    }

    /// An error in the field that names the solvers, for who knows which there are.
    pub fn solver_error(&self, message: impl std::fmt::Display) -> FileError {
        self.document.error(&Field::new("solvers"), message)
    }
}
