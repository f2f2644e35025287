//! Running a study: trials in parallel, in parts that are complete or not there.
//!
//! The trials of all points are cut into parts, of a size that the study alone decides. A part is computed by one thread and
//! written when it is done, so that memory does not grow with the number of trials, a run that was killed goes on where it was,
//! and several machines may share the parts. At the end the parts are put together in their order: one table, the same to the
//! byte however it came about.

mod error;
mod folder;
mod manifest;
mod merge;
mod order;
mod part;
mod row;
mod run;
mod table;
mod trial;

pub use error::BatchError;
pub use folder::StudyFolder;
pub use manifest::Manifest;
pub use merge::merge;
pub use row::{Cell, Outcome, Row};
pub use run::{Ended, Helpers, NamedSolver, Shard, check, run};
pub use table::{Columns, TableReader};

pub(crate) use order::Expected;
