//! Tests on residuals: whether what a fit leaves has a shape that noise has not, which tells that its intervals cannot hold.
//!
//! For each channel, terms are looked for that the model lacks ([`terms`]), by score tests from the same fit ([`score`]), and whether
//! neighbouring poses are alike ([`neighbours`]). As there are many tests, p-values are corrected by Holm's method: where the model is
//! right, anything at all is named with probability [`candidate::SIGNIFICANCE`] at most. What is named is then taken into the model, and all the rest
//! is tested again, so that one error of the model is told once, by its likeliest name. An order of a harmonic, a file, a size: these are
//! of that fit.
//!
//! **An arm in motion.** That a torque is recorded late, or filtered, shows in the slope and the bend of the predicted readings over time
//! ([`delayed`]); that friction builds up after a joint turned round, in what windows say of it; that it is no line
//! over the speed, in their speeds ([`friction_curve`]).
//!
//! **What goes with the torque.** A gain that drifts, a reading that goes with the square or cube of its torque, or with the torques of other joints; of
//! an arm in motion, friction that grows with the torque ([`predicted_torques`]).
//!
//! **What a sensor keeps of the pose before.** Of an arm that stands, by whether what it senses rose or fell last (hysteresis), and in proportion to
//! what it changed by (creep): [`changes`]. In one channel these have a tenth of the weight of other tests ([`candidate`]).
//!
//! **What changes between tables.** A bias, a gain, the zero of a position sensor (an encoder that was homed anew), and gravity as the base sees it (a
//! base that was moved).
//!
//! **What is stated of loads** without a standard deviation: a mass, a place, a distance between two ([`loads`]).
//!
//! **Something that pulls** at the last link ([`pull`]).
//!
//! **What the robot's description says** of each joint: where it sits, as far as known masses beyond it show that, and how it is tilted
//! (`joint/model_error/displaced_joints.rs`). Where one of these, or a load's mass, is named, the like may be as wrong. What hangs on what is taken as exact, and need
//! not show, is told beside ([`taken_as_exact`]).
//!
//! **From which side joints came**, as the session says it, or, in tables, as the order of rows tells it
//! (`joint/model_error/sides_by_order.rs`).
//!
//! **What all joints do.** What bends most passes for a position gain, so that a joint's own test has little power, and needs it most. And a
//! recorder does the same to all torques, and warmth about the same to all gains. One compliance of all joints, one lag and one filter of all torques, and
//! one change of all gains, and one share by which all torque sensors creep, are therefore looked for, too, and whether the zeros of all joints drift, each by
//! itself, as an arm that warms up lets them; these have half of the probability of naming anything, as all other tests together have.
//!
//! **What it comes to.** A term that is there spoils intervals where what is seen of it is a quarter of one reading's noise, or where it moves a number by
//! half of its standard deviation and is surely there, or by three where blocks tell it: of a term that the fit takes up nearly whole little is seen, and it moves numbers most; neighbours
//! that are alike where their correlation is 0.2, unless standard deviations come from blocks. By as much as such a term would move a number
//! if the model had it, the number's standard deviation grows, `σ² + Δ²` for `σ²`: an effect that is known, and left uncorrected, is counted as
//! an uncertainty. A zero that drifts is seldom alone, nor is a gain or a zero that has changed: where one is named, others are taken to have, too ([`drift`]). The verdict stays *partly
//! determined*: the term belongs into the model. Less is told, and changes no verdict. The side from which joints came spoils nothing where errors beyond the noise of
//! a recording are estimated, or a table has shown it: what friction leaves at rest is then an unknown of the
//! fit (`joint/model_error/at_rest.rs`, `in_tables.rs`), told from position gains and biases or widening their intervals
//! (`cargo run --release -p gravcal-benches --bin real_arms -- --line still --line one-way` counts how often these hold the truth).
//!
//! **Before anything is named** it is held against other noise than that of independent readings of one scatter, where residuals show such: noise of first order from
//! pose to pose ([`first_order`]), and a scatter that grows with the term ([`uneven_scatter`]). The largest p-value counts.
//!
//! **Under a loss** each row counts by the root of its weight: the solution is that of such least squares.
//!
//! **Not tested**: what has not converged, readings that enter group by group, residuals that are but the
//! rounding of numbers, a term that the model has already, a channel with too few readings to tell its noise.

mod base;
mod bound;
mod candidate;
mod changes;
mod clock_rate;
mod columns;
mod delayed;
mod drift;
mod first_order;
mod friction_curve;
mod in_fit;
mod loads;
mod looked_for;
mod neighbours;
mod nothing_named;
mod of_solution;
mod predicted_axes;
mod predicted_torques;
mod pull;
mod rows;
mod score;
mod search;
mod taken_as_exact;
mod terms;
#[cfg(test)]
mod tests;
mod too_large;
mod uneven_friction;
mod uneven_scatter;
mod wording;
mod words;

pub(crate) use of_solution::{ResidualTests, TestsWanted, residual_tests, too_large};
pub(crate) use words::in_words;
