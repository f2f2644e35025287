#![doc = include_str!("../../STATISTICS.md")]

mod along_constraints;
mod block_length;
mod blocks;
mod bootstrap;
mod covariance;
mod determined_by_blocks;
mod eigen;
mod error;
mod from_noise;
mod jackknife;
mod moved_by;
mod projected;
mod quantile;
mod redrawn;
mod residual_maker;
mod sandwich;
mod solution;
mod uncertainty;

pub use along_constraints::{DECIDED, along_constraints, leans};
pub use block_length::{block_length, neighbour_correlation};
pub use blocks::{MIN_BLOCKS, MIN_BLOCKS_LEFT_OUT, SampleBlocks};
pub use bootstrap::{Bootstrap, Resampling};
pub use covariance::{Covariance, LinearFunction, stored_coordinates};
pub use error::{StatisticsError, TooFewBlocks};
pub use from_noise::{NoiseScale, larger_for_fewer};
pub use jackknife::{DeterminedByOneBlock, Jackknife};
pub use moved_by::moved_by;
pub use quantile::Quantile;
pub use residual_maker::ResidualMaker;
pub use solution::Solution;
pub use uncertainty::Uncertainty;
