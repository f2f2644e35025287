//! Recordings of any kind, as arrays.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use gravcal::recording::{ReadError, Row, open};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;

use crate::failure::bad_input;
use crate::work::run;

/// Columns and rows of a recording, with what its reader remarks.
struct Read {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    remarks: Vec<String>,
}

/// Columns, cells, remarks.
type Reported<'py> = (Vec<String>, Bound<'py, PyArray2<f64>>, Vec<String>);

/// Names of the columns; a row each row, NaN where it says nothing; remarks of the reader.
#[pyfunction]
#[pyo3(signature = (path, progress=None))]
pub fn read_recording<'py>(
    py: Python<'py>,
    path: PathBuf,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Reported<'py>> {
    let read = run(py, progress, &AtomicBool::new(false), |report| {
        let mut recording = open(&path)?;
        let (mut row, mut rows) = (Row::default(), Vec::new());
        while recording.read(&mut row)? {
            if rows.len() % 10_000 == 9_999 {
                report(format!("reading {}: {:.0} %", path.display(), 100.0 * recording.progress()));
            }
            rows.push(row.cells.clone());
        }
        Ok(Read { columns: recording.columns().to_vec(), rows, remarks: recording.remarks() })
    })?;
    let Read { columns, rows, remarks } = read.map_err(|error: ReadError| bad_input(py, &error))?;
    // Columns that come midway are empty before.
    let cell = |(row, column): (usize, usize)| rows[row].get(column).copied().unwrap_or(f64::NAN);
    let cells = Array2::from_shape_fn((rows.len(), columns.len()), cell);
    Ok((columns, cells.into_pyarray(py), remarks))
}
