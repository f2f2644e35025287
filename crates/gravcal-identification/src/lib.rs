//! From a least-squares problem to a judged answer.
//!
//! [`gravcal_estimation`] holds a problem, a [`Solver`](gravcal_estimation::Solver) minimises it, and what the minimum is worth is another
//! matter: whether it is the right one, what of it the readings determine, how well, and how well they are explained at all. This crate
//! has one device for each of these questions. It knows no robot: what reads a temperature is calibrated as an arm is.
//!
//! ```text
//! let fit = fit(&problem, &start, readings, &environment)?;                        // least squares about a reference that follows
//! let known = Known::at(&fit.problem, &fit.estimate)?;                           // analysis, covariance, active constraints
//! let noise = noise_by_squares(&residuals, &groups);                             // by channel, by leverage; the problem is built again
//! likeliest.or_from(starts, follow, is_another, &environment);                     // other starts, compared by their likelihood
//! let settled = settle(fit, &[&mirrored, &reversed], &environment)?;               // discrete symmetries: images of the solution
//! let profiles = Profiled { .. }.wider(&reported, &environment)?;                      // where the linear model is too sure
//! let judgement = judge(&fit.problem, &known.analysis, covariance, &parameters); // rank and limits of use, in combinations
//! ```
//!
//! | file | device |
//! |---|---|
//! | [`fit`](fn@fit) | a reference prior that follows the estimate, in rounds |
//! | [`solve_in_stages`] | robust losses, each from where a rounder one ended |
//! | [`noise_by_squares`], [`noise_by_median`] | noise that no reading states, by channel |
//! | [`variance_beyond_noise`] | errors that the noise does not explain, by restricted likelihood |
//! | [`Likeliest`] | ends of several starts, compared by their likelihood |
//! | [`settle`], [`Symmetry`] | images of a solution, one list and one loop: the better one is taken, what is as good is reported |
//! | [`Known`] | rank analysis and uncertainty at an estimate, along its active constraints |
//! | [`least_informed_nearby`] | plausible values near the estimate at which the readings say less |
//! | [`Profiled`] | what is told of a parameter where the problem is not linear over its error |
//! | [`judge`] | what is determined: rank, limits of use, and combinations that are not |
//! | [`Explained`] | how well the readings are explained as a whole |
//! | [`SolveEnvironment`] | what all of them are handed: a method, who is told of its way, who may stop it |
//!
//! `examples/thermistor.rs` calibrates a thermometer from a few baths, and says what these leave open.

mod determined;
mod environment;
mod fit;
mod known;
mod likeliest;
mod median;
mod misfit;
mod nearby;
mod noise;
mod profile;
mod residuals;
mod robust;
mod symmetries;
#[cfg(test)]
mod testing;
mod unexplained;

pub use determined::{Combination, Judgement, Parameter, judge, limits_of_use};
pub use environment::SolveEnvironment;
pub use fit::{FIRST_ITERATIONS, Fit, ROUNDS, fit};
pub use known::Known;
pub use likeliest::{DECISIVE, End, Likeliest, Place, UNSETTLED};
pub use median::{NORMAL_MEDIAN, median};
pub use misfit::Explained;
pub use nearby::{
    AT_LEAST, BASELESS, IMPLAUSIBLE, MOST_COLUMNS, as_of_one_direction, least_informed_nearby, share_that_matters,
};
pub use noise::{ChannelNoise, ReadingResidual, noise_by_median, noise_by_squares};
pub use profile::Profiled;
pub use residuals::{RowResidual, row_residuals};
pub use robust::solve_in_stages;
pub use symmetries::{Settled, Symmetry, settle};
pub use unexplained::{ErrorRow, variance_beyond_noise, variance_beyond_noise_by_median};
