//! A Parquet file as rows, read batch by batch. On damaged bytes the libraries that read it may panic: they are shielded.

mod lengths;

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::File;
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Decimal32Type, Decimal64Type, Decimal128Type, Decimal256Type, DecimalType, Float16Type,
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, Float64Array, Int64Array, RecordBatch};
use arrow_schema::{ArrowError, DataType, TimeUnit};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::basic::Compression;
use parquet::file::metadata::ParquetMetaData;

pub use self::lengths::CheckedFile;
use super::missing::{Missing, NO_DATES, NOT_FINITE, report_missing};
use super::shield::shielded;
use super::stamp::Stamp;
use super::{Row, Rows, Source};
use crate::column_names::check_count;
use crate::error::ReadError;
use crate::file::opened;
use crate::iso8601;

/// Rows that are decoded together, and the most cells in them.
const BATCH: usize = 4096;
const BATCH_CELLS: usize = 1 << 20;

/// Texts that are looked at to see whether a column holds dates.
const FIRST_TEXTS: usize = 64;

/// Rows of a Parquet file.
pub(crate) struct ParquetRows {
    path: PathBuf,
    columns: Vec<String>,
    /// Two columns that are one time, which is a column more than the file has.
    stamp: Option<Stamp>,
    /// Which of them hold dates with times.
    dates: Vec<bool>,
    batches: ParquetRecordBatchReader,
    batch: Vec<Float64Array>,
    /// Place in the batch of the next row.
    next: usize,
    read: u64,
    total: u64,
    not_finite: Vec<u64>,
    remarks: Vec<String>,
    metadata: BTreeMap<String, String>,
}

impl ParquetRows {
    /// Opens a file.
    pub(crate) fn open(path: &Path) -> Result<ParquetRows, ReadError> {
        let file = || opened(path).map_err(|cause| ReadError::opening(path, cause));
        let builder = checked_parquet(file()?).map_err(|what| damaged(path, &what))?;
        check_compression(path, builder.metadata())?;
        let fields = builder.schema().fields();
        let texts: Vec<usize> = (0..fields.len()).filter(|field| is_text(fields[*field].data_type())).collect();
        let texts = text_of_dates(path, file()?, &texts)?;
        let is_read = |field: &usize| is_number(fields[*field].data_type()) || texts.contains(field);
        let numbers: Vec<usize> = (0..fields.len()).filter(is_read).collect();
        let columns: Vec<String> = numbers.iter().map(|field| fields[*field].name().clone()).collect();
        let is_date =
            |field: &usize| matches!(fields[*field].data_type(), DataType::Timestamp(..)) || texts.contains(field);
        let dates = numbers.iter().map(is_date).collect();
        let others = (0..fields.len()).filter(|field| !is_read(field)).map(|field| fields[field].name());
        let remarks = others.map(|field| format!("column `{field}` is left out: it holds no numbers")).collect();
        let metadata = metadata(builder.metadata().file_metadata().key_value_metadata());
        let total = u64::try_from(builder.metadata().file_metadata().num_rows()).unwrap_or(0);
        if columns.is_empty() {
            let what = "it has no column of numbers".to_owned();
            return Err(ReadError::NotRecording { path: path.to_owned(), what });
        }
        check_count(path, columns.len())?;
        if total == 0 {
            return Err(ReadError::NoRows { path: path.to_owned() });
        }
        let mask = ProjectionMask::roots(builder.parquet_schema(), numbers);
        let batch = BATCH.min(BATCH_CELLS / columns.len());
        let batches = taken_apart(path, || builder.with_projection(mask).with_batch_size(batch).build())?;
        let (path, not_finite) = (path.to_owned(), vec![0; columns.len()]);
        let stamp = Stamp::find(&columns);
        let columns = columns.into_iter().chain(stamp.map(|_| Stamp::column())).collect();
        Ok(ParquetRows {
            path,
            columns,
            stamp,
            dates,
            batches,
            batch: Vec::new(),
            next: 0,
            read: 0,
            total,
            not_finite,
            remarks,
            metadata,
        })
    }

    /// Goes on to the next batch; false at the end.
    fn next_batch(&mut self) -> Result<bool, ReadError> {
        let batches = &mut self.batches;
        let batch = taken_apart(&self.path, || batches.next().map(|batch| numbers(&batch?)).transpose())?;
        let Some(batch) = batch else { return Ok(false) };
        self.batch = batch;
        self.next = 0;
        Ok(true)
    }
}

