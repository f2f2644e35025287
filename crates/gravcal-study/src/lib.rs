//! Batches of simulated calibrations.
//!
//! - **Studies.** [`plan`] is what `study.toml` says: what is simulated, what is varied, which estimators are compared. [`batch`] runs
//!   it, and [`measures`] is what the table of trials comes to, beside the Cramér-Rao bound.
//! - Studies that no such file can say: how often the global optimum is found on arms of every shape ([`random_arms`]), how often
//!   the interval of the last joint's gain holds the truth ([`last_joint`]), what deflection does ([`deflection_study`]).
//!
//! A trial depends on the seed and its number only; trials run in parallel, and are taken together in the order of their
//! numbers, so that a table has the same bits on any number of threads.

pub mod batch;
mod bounds;
mod deflection;
mod drawn;
pub mod last_joint;
pub mod measures;
pub mod plan;
mod quantities;
pub mod random_arms;

pub use deflection::{DeflectionColumn, DeflectionStudy, Treatment, deflection_study};
pub use quantities::{Measured, measured_quantities};
