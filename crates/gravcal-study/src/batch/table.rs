//! Tables of trials as Parquet.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::builder::StringDictionaryBuilder;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, UInt32Type, UInt64Type};
use arrow_array::{Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, UInt32Array, UInt64Array};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use gravcal_recording::{open_parquet, shielded_parquet};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;

use super::BatchError;
use super::row::{Cell, Row};

/// Rows of a group, which is what a reader needs memory for.
const ROW_GROUP: usize = 1 << 15;
/// Columns before those of the quantities.
const LEADING: usize = 7;

/// The columns of a study's tables: `point`, `trial`, `estimator`, `solver`, `outcome`, `reason`, `iterations`, then of each
/// quantity `NAME.error`, `NAME.std`, `NAME.bound` in its unit and `NAME.inside`.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Names of the estimators.
    pub estimators: Vec<String>,
    /// Names of the solvers.
    pub solvers: Vec<String>,
    /// Names of the quantities.
    pub quantities: Vec<String>,
}

impl Columns {
    pub(super) fn schema(&self) -> Arc<Schema> {
        let text = || DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
        let mut fields = vec![
            Field::new("point", DataType::UInt32, false),
            Field::new("trial", DataType::UInt64, false),
            Field::new("estimator", text(), false),
            Field::new("solver", text(), false),
            Field::new("outcome", text(), false),
            Field::new("reason", text(), true),
            Field::new("iterations", DataType::UInt32, false),
        ];
        for name in &self.quantities {
            for of in ["error", "std", "bound"] {
                fields.push(Field::new(format!("{name}.{of}"), DataType::Float64, true));
            }
            fields.push(Field::new(format!("{name}.inside"), DataType::Boolean, true));
        }
        Arc::new(Schema::new(fields))
    }

    pub(super) fn batch(&self, rows: &[Row]) -> Result<RecordBatch, ArrowError> {
        let text = |of: &dyn Fn(&Row) -> Option<String>| -> ArrayRef {
            let mut texts = StringDictionaryBuilder::<Int32Type>::new();
            rows.iter().for_each(|row| texts.append_option(of(row)));
            Arc::new(texts.finish())
        };
        let mut arrays: Vec<ArrayRef> = vec![
            Arc::new(rows.iter().map(|row| row.point as u32).collect::<UInt32Array>()),
            Arc::new(rows.iter().map(|row| row.trial).collect::<UInt64Array>()),
            text(&|row| Some(self.estimators[row.estimator].clone())),
            text(&|row| Some(self.solvers[row.solver].clone())),
            text(&|row| Some(row.outcome.to_string())),
            text(&|row| row.reason.clone()),
            Arc::new(rows.iter().map(|row| row.iterations as u32).collect::<UInt32Array>()),
        ];
        for place in 0..self.quantities.len() {
            let number = |of: fn(&Cell) -> f64| -> ArrayRef {
                let cells = rows.iter().map(|row| Some(of(&row.cells[place])).filter(|number| !number.is_nan()));
                Arc::new(cells.collect::<Float64Array>())
            };
            arrays.extend([number(|cell| cell.error), number(|cell| cell.std), number(|cell| cell.bound)]);
            arrays.push(Arc::new(rows.iter().map(|row| row.cells[place].inside).collect::<BooleanArray>()));
        }
        RecordBatch::try_new(self.schema(), arrays)
    }

    /// A part's file in memory. It is small, and not compressed: the merged table is.
    pub(super) fn file(&self, rows: &[Row]) -> Result<Vec<u8>, ParquetError> {
        let mut writer = writer(self.schema(), Vec::new(), Compression::UNCOMPRESSED)?;
        writer.write(&self.batch(rows)?)?;
        writer.into_inner()
    }
}

/// How the table that a study leaves is compressed.
pub(super) fn compressed() -> Compression {
    Compression::ZSTD(ZstdLevel::default())
}

/// Writes tables of trials. Errors hardly ever repeat: only texts are written as places in a dictionary.
pub(super) fn writer<W: std::io::Write + Send>(
    schema: Arc<Schema>,
    to: W,
    compression: Compression,
) -> Result<ArrowWriter<W>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .set_dictionary_enabled(false)
        .set_max_row_group_row_count(Some(ROW_GROUP));
    let texts = schema.fields().iter().filter(|field| matches!(field.data_type(), DataType::Dictionary(..)));
    let properties = texts.fold(properties, |properties, field| {
        properties.set_column_dictionary_enabled(ColumnPath::from(field.name().as_str()), true)
    });
    ArrowWriter::try_new(to, schema, Some(properties.build()))
}

