//! A recording row by row, whatever kind of file it stands in.
//!
//! A recording of a robot in motion may be longer than memory. So it is read as a stream of [`Row`]s with named columns of numbers,
//! and what a column means is said by the same [`PoseMapping`](crate::PoseMapping) as for tables of static poses:
//!
//! ```text
//! CSV, MCAP, SQLite, Parquet ── Rows ──(PoseMapping, standstill)──► Vec<StaticPose>
//! ```

mod ahead;
mod csv;
mod folder;
mod inspect;
mod joint_state;
mod mcap;
mod messages;
pub(crate) mod missing;
mod open;
mod parquet;
mod rewrite;
mod row;
mod shield;
mod sqlite;
pub(crate) mod stamp;
mod watched;
mod write;

#[cfg(test)]
mod tests;

pub use inspect::{
    Clipped, ColumnFound, Gap, Guess, Inspection, JointFound, Meaning, Stuck, TimeFound, are_same_numbers,
    column_numbers, inspect, inspect_as, named_joint,
};
pub(crate) use open::{Kind, kind};
pub use open::{open, open_as};
pub use parquet::{CheckedFile, open_parquet, shielded_parquet};
pub use rewrite::{Change, RewriteError, Rewriting, Watch, rewrite};
pub(crate) use row::MOST_COLUMNS;
pub use row::{Row, Rows, Source, Topic};
pub use watched::Watched;
pub use write::{Heading, RowWriter, create};
