//! The names of the estimators.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// The estimators that a user can choose by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorName {
    /// The paper's steps.
    Sequential,
    /// All unknowns together, all torque readings.
    Joint,
    /// All unknowns together, only the torque readings that the paper's steps read.
    JointPaperSignals,
    /// The readings of the paper's steps, step by step, each step's result passed on with its covariance.
    SequentialWithCovariance,
    /// All torque readings, the first poses together and then pose by pose.
    Recursive,
}

impl EstimatorName {
    /// Every estimator.
    pub const ALL: [EstimatorName; 5] = [
        EstimatorName::Sequential,
        EstimatorName::Joint,
        EstimatorName::JointPaperSignals,
        EstimatorName::SequentialWithCovariance,
        EstimatorName::Recursive,
    ];

    /// Those that run where nothing is chosen.
    pub const DEFAULT: [EstimatorName; 2] = [EstimatorName::Sequential, EstimatorName::Joint];

    /// Whether it reads what the paper's steps read, sweep by sweep.
    pub fn follows_steps(self) -> bool {
        match self {
            EstimatorName::Sequential | EstimatorName::JointPaperSignals | EstimatorName::SequentialWithCovariance => {
                true
            }
            EstimatorName::Joint | EstimatorName::Recursive => false,
        }
    }

    /// The name in files and on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            EstimatorName::Sequential => "sequential",
            EstimatorName::Joint => "joint",
            EstimatorName::JointPaperSignals => "joint-paper-signals",
            EstimatorName::SequentialWithCovariance => "sequential-with-covariance",
            EstimatorName::Recursive => "recursive",
        }
    }
}

impl fmt::Display for EstimatorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No estimator has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown estimator `{name}`; there is: {known}")]
pub struct UnknownEstimator {
    name: String,
    known: String,
}

impl FromStr for EstimatorName {
    type Err = UnknownEstimator;

    fn from_str(name: &str) -> Result<Self, UnknownEstimator> {
        EstimatorName::ALL.into_iter().find(|e| e.as_str() == name).ok_or_else(|| UnknownEstimator {
            name: name.to_owned(),
            known: EstimatorName::ALL.map(EstimatorName::as_str).join(", "),
        })
    }
}
