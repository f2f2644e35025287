//! What the tests of this crate share.

pub mod sensor_models;
mod sessions;

use gravcal_solvers::LevenbergMarquardt;

use crate::workbench::Workbench;

pub use sessions::*;

/// Runs something with the default solver.
pub fn with_workbench<T>(run: impl FnOnce(&Workbench<'_>) -> T) -> T {
    let solver = LevenbergMarquardt::default();
    run(&Workbench::new(&solver, &|_: &str| {}))
}
