//! A recording as a Parquet file: one column of `f64` a column, an empty cell a null, and what is said of it as key-value metadata.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

use super::{Heading, RowWriter, check_cells};
use crate::write::{NewFile, WriteError};

/// Rows that are handed on together.
const BATCH: usize = 8192;
/// Rows of a group, which is what a reader needs memory for.
const ROW_GROUP: usize = 1 << 16;

/// Writes Parquet.
pub(super) struct ParquetWriter {
    path: PathBuf,
    columns: Vec<String>,
    schema: Arc<Schema>,
    file: ArrowWriter<NewFile>,
    /// Cells that wait, by column.
    waiting: Vec<Vec<f64>>,
    rows: usize,
}

impl ParquetWriter {
    pub(super) fn create(path: &Path, heading: &Heading, overwrite: bool) -> Result<ParquetWriter, WriteError> {
        let fields: Vec<Field> =
            heading.columns.iter().map(|column| Field::new(column, DataType::Float64, true)).collect();
        let metadata = heading.metadata.clone().into_iter().collect();
        let schema = Arc::new(Schema::new_with_metadata(fields, metadata));
        let said = heading.metadata.iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone())).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_max_row_group_row_count(Some(ROW_GROUP))
            .set_key_value_metadata(Some(said))
            .build();
        let file = NewFile::create(path, overwrite)?;
        let file = ArrowWriter::try_new(file, schema.clone(), Some(properties)).map_err(|error| failed(path, error))?;
        let waiting = vec![Vec::with_capacity(BATCH); heading.columns.len()];
        Ok(ParquetWriter { path: path.to_owned(), columns: heading.columns.clone(), schema, file, waiting, rows: 0 })
    }

    fn hand_on(&mut self) -> Result<(), WriteError> {
        let array = |cells: &mut Vec<f64>| -> ArrayRef {
            Arc::new(cells.drain(..).map(|cell| (!cell.is_nan()).then_some(cell)).collect::<Float64Array>())
        };
        let arrays = self.waiting.iter_mut().map(array).collect();
        let batch = RecordBatch::try_new(self.schema.clone(), arrays).map_err(ParquetError::from);
        batch.and_then(|batch| self.file.write(&batch)).map_err(|error| failed(&self.path, error))
    }
}

impl RowWriter for ParquetWriter {
    fn write(&mut self, cells: &[f64]) -> Result<(), WriteError> {
        self.rows += 1;
        check_cells(&self.path, &self.columns, self.rows, cells)?;
        self.waiting.iter_mut().zip(cells).for_each(|(waiting, cell)| waiting.push(*cell));
        if self.rows.is_multiple_of(BATCH) { self.hand_on() } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        self.hand_on()?;
        let ParquetWriter { path, file, .. } = *self;
        file.into_inner().map_err(|error| failed(&path, error))?.finish()
    }
}

/// Parquet's own words for what the operating system refuses.
fn failed(path: &Path, error: ParquetError) -> WriteError {
    WriteError::Io { path: path.to_owned(), cause: std::io::Error::other(error) }
}
