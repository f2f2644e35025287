//! What takes a recording row by row, and what it is made with.

use std::collections::BTreeMap;
use std::path::Path;

use crate::write::WriteError;

/// Takes a recording row by row. The file has its name once [`finish`](Self::finish) has been called; until then, and if that
/// never happens, nothing stands under it.
pub trait RowWriter {
    /// Takes one row: one cell for each column that the writer was made with. NaN is an empty cell.
    ///
    /// # Errors
    ///
    /// There are more or fewer cells than columns, one is infinite, the file's kind cannot hold the time, or the file cannot be
    /// written.
    fn write(&mut self, cells: &[f64]) -> Result<(), WriteError>;

    /// Writes what is left and gives the file its name.
    ///
    /// # Errors
    ///
    /// The file cannot be written, or one has appeared that is not to be overwritten.
    fn finish(self: Box<Self>) -> Result<(), WriteError>;
}

/// What a new recording is made with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heading {
    /// Names of its columns. `time_s` is the time in seconds, `<joint>.position`, `<joint>.velocity` and `<joint>.effort` are those
    /// of a joint, with `<topic>:` before them where there are several topics. Files of messages hold no others.
    pub columns: Vec<String>,
    /// What is said of the whole recording, such as `load = plate-a`; [`Rows::metadata`](crate::Rows::metadata) gives it back.
    pub metadata: BTreeMap<String, String>,
}

/// Whether a row fits: one cell a column, none infinite. `row` is counted from 1.
pub(super) fn check_cells(path: &Path, columns: &[String], row: usize, cells: &[f64]) -> Result<(), WriteError> {
    let (expected, found) = (columns.len(), cells.len());
    if found != expected {
        return Err(WriteError::Ragged { path: path.to_owned(), row, expected, found });
    }
    match cells.iter().zip(columns).find(|(cell, _)| cell.is_infinite()) {
        None => Ok(()),
        Some((found, column)) => {
            Err(WriteError::NotFinite { path: path.to_owned(), row, column: column.clone(), found: *found })
        }
    }
}
