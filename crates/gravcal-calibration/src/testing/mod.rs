//! What the tests of this crate share.

pub mod sensor_models;
#[path = "../../../gravcal-session/src/testing.rs"]
mod sessions;

use std::path::{Path, PathBuf};

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;
use gravcal_session::read_session;
use gravcal_solvers::LevenbergMarquardt;

pub use sessions::*;

/// Runs something with the default solver.
pub fn with_environment<T>(run: impl FnOnce(&SolveEnvironment<'_>) -> T) -> T {
    let solver = LevenbergMarquardt::default();
    run(&SolveEnvironment::new(&solver, &|_: &str| {}))
}

/// `GRAVCAL_SHARED_DATA` or `../shared/data` beside the project; it may not be there.
pub fn shared_data() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from)
}

/// A session of the inputs on which the program once fell short, in the shared data; nothing where they are not there.
pub fn shared_session(name: &str) -> Option<Session> {
    let file = shared_data().join("damaged/sessions").join(name).join("session.toml");
    if !file.is_file() {
        return None;
    }
    Some(read_session(&file).unwrap())
}
