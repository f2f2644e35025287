//! A recording written again with other readings, row by row, and everything else in it kept.

mod csv;
mod mcap;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[cfg(test)]
mod tests;

use super::{Kind, kind};
use crate::csv_lines::CsvWriting;
use crate::error::ReadError;
use crate::write::{WriteError, check_target};

/// Changes the cells of a row, whose columns have these names. NaN is an empty cell.
pub type Change<'a> = dyn FnMut(&[String], &mut [f64]) + 'a;

/// Told which share of the recording is done, from 0 to 1; false ends it.
pub type Watch<'a> = dyn FnMut(f64) -> bool + 'a;

/// Rows between two calls of the watch.
const PACE: u64 = 1000;

/// Why a recording could not be written again. Then nothing has the new name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The new one cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// It is of a kind that is not written again.
    #[error("{}: {what}", path.display())]
    NotRewritten {
        /// The recording.
        path: PathBuf,
        /// Why, and what to do.
        what: &'static str,
    },
    /// The new name is that of the old file.
    #[error("{}: this is the recording itself, which stays as it is; give the new one another name", path.display())]
    Itself {
        /// The file.
        path: PathBuf,
    },
    /// The watch ended it.
    #[error("stopped; nothing is written")]
    Stopped,
}

/// A recording that is to be written again.
#[derive(Clone, Copy, Debug)]
pub struct Rewriting<'a> {
    /// The recording.
    pub input: &'a Path,
    /// The new one.
    pub output: &'a Path,
    /// Whether a file of that name is replaced.
    pub overwrite: bool,
    /// How the recording is written, if it is CSV.
    pub csv: &'a CsvWriting,
    /// What is put before it, as what is said of a recording is.
    pub notes: &'a BTreeMap<String, String>,
}

/// Writes a recording (CSV or MCAP) as one of the same kind, with each row as `change` leaves it and all else as it is:
/// other columns, topics, schemas, metadata, attachments. Gives what was lost or looks wrong. The chunks of an MCAP file become compressed by zstd.
///
/// # Errors
///
/// The recording cannot be read or is of another kind, `output` ends otherwise, there is such a file and not `overwrite`, it cannot
/// be written, or the watch ended it.
pub fn rewrite(
    what: &Rewriting<'_>,
    change: &mut Change<'_>,
    watch: &mut Watch<'_>,
) -> Result<Vec<String>, RewriteError> {
    let Rewriting { input, output, overwrite, .. } = *what;
    let refused = |what| Err(RewriteError::NotRewritten { path: input.to_owned(), what });
    let kind = kind(input)?;
    if let (Ok(old), Ok(new)) = (input.canonicalize(), output.canonicalize())
        && old == new
    {
        return Err(RewriteError::Itself { path: output.to_owned() });
    }
    check_target(output, overwrite)?;
    let ends = |ending: &str| output.extension().is_some_and(|found| found == ending);
    match kind {
        Kind::Folder => refused("this is a folder; write the files in it again one by one"),
        Kind::Sqlite => refused(
            "a bag in SQLite is not written again, only CSV and MCAP: make MCAP of it first, and take that. `mcap convert in.db3 out.mcap` \
             does it (a tool of mcap.dev), and so does `ros2 bag convert`",
        ),
        Kind::Parquet => refused("a Parquet file is not written again, only CSV and MCAP"),
        Kind::Mcap if !ends("mcap") => refused("this is an MCAP file, and becomes one: let the new name end in .mcap"),
        Kind::Csv if ends("mcap") || ends("parquet") => {
            refused("this is a CSV file, and becomes one: let the new name end in .csv")
        }
        Kind::Mcap => mcap::rewrite(what, change, watch),
        Kind::Csv => csv::rewrite(what, change, watch),
    }
}

/// Calls the watch from time to time.
struct Paced<'a, 'b> {
    watch: &'a mut Watch<'b>,
    rows: u64,
}

impl Paced<'_, '_> {
    fn row(&mut self, progress: impl FnOnce() -> f64) -> Result<(), RewriteError> {
        self.rows += 1;
        match !self.rows.is_multiple_of(PACE) || (self.watch)(progress()) {
            true => Ok(()),
            false => Err(RewriteError::Stopped),
        }
    }
}

/// Whether two cells say the same.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}
