//! Why an uncertainty cannot be told.

use thiserror::Error;

use crate::{EvaluateError, NoiseError, ProblemError};

/// An uncertainty that the data do not give.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum StatisticsError {
    /// A residual, or the function of interest, has no value.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// See [`ProblemError`].
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// See [`NoiseError`].
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// Too few blocks for their scatter to tell anything.
    #[error(transparent)]
    TooFewBlocks(#[from] TooFewBlocks),
    /// Blocks of samples that the problem does not have.
    #[error("the blocks of samples end with factor {last}, but the problem has only {factors}")]
    NoSuchSamples {
        /// One past the last factor of the blocks.
        last: usize,
        /// How many factors there are.
        factors: usize,
    },
    /// As many parameters as residuals: nothing is left from which noise could be estimated.
    #[error("{rows} residuals and {rank} parameters that they determine: nothing is left to estimate the noise from")]
    NoFreedom {
        /// Rows of the problem.
        rows: usize,
        /// Rank of its Jacobian.
        rank: usize,
    },
    /// A problem with unknowns of single samples.
    #[error(
        "the problem has blocks that belong to single samples (such as `{0}`): their uncertainty can be told from stated \
         noise or by the jackknife, without losses, only"
    )]
    Eliminated(String),
    /// With a loss that forgives outliers, a point that looks stationary and is no minimum.
    #[error("the cost is not convex at the solution: so many readings count as outliers that no covariance exists")]
    NotConvex,
    /// What a single block determines has no scatter over blocks.
    #[error(
        "samples {first} to {last} alone determine {combination}: smaller blocks, or more samples like these, would tell \
         how well"
    )]
    SingleBlock {
        /// First factor of the block, counted from 1.
        first: usize,
        /// Last factor of the block.
        last: usize,
        /// What they determine.
        combination: String,
    },
    /// Most replicates of a bootstrap gave no solution.
    #[error(
        "of {replicates} replicates of the bootstrap {not_converged} did not converge and {undetermined} lacked samples \
         that determine everything"
    )]
    Replicates {
        /// How many there were.
        replicates: usize,
        /// How many did not converge.
        not_converged: usize,
        /// How many determined less than the samples themselves.
        undetermined: usize,
    },
}

/// Blocks of which there are not enough.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error(
    "{samples} samples in blocks of {length} are {} blocks, and {needed} are needed for their scatter to tell \
     anything: {}", samples.checked_div(*length).unwrap_or(0), cure(*samples, *needed)
)]
pub struct TooFewBlocks {
    /// How many samples there are.
    pub samples: usize,
    /// How many of them were to make a block.
    pub length: usize,
    /// How many blocks there must be at least.
    pub needed: usize,
}

fn cure(samples: usize, needed: usize) -> String {
    match samples / needed {
        0 => format!("{needed} samples at least"),
        longest => format!("blocks of 1 to {longest} samples"),
    }
}
