#![doc = include_str!("../../STATISTICS.md")]

mod along_constraints;
mod blocks;
mod bootstrap;
mod covariance;
mod error;
mod from_noise;
mod projected;
mod quantile;
mod redrawn;
mod sandwich;
mod uncertainty;

pub use along_constraints::{DECIDED, along_constraints, leans};
pub use blocks::{MIN_BLOCKS, SampleBlocks};
pub use bootstrap::{Bootstrap, Resampling};
pub use covariance::{Covariance, LinearFunction, stored_coordinates};
pub use error::{StatisticsError, TooFewBlocks};
pub use from_noise::NoiseKnowledge;
pub use quantile::Quantile;
pub use uncertainty::{Solution, Uncertainty};
