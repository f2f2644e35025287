//! A recording as a CSV file: what is said of it as comments `# load = plate-a`, names of columns, rows.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::{Heading, RowWriter, check_cells};
use crate::write::{NewFile, WriteError};

/// Writes CSV.
pub(super) struct CsvWriter {
    path: PathBuf,
    columns: Vec<String>,
    file: csv::Writer<NewFile>,
    rows: usize,
}

impl CsvWriter {
    pub(super) fn create(path: &Path, heading: &Heading, overwrite: bool) -> Result<CsvWriter, WriteError> {
        let io = |cause| WriteError::Io { path: path.to_owned(), cause };
        let mut file = NewFile::create(path, overwrite)?;
        for (key, value) in &heading.metadata {
            crate::write_table::check_text(path, key)?;
            crate::write_table::check_text(path, value)?;
            writeln!(file, "# {key} = {value}").map_err(io)?;
        }
        // With the comment sign made known, a name that begins with it is put in quotes.
        let mut file = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(file);
        file.write_record(&heading.columns).map_err(|error| io(error.into()))?;
        Ok(CsvWriter { path: path.to_owned(), columns: heading.columns.clone(), file, rows: 0 })
    }
}

impl RowWriter for CsvWriter {
    fn write(&mut self, cells: &[f64]) -> Result<(), WriteError> {
        self.rows += 1;
        check_cells(&self.path, &self.columns, self.rows, cells)?;
        // `{}` of an f64 is the shortest decimal number that is read back as the same f64.
        let texts = cells.iter().map(|cell| if cell.is_nan() { String::new() } else { format!("{cell}") });
        self.file.write_record(texts).map_err(|error| WriteError::Io { path: self.path.clone(), cause: error.into() })
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        let CsvWriter { path, file, .. } = *self;
        let file = file.into_inner().map_err(|error| WriteError::Io { path, cause: error.into_error() })?;
        file.finish()
    }
}
