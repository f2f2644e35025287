//! Batches of simulated calibrations: how accurate each estimator is, against the Cramér-Rao bound; how often it finds the
//! global optimum; how often its interval of the last joint's gain holds the truth.
//!
//! A trial depends on the simulation's seed and the trial's number only; trials run in parallel, and their errors are
//! summed in the order of their numbers, so that a table has the same bits on any number of threads.

mod accuracy;
pub mod batch;
mod bounds;
mod deflection;
mod drawn;
pub mod last_joint;
pub mod measures;
pub mod plan;
mod quantities;
pub mod random_arms;

pub use accuracy::{Accuracy, Column, ColumnAccuracy, StudyError, accuracy};
pub use deflection::{DeflectionColumn, DeflectionStudy, Treatment, deflection_study};
pub use quantities::{Measured, measured_quantities};
