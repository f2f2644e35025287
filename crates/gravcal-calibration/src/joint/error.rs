//! Why there is no joint estimate.

use gravcal_estimation::statistics::{StatisticsError, TooFewBlocks};
use gravcal_estimation::{EvaluateError, NoiseError, ProblemError, SolveError};
use thiserror::Error;

/// The joint problem cannot be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BuildError {
    /// See [`ProblemError`].
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// See [`NoiseError`].
    #[error(transparent)]
    Noise(#[from] NoiseError),
}

/// The joint problem could not be solved.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EstimateError {
    /// It could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// It could not be solved.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// It could not be judged.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// As many numbers as readings: nothing is left that tells their noise.
    #[error(
        "{readings} readings, and as many numbers that they could tell: nothing is left that tells their noise; state it (std beside the unit in [readings]), or add poses"
    )]
    NoiseUntold {
        /// How many readings there are.
        readings: usize,
    },
    /// How uncertain it is could not be told.
    #[error("no standard deviations: {0}")]
    Statistics(#[from] StatisticsError),
}

impl From<TooFewBlocks> for EstimateError {
    fn from(error: TooFewBlocks) -> Self {
        EstimateError::Statistics(error.into())
    }
}
