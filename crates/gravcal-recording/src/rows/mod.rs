//! A recording row by row, whatever kind of file it stands in.
//!
//! A recording of a robot in motion may be longer than memory. So it is read as a stream of [`Row`]s with named columns of numbers,
//! and what a column means is said by the same [`PoseMapping`](crate::PoseMapping) as for tables of static poses:
//!
//! ```text
//! CSV, MCAP, Parquet ── Rows ──(PoseMapping, standstill)──► Vec<StaticPose>
//! ```

mod joint_state;
mod write;

use std::collections::BTreeMap;

use crate::error::ReadError;

pub use write::{Heading, RowWriter, create};

/// What a recording says at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Where it stands in its file, counted from 1: the line of a CSV file, the message of an MCAP file, the row of a Parquet
    /// file.
    pub number: u64,
    /// One cell a column, in the unit of the file. NaN where the row says nothing of it: an empty cell, a joint of another
    /// topic, a reading that is no finite number (these are counted in the reader's remarks).
    pub cells: Vec<f64>,
}

/// A recording that is read from its beginning to its end, in memory that does not grow with its length.
pub trait Rows {
    /// Names of the columns so far. More may come while reading, where a joint appears midway; places never change.
    fn columns(&self) -> &[String];

    /// Reads the next row into `row`, with one cell for each of [`columns`](Self::columns); false at the end.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or what it holds is no such recording. Damage that leaves whole rows behind it is a remark, not an
    /// error.
    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError>;

    /// What was lost or looks wrong so far, in words: cut files, damaged chunks, cells that are no finite numbers.
    fn remarks(&self) -> Vec<String>;

    /// What is said of the whole recording, such as `load = plate-a`, as far as it is read: the metadata record `gravcal` of an
    /// MCAP file, comments `# load = plate-a` before the header of a CSV file, the key-value metadata of a Parquet file.
    fn metadata(&self) -> BTreeMap<String, String>;

    /// Which share of the file is read, from 0 to 1.
    fn progress(&self) -> f64;
}
