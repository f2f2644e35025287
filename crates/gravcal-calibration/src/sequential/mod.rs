//! The sequential estimator: the paper's steps 1, 2 and 3, from the base outward, each step's result frozen for the
//! next.
//!
//! **Where standing joints are.** Step 2 uses each pose's own reading of the joint before the swept one (paper, eq. (16)), so
//! that a deflection which its sensor sees is no error. Step 3 fits a sinusoid to a whole sweep, and takes the mean of the
//! readings of the joints that stand. What sensors do not see the steps cannot know: see [`gravcal_robot_model::session::Deflection`] for
//! the joint estimator.
//!
//! **When a step tells nothing.** Where its readings leave a number open, and where they rule out its model: its own χ², with
//! what the errors of earlier steps may do to it, has a probability below 0.001.

mod bias;
mod carried;
mod contradiction;
mod differences;
mod fitting;
mod found;
mod gain;
mod gravity;
mod report;
mod steps;
mod values;

pub use crate::plan::{LoadPair, Plan};
pub use found::{Found, Frozen, Missing};
pub use report::{report_steps, report_steps_briefly};
pub use steps::{Handed, run_steps, run_steps_handed};
pub use values::{Gravity, SensorValues, SequentialValues};

#[cfg(test)]
mod tests;
