//! The module `gravcal._native`: what the Python package `gravcal` is made of. Its classes are wrapped in Python, where their documentation
//! stands.
//!
//! Sessions, estimators and reports are those of the program; nothing is computed here.

mod applied;
mod calibration;
mod estimation;
mod failure;
mod models;
mod recordings;
mod session;
mod work;

use std::ffi::OsString;

use gravcal::calibration::Registry;
use pyo3::prelude::*;

/// As in the program: what one computes the other does, in the same time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Runs the program with these arguments, its own name first; gives its exit code.
#[pyfunction]
fn run_program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| gravcal_cli::main(arguments, &Registry::standard()))
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::calibration::Calibration;
    #[pymodule_export]
    use super::estimation::{Estimated, estimate};
    #[pymodule_export]
    use super::recordings::read_recording;
    #[pymodule_export]
    use super::run_program;
    #[pymodule_export]
    use super::session::{Robot, Session};
}
