//! What kind of recording a file is, and its reader.

use std::io::Read;
use std::path::Path;

use super::ahead::Ahead;
use super::csv::CsvRows;
use super::folder;
use super::mcap::McapRows;
use super::parquet::ParquetRows;
use super::row::Rows;
use super::sqlite::SqliteRows;
use crate::csv_lines::CsvWriting;
use crate::error::ReadError;
use crate::file::opened;

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
    let rows: Box<dyn Rows + Send> = match kind(path)? {
        Kind::Mcap => Box::new(McapRows::open(path)?),
        Kind::Sqlite => Box::new(SqliteRows::open(path, vec![path.to_owned()], Vec::new())?),
        Kind::Folder => folder::open(path)?,
        Kind::Parquet => Box::new(ParquetRows::open(path)?),
        Kind::Csv => Box::new(CsvRows::open(path, csv)?),
    };
    Ok(Box::new(Ahead::new(rows)))
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
