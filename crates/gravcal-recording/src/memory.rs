//! Recordings that stand in memory, and not in files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::csv_lines::CsvWriting;
use crate::error::ReadError;
use crate::mapping::PoseMapping;
use crate::motion::reader::Part;
use crate::pose::{Recording, part_of_rows, read_part};
use crate::rows::{MOST_COLUMNS, Row, Rows, Source, open_as};

/// Named columns of numbers, row by row; NaN where a row says nothing, as an empty cell of a file.
#[derive(Clone, Debug)]
pub struct Numbers {
    columns: Vec<String>,
    cells: Arc<[f64]>,
}

/// Why numbers are no recording.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NumbersError {
    /// Nothing, or too much.
    #[error("a recording has 1 to {MOST_COLUMNS} columns, found {0}")]
    Columns(usize),
    /// Two columns cannot be told apart.
    #[error("two columns are named `{0}`; rename one")]
    Twice(String),
    /// A row is cut.
    #[error("{cells} numbers are no rows of {columns} columns")]
    Ragged {
        /// How many columns there are.
        columns: usize,
        /// How many numbers.
        cells: usize,
    },
}

impl Numbers {
    /// `cells` row by row, in the units that a mapping will say.
    ///
    /// # Errors
    /// No columns, two of one name, or a row that is not whole.
    pub fn new(columns: Vec<String>, cells: Vec<f64>) -> Result<Numbers, NumbersError> {
        if columns.is_empty() || columns.len() > MOST_COLUMNS {
            return Err(NumbersError::Columns(columns.len()));
        }
        if let Some(place) = (1..columns.len()).find(|place| columns[..*place].contains(&columns[*place])) {
            return Err(NumbersError::Twice(columns[place].clone()));
        }
        if !cells.len().is_multiple_of(columns.len()) {
            return Err(NumbersError::Ragged { columns: columns.len(), cells: cells.len() });
        }
        Ok(Numbers { columns, cells: cells.into() })
    }
}

/// Recordings in memory, by the paths under which a session names them; whatever else it names is a file.
#[derive(Clone, Debug, Default)]
pub struct Memory(BTreeMap<PathBuf, Numbers>);

impl Memory {
    /// With one more, or another one of that name.
    #[must_use]
    pub fn with(mut self, path: impl Into<PathBuf>, numbers: Numbers) -> Memory {
        self.0.insert(path.into(), numbers);
        self
    }

    /// Whether a path is that of a recording in memory.
    pub fn holds(&self, path: &Path) -> bool {
        self.0.contains_key(path)
    }

    /// Reads static poses of what is in memory under this path, else of the file.
    ///
    /// # Errors
    /// As [`read_part`].
    pub fn read_part(&self, path: &Path, mapping: &PoseMapping, part: Part) -> Result<Recording, ReadError> {
        match self.holds(path) {
            true => part_of_rows(path, self.open_as(path, &mapping.csv)?.as_mut(), mapping, part),
            false => read_part(path, mapping, part),
        }
    }

    /// Opens what is in memory under this path, else the file.
    ///
    /// # Errors
    /// As [`open_as`].
    pub fn open_as(&self, path: &Path, csv: &CsvWriting) -> Result<Box<dyn Rows>, ReadError> {
        match self.0.get(path) {
            Some(numbers) => Ok(Box::new(MemoryRows { numbers: numbers.clone(), read: 0 })),
            None => open_as(path, csv),
        }
    }
}

/// Reads them from the first row to the last.
struct MemoryRows {
    numbers: Numbers,
    read: usize,
}

impl MemoryRows {
    fn rows(&self) -> usize {
        self.numbers.cells.len() / self.numbers.columns.len()
    }
}

impl Rows for MemoryRows {
    fn columns(&self) -> &[String] {
        &self.numbers.columns
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        let width = self.numbers.columns.len();
        let Some(cells) = self.numbers.cells.get(self.read * width..(self.read + 1) * width) else { return Ok(false) };
        self.read += 1;
        row.number = self.read as u64;
        row.cells.clear();
        row.cells.extend_from_slice(cells);
        Ok(true)
    }

    fn source(&self) -> Source {
        Source { kind: "numbers in memory".to_owned(), topics: Vec::new() }
    }

    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    fn progress(&self) -> f64 {
        self.read as f64 / self.rows().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(columns: &[&str], cells: &[f64]) -> Result<Numbers, NumbersError> {
        Numbers::new(columns.iter().map(|column| (*column).to_owned()).collect(), cells.to_vec())
    }

    #[test]
    fn rows_are_read_in_order_and_as_they_are() {
        let memory = Memory::default().with("arm", numbers(&["q", "y"], &[0.1, f64::NAN, -0.0, 1e-300]).unwrap());
        assert!(memory.holds(Path::new("arm")) && !memory.holds(Path::new("leg")));
        let mut rows = memory.open_as(Path::new("arm"), &CsvWriting::default()).unwrap();
        let mut row = Row::default();
        assert!(rows.read(&mut row).unwrap());
        assert!(row.number == 1 && row.cells[0] == 0.1 && row.cells[1].is_nan());
        assert!(rows.read(&mut row).unwrap());
        assert_eq!((row.number, row.cells[0].to_bits(), row.cells[1]), (2, (-0.0f64).to_bits(), 1e-300));
        assert!(!rows.read(&mut row).unwrap());
        assert_eq!(rows.progress(), 1.0);
        assert!(matches!(memory.open_as(Path::new("leg"), &CsvWriting::default()), Err(ReadError::NoFile { .. })));
    }

    #[test]
    fn numbers_that_are_no_recording_are_refused() {
        assert_eq!(numbers(&[], &[]).unwrap_err(), NumbersError::Columns(0));
        assert_eq!(numbers(&["q", "q"], &[0.0; 2]).unwrap_err(), NumbersError::Twice("q".to_owned()));
        assert_eq!(numbers(&["q", "y"], &[0.0; 3]).unwrap_err(), NumbersError::Ragged { columns: 2, cells: 3 });
    }
}
