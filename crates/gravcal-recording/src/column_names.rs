//! Names of the columns of a file, checked.

use std::collections::HashSet;
use std::path::Path;

use csv::StringRecord;

use crate::csv_lines::{CsvFormat, CsvWriting};
use crate::error::ReadError;
use crate::rows::MOST_COLUMNS;

/// Names of columns without a header: those that are said, else those in a comment `before` the first row, which has so many cells, else
/// their numbers. Who says that there is no header means comments, too.
pub(crate) fn columns_without_header(
    path: &Path,
    (format, before): (CsvFormat, &[Vec<u8>]),
    count: usize,
    said: &CsvWriting,
) -> Result<Vec<String>, ReadError> {
    check_count(path, count)?;
    match &said.columns {
        None => {
            let commented = format.commented_header(before, count).filter(|_| said.header.is_none());
            let numbered = || (1..=count).map(|column| format!("column{column}")).collect();
            Ok(commented.map_or_else(numbered, |names| names.iter().map(str::to_owned).collect()))
        }
        Some(names) if names.len() == count => Ok(names.clone()),
        Some(names) => Err(ReadError::OtherColumns { path: path.to_owned(), names: names.clone(), found: count }),
    }
}

/// Refuses more columns than any recording has.
pub(crate) fn check_count(path: &Path, found: usize) -> Result<(), ReadError> {
    match found <= MOST_COLUMNS {
        true => Ok(()),
        false => Err(ReadError::TooManyColumns { path: path.to_owned(), found, most: MOST_COLUMNS }),
    }
}

/// Name of a first column without one, as where there is no header.
pub(crate) const FIRST_COLUMN: &str = "column1";

/// The names in a header.
pub(crate) fn column_names(path: &Path, line: u64, header: &StringRecord) -> Result<Vec<String>, ReadError> {
    check_count(path, header.len())?;
    let mut names: Vec<String> = Vec::with_capacity(header.len());
    let mut seen = HashSet::with_capacity(header.len());
    for cell in header {
        // Tables that were saved with numbers or times of their rows have no name for these.
        let name = if names.is_empty() && cell.trim().is_empty() { FIRST_COLUMN } else { cell.trim() };
        if name.is_empty() {
            let position = names.len() + 1;
            return Err(ReadError::NoColumnName { path: path.to_owned(), line, position });
        }
        if !seen.insert(name) {
            let column = name.to_owned();
            return Err(ReadError::DuplicateColumn { path: path.to_owned(), line, column });
        }
        names.push(name.to_owned());
    }
    Ok(names)
}
