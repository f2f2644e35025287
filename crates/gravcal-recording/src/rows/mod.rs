//! A recording row by row, whatever kind of file it stands in.
//!
//! A recording of a robot in motion may be longer than memory. So it is read as a stream of [`Row`]s with named columns of numbers,
//! and what a column means is said by the same [`PoseMapping`](crate::PoseMapping) as for tables of static poses:
//!
//! ```text
//! CSV, MCAP, SQLite, Parquet ── Rows ──(PoseMapping, standstill)──► Vec<StaticPose>
//! ```

mod csv;
mod folder;
mod inspect;
mod joint_state;
mod mcap;
mod messages;
mod missing;
mod parquet;
mod rewrite;
mod shield;
mod sqlite;
mod watched;
mod write;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use serde::Serialize;

use crate::csv_lines::CsvWriting;
use crate::error::ReadError;
use crate::file::opened;

pub use inspect::{
    Clipped, ColumnFound, Gap, Guess, Inspection, JointFound, Meaning, Stuck, TimeFound, are_same_numbers,
    column_numbers, inspect, inspect_as,
};
pub use parquet::{CheckedFile, open_parquet, shielded_parquet};
pub use rewrite::{Change, RewriteError, Rewriting, Watch, rewrite};
pub use watched::Watched;
pub use write::{Heading, RowWriter, create};

/// No recording has more columns: what is kept for each must not fill the memory.
pub(crate) const MOST_COLUMNS: usize = 4096;

/// What a recording says at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Where it stands in its file, counted from 1: the line of a CSV file, the message of a bag (MCAP, SQLite), the row of a Parquet
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

    /// Whether a column holds dates with times, as far as it is read: its numbers are seconds since 1970-01-01 in UTC.
    fn holds_dates(&self, column: usize) -> bool {
        let _ = column;
        false
    }

    /// Kind of file, and what it holds as far as it is read.
    fn source(&self) -> Source;

    /// What was lost or looks wrong so far, in words: cut files, damaged chunks, cells that are no finite numbers.
    fn remarks(&self) -> Vec<String>;

    /// What is said of the whole recording, such as `load = plate-a`, as far as it is read: the metadata record `gravcal` of an
    /// MCAP file, comments `# load = plate-a` before the header of a CSV file, the key-value metadata of a Parquet file.
    fn metadata(&self) -> BTreeMap<String, String>;

    /// Which share of the file is read, from 0 to 1.
    fn progress(&self) -> f64;
}

/// Kind of file, and what it holds.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Source {
    /// In words.
    pub kind: String,
    /// Topics of a bag (MCAP, SQLite); none of others.
    pub topics: Vec<Topic>,
}

/// A topic of a bag.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// Type of its messages.
    pub kind: String,
    /// How they are written.
    pub encoding: String,
    /// How many there are.
    pub messages: u64,
}

/// Opens a recording: a CSV file, an MCAP file, a bag of ROS 2 in SQLite, a folder of these as rosbag2 writes it, or a Parquet file. What it
/// is, is told by its first bytes; how a CSV file is written, by its first lines.
///
/// # Errors
///
/// It cannot be opened, is none of these, has no readings, or names its columns badly.
pub fn open(path: &Path) -> Result<Box<dyn Rows>, ReadError> {
    open_as(path, &CsvWriting::default())
}

/// The same of a file that, if it is CSV, is said to be written so.
///
/// # Errors
///
/// As [`open`].
pub fn open_as(path: &Path, csv: &CsvWriting) -> Result<Box<dyn Rows>, ReadError> {
    Ok(match kind(path)? {
        Kind::Mcap => Box::new(mcap::McapRows::open(path)?),
        Kind::Sqlite => Box::new(sqlite::SqliteRows::open(path, vec![path.to_owned()], Vec::new())?),
        Kind::Folder => folder::open(path)?,
        Kind::Parquet => Box::new(parquet::ParquetRows::open(path)?),
        Kind::Csv => Box::new(csv::CsvRows::open(path, csv)?),
    })
}

/// Kinds of recordings.
pub(crate) enum Kind {
    Csv,
    Mcap,
    Sqlite,
    Folder,
    Parquet,
}

/// What stands at the beginning of other files that hold recordings, and what to do with them.
const OTHERS: [(&[u8], &str); 3] = [
    (b"#ROSBAG V2.0", "it is a bag of ROS 1: `rosbags-convert` makes MCAP of it"),
    (&[0x1F, 0x8B], "it is compressed: unpack it (gunzip) first"),
    (&[0x28, 0xB5, 0x2F, 0xFD], "it is compressed: unpack it (unzstd) first"),
];

/// What a file is, by its first bytes.
pub(crate) fn kind(path: &Path) -> Result<Kind, ReadError> {
    if path.is_dir() {
        return Ok(Kind::Folder);
    }
    let mut first = Vec::new();
    let read = opened(path).and_then(|file| file.take(16).read_to_end(&mut first));
    read.map_err(|cause| ReadError::opening(path, cause))?;
    if let Some((_, what)) = OTHERS.iter().find(|(magic, _)| first.starts_with(magic)) {
        return Err(ReadError::NotRecording { path: path.to_owned(), what: (*what).to_owned() });
    }
    // Of the magic bytes, only the first that no text begins with: so a damaged file is told to be one.
    Ok(match first.as_slice() {
        [0x89, b'M', b'C', b'A', b'P', ..] => Kind::Mcap,
        [b'P', b'A', b'R', b'1', ..] => Kind::Parquet,
        first if first.starts_with(b"SQLite format 3") => Kind::Sqlite,
        _ => Kind::Csv,
    })
}