/// The rows of a table of trials, batch by batch.
pub struct TableReader {
    path: PathBuf,
    columns: Columns,
    batches: ParquetRecordBatchReader,
}

impl TableReader {
    /// Opens a table.
    ///
    /// # Errors
    /// It is not there, or has other columns.
    pub fn open(path: &Path, columns: &Columns) -> Result<TableReader, BatchError> {
        let refuse = |why: String| BatchError::Table { path: path.to_owned(), why };
        let builder = open_parquet(path).map_err(refuse)?;
        let (found, expected) = (builder.schema(), columns.schema());
        let names = |schema: &Schema| schema.fields().iter().map(|field| field.name().clone()).collect::<Vec<_>>();
        if names(found) != names(&expected) {
            return Err(refuse("its columns are not those of the study".to_owned()));
        }
        let batches = shielded_parquet(|| builder.build()).map_err(refuse)?;
        Ok(TableReader { path: path.to_owned(), columns: columns.clone(), batches })
    }

    pub(super) fn next_batch(&mut self) -> Option<Result<RecordBatch, BatchError>> {
        let batch = shielded_parquet(|| self.batches.next().transpose());
        batch.map_err(|why| BatchError::Table { path: self.path.clone(), why }).transpose()
    }

    /// The next rows, some thousand at most; `None` at the end.
    pub fn next_rows(&mut self) -> Option<Result<Vec<Row>, BatchError>> {
        let batch = match self.next_batch()? {
            Ok(batch) => batch,
            Err(error) => return Some(Err(error)),
        };
        Some(self.rows(&batch))
    }

    pub(super) fn rows(&self, batch: &RecordBatch) -> Result<Vec<Row>, BatchError> {
        let why = || "a column has an unexpected kind, or a cell a name that the study has not".to_owned();
        rows(batch, &self.columns).ok_or_else(|| BatchError::Table { path: self.path.clone(), why: why() })
    }
}

fn rows(batch: &RecordBatch, columns: &Columns) -> Option<Vec<Row>> {
    let texts = |column: usize| -> Option<Vec<Option<String>>> {
        let array = batch.column(column).as_dictionary_opt::<Int32Type>()?;
        let texts = array.downcast_dict::<arrow_array::StringArray>()?;
        Some(texts.into_iter().map(|text| text.map(str::to_owned)).collect())
    };
    let point = batch.column(0).as_primitive_opt::<UInt32Type>()?;
    let trial = batch.column(1).as_primitive_opt::<UInt64Type>()?;
    let (estimator, solver, outcome, reason) = (texts(2)?, texts(3)?, texts(4)?, texts(5)?);
    let iterations = batch.column(6).as_primitive_opt::<UInt32Type>()?;
    let numbers = |column: usize| batch.column(column).as_primitive_opt::<Float64Type>();
    let quantities = (0..columns.quantities.len()).map(|place| {
        let first = LEADING + 4 * place;
        let inside = batch.column(first + 3).as_boolean_opt()?;
        Some((numbers(first)?, numbers(first + 1)?, numbers(first + 2)?, inside))
    });
    let quantities: Vec<_> = quantities.collect::<Option<_>>()?;
    let place = |names: &[String], name: &Option<String>| names.iter().position(|known| Some(known) == name.as_ref());
    let number = |array: &Float64Array, row: usize| if array.is_null(row) { f64::NAN } else { array.value(row) };
    (0..batch.num_rows())
        .map(|row| {
            Some(Row {
                point: point.value(row) as usize,
                trial: trial.value(row),
                estimator: place(&columns.estimators, &estimator[row])?,
                solver: place(&columns.solvers, &solver[row])?,
                outcome: outcome[row].as_ref()?.parse().ok()?,
                reason: reason[row].clone(),
                iterations: u64::from(iterations.value(row)),
                cells: quantities
                    .iter()
                    .map(|(error, std, bound, inside)| Cell {
                        error: number(error, row),
                        std: number(std, row),
                        bound: number(bound, row),
                        inside: (!inside.is_null(row)).then(|| inside.value(row)),
                    })
                    .collect(),
            })
        })
        .collect()
}
