//! Starting values without guesses: each of the paper's steps solved in closed form.
//!
//! The estimators refine them by least squares on the same readings.

mod gravity;
mod load;
mod sinusoid;

pub(crate) use gravity::{GravityStart, SweepDirection, gravity_from_sweeps};
pub(crate) use load::{PositionDifference, gain_and_offset, gain_at_known_offset};
pub(crate) use sinusoid::{fit_sinusoid, search_position_gain};
