//! Methods that minimise a [`gravcal_estimation::Problem`], one file each.
//!
//! To add a method: one file here with a type that implements [`Solver`], and its name in [`SolverName`].
//! The shared suites of published problems (`tests/`) then run it by themselves.

mod levenberg_marquardt;

use std::fmt;
use std::str::FromStr;

use gravcal_estimation::Solver;
use thiserror::Error;

pub use levenberg_marquardt::LevenbergMarquardt;

/// The methods that a user can choose by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverName {
    /// [`LevenbergMarquardt`].
    LevenbergMarquardt,
}

impl SolverName {
    /// Every method.
    pub const ALL: [SolverName; 1] = [SolverName::LevenbergMarquardt];

    /// The name in files and on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            SolverName::LevenbergMarquardt => levenberg_marquardt::NAME,
        }
    }

    /// The method with its default options.
    pub fn build(self) -> Box<dyn Solver> {
        match self {
            SolverName::LevenbergMarquardt => Box::new(LevenbergMarquardt::default()),
        }
    }
}

impl fmt::Display for SolverName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No method has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown solver `{name}`; there is: {known}")]
pub struct UnknownSolver {
    name: String,
    known: String,
}

impl FromStr for SolverName {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, UnknownSolver> {
        SolverName::ALL.into_iter().find(|s| s.as_str() == name).ok_or_else(|| UnknownSolver {
            name: name.to_owned(),
            known: SolverName::ALL.map(SolverName::as_str).join(", "),
        })
    }
}