impl Rows for ParquetRows {
    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        while self.batch.first().is_none_or(|column| self.next == column.len()) {
            if !self.next_batch()? {
                return Ok(false);
            }
        }
        self.read += 1;
        row.number = self.read;
        row.cells.clear();
        for (column, not_finite) in self.batch.iter().zip(&mut self.not_finite) {
            let cell = match column.is_null(self.next) {
                true => f64::NAN,
                false => column.value(self.next),
            };
            let is_bad = !column.is_null(self.next) && !cell.is_finite();
            *not_finite += u64::from(is_bad);
            row.cells.push(if is_bad { f64::NAN } else { cell });
        }
        row.cells.extend(self.stamp.map(|stamp| stamp.time(&row.cells)));
        self.next += 1;
        Ok(true)
    }

    fn holds_dates(&self, column: usize) -> bool {
        self.dates.get(column).copied().unwrap_or(false)
    }

    fn source(&self) -> Source {
        Source { kind: "Parquet file".to_owned(), topics: Vec::new() }
    }

    fn remarks(&self) -> Vec<String> {
        let of = |dates: bool, which: &str| {
            let columns = self.columns.iter().zip(&self.not_finite).zip(&self.dates);
            let columns = columns.filter(move |(_, of_dates)| **of_dates == dates);
            report_missing(which, columns.map(|((column, count), _)| Missing { column, count: *count, first: None }))
        };
        self.remarks.iter().cloned().chain(of(false, NOT_FINITE)).chain(of(true, NO_DATES)).collect()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        self.metadata.clone()
    }

    fn progress(&self) -> f64 {
        self.read as f64 / self.total.max(1) as f64
    }
}

/// Whether a column holds what can be a number; times are, in seconds.
fn is_number(kind: &DataType) -> bool {
    kind.is_numeric() || matches!(kind, DataType::Boolean | DataType::Timestamp(..) | DataType::Duration(_))
}

/// Whether a column holds texts, which may be dates with times.
fn is_text(kind: &DataType) -> bool {
    matches!(kind, DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View)
}

/// Those of some columns of texts whose first one is a date with a time. `file`: the same once more.
fn text_of_dates(path: &Path, file: File, fields: &[usize]) -> Result<Vec<usize>, ReadError> {
    if fields.is_empty() {
        return Ok(Vec::new());
    }
    let builder = checked_parquet(file).map_err(|what| damaged(path, &what))?;
    let mask = ProjectionMask::roots(builder.parquet_schema(), fields.iter().copied());
    let first =
        taken_apart(path, || builder.with_projection(mask).with_batch_size(FIRST_TEXTS).build()?.next().transpose())?;
    let is_date = |column: &dyn Array| texts(column).into_iter().flatten().flatten().next().and_then(iso8601::seconds);
    let columns = first.iter().flat_map(RecordBatch::columns).zip(fields);
    Ok(columns.filter(|(column, _)| is_date(column).is_some()).map(|(_, field)| *field).collect())
}

/// The cells of a column of texts; `None` of another.
fn texts(column: &dyn Array) -> Option<Vec<Option<&str>>> {
    Some(match column.data_type() {
        DataType::Utf8 => column.as_string::<i32>().iter().collect(),
        DataType::LargeUtf8 => column.as_string::<i64>().iter().collect(),
        DataType::Utf8View => column.as_string_view().iter().collect(),
        _ => return None,
    })
}

/// Name of a compression that is not read.
fn not_read(compression: Compression) -> Option<&'static str> {
    match compression {
        Compression::BROTLI(_) => Some("brotli"),
        Compression::LZO => Some("lzo"),
        _ => None,
    }
}

/// Refuses what is compressed in a way that is not read.
fn check_compression(path: &Path, metadata: &ParquetMetaData) -> Result<(), ReadError> {
    let columns = metadata.row_groups().iter().flat_map(|group| group.columns());
    let other = columns.map(|column| column.compression()).find_map(not_read);
    other.map_or(Ok(()), |other| {
        let what = format!(
            "this Parquet file is compressed by {other}, which is not read: write it with snappy, gzip, zstd, lz4 or no compression (pandas: \
             to_parquet(path, compression=\"zstd\"))"
        );
        Err(ReadError::NotRecording { path: path.to_owned(), what })
    })
}

/// The columns of a batch as `f64`; each [`is_number`], or a text of dates.
fn numbers(batch: &RecordBatch) -> Result<Vec<Float64Array>, ArrowError> {
    batch.columns().iter().map(|column| number(column)).collect()
}

