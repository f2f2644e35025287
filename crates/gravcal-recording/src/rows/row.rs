//! What a recording of any kind is: rows of numbers under named columns.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::error::ReadError;

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

    /// Those of the remarks that tell of a part of a recording that is lost: a file that is cut or missing, damaged messages that are more than a
    /// hundredth of all.
    fn lost(&self) -> Vec<String> {
        Vec::new()
    }

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