fn number(column: &dyn Array) -> Result<Float64Array, ArrowError> {
    Ok(match column.data_type() {
        DataType::Boolean => column.as_boolean().iter().map(|cell| cell.map(f64::from)).collect(),
        DataType::Int8 => widened::<Int8Type>(column, f64::from),
        DataType::Int16 => widened::<Int16Type>(column, f64::from),
        DataType::Int32 => widened::<Int32Type>(column, f64::from),
        DataType::Int64 => widened::<Int64Type>(column, |whole| whole as f64),
        DataType::UInt8 => widened::<UInt8Type>(column, f64::from),
        DataType::UInt16 => widened::<UInt16Type>(column, f64::from),
        DataType::UInt32 => widened::<UInt32Type>(column, f64::from),
        DataType::UInt64 => widened::<UInt64Type>(column, |whole| whole as f64),
        DataType::Float16 => widened::<Float16Type>(column, f64::from),
        DataType::Float32 => widened::<Float32Type>(column, f64::from),
        DataType::Float64 => column.as_primitive::<Float64Type>().clone(),
        DataType::Decimal32(..) => decimal::<Decimal32Type>(column),
        DataType::Decimal64(..) => decimal::<Decimal64Type>(column),
        DataType::Decimal128(..) => decimal::<Decimal128Type>(column),
        DataType::Decimal256(..) => decimal::<Decimal256Type>(column),
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => {
            let whole = Int64Array::from(column.to_data().into_builder().data_type(DataType::Int64).build()?);
            let ticks = ticks(*unit);
            whole.unary(|whole| whole as f64 / ticks)
        }
        other => match texts(column) {
            // A text that is no date is no number, which is counted.
            Some(texts) => {
                let seconds = |text: Option<&str>| text.map(|text| iso8601::seconds(text.trim()).unwrap_or(f64::NAN));
                texts.into_iter().map(seconds).collect()
            }
            None => return Err(ArrowError::NotYetImplemented(format!("numbers of type {other}"))),
        },
    })
}

fn widened<T: ArrowPrimitiveType>(column: &dyn Array, number: impl Fn(T::Native) -> f64) -> Float64Array {
    column.as_primitive::<T>().unary(number)
}

/// By its digits, so that no power of ten rounds them.
fn decimal<T: DecimalType>(column: &dyn Array) -> Float64Array {
    let column = column.as_primitive::<T>();
    let number = |row: usize| column.is_valid(row).then(|| column.value_as_string(row).parse().unwrap_or(f64::NAN));
    (0..column.len()).map(number).collect()
}

/// How many of a unit are a second.
fn ticks(unit: TimeUnit) -> f64 {
    match unit {
        TimeUnit::Second => 1.0,
        TimeUnit::Millisecond => 1e3,
        TimeUnit::Microsecond => 1e6,
        TimeUnit::Nanosecond => 1e9,
    }
}

/// What is said of the file; the Arrow schema that its writer puts there too says nothing of the recording.
fn metadata(pairs: Option<&Vec<parquet::file::metadata::KeyValue>>) -> BTreeMap<String, String> {
    let pairs = pairs.into_iter().flatten().filter(|pair| pair.key != "ARROW:schema");
    pairs.filter_map(|pair| Some((pair.key.clone(), pair.value.clone()?))).collect()
}

/// What the libraries make of the bytes; where they fail or panic, the file is damaged, or no Parquet file they know.
fn taken_apart<T, E: Display>(path: &Path, call: impl FnOnce() -> Result<T, E>) -> Result<T, ReadError> {
    shielded_parquet(call).map_err(|what| damaged(path, &what))
}

fn damaged(path: &Path, what: &str) -> ReadError {
    let what = format!("this Parquet file cannot be read, it seems to be damaged: {what}; copy or write it again");
    ReadError::NotRecording { path: path.to_owned(), what }
}

/// Opens a Parquet file of which nothing is known. Lengths in it are checked before the libraries see them; what they then do with
/// what this gives belongs into [`shielded_parquet`].
///
/// # Errors
/// What is wrong with the file, in words.
pub fn open_parquet(path: &Path) -> Result<ParquetRecordBatchReaderBuilder<CheckedFile>, String> {
    checked_parquet(opened(path).map_err(|error| error.to_string())?)
}

fn checked_parquet(file: File) -> Result<ParquetRecordBatchReaderBuilder<CheckedFile>, String> {
    let file = shielded_parquet(|| CheckedFile::new(file))?;
    shielded_parquet(|| ParquetRecordBatchReaderBuilder::try_new(file))
}

/// A call into the libraries that take Parquet files apart: on damaged bytes they may panic, which here is an error like others.
///
/// # Errors
/// What they say, in words. What the call worked on must not be used again.
pub fn shielded_parquet<T, E: Display>(call: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    match shielded(call) {
        Ok(made) => made.map_err(|error| error.to_string()),
        Err(panicked) => Err(panicked.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compressions_that_are_not_read_have_a_name() {
        use Compression::{BROTLI, GZIP, LZ4_RAW, LZO, SNAPPY, UNCOMPRESSED, ZSTD};
        assert_eq!([BROTLI(Default::default()), LZO].map(not_read), [Some("brotli"), Some("lzo")]);
        for read in [UNCOMPRESSED, SNAPPY, GZIP(Default::default()), ZSTD(Default::default()), LZ4_RAW] {
            assert_eq!(not_read(read), None);
        }
    }
}
