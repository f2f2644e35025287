//! Errors, as the exceptions of `gravcal.errors`.

use std::error::Error;
use std::path::Path;

use gravcal::calibration::robot::FileError;
use gravcal::calibration::session::SessionError;
use gravcal_cli::Failure;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// An exception, with what is known of its place.
#[derive(Debug, Default)]
struct Place<'a> {
    file: Option<&'a Path>,
    line: Option<usize>,
    field: Option<&'a str>,
}

/// Bad input of whatever kind.
pub fn bad_input(py: Python<'_>, error: &dyn Error) -> PyErr {
    bad_input_reported(py, &error.to_string())
}

/// The same, in words.
pub fn bad_input_reported(py: Python<'_>, message: &str) -> PyErr {
    raised(py, message, &Place::default())
}

/// What the program would say.
pub fn failure(py: Python<'_>, failure: &Failure) -> PyErr {
    let reported = failure.to_string();
    raised(py, reported.strip_prefix("error: ").unwrap_or(&reported), &Place::default())
}

/// Something is wrong with a file.
pub fn file_error(py: Python<'_>, error: &FileError) -> PyErr {
    let place = Place { file: Some(error.path()), line: error.line(), field: error.field() };
    raised(py, &error.to_string(), &place)
}

/// A session cannot be read. `in_memory`: its text is not the user's, who knows no lines of it.
pub fn session_error(py: Python<'_>, error: &SessionError, in_memory: bool) -> PyErr {
    match error {
        SessionError::File(error) if in_memory => {
            let error = error.clone().without_line();
            raised(py, &error.to_string(), &Place { field: error.field(), ..Place::default() })
        }
        SessionError::File(error) => file_error(py, error),
        SessionError::Table { error, .. } if in_memory => bad_input(py, error),
        SessionError::Table { .. } => bad_input(py, error),
    }
}

fn raised(py: Python<'_>, message: &str, place: &Place<'_>) -> PyErr {
    exception(py, message, place).unwrap_or_else(|error| error)
}

fn exception(py: Python<'_>, message: &str, place: &Place<'_>) -> PyResult<PyErr> {
    let kind = py.import("gravcal.errors")?.getattr("InputError")?;
    let known: Bound<'_, PyDict> = [("line", place.line)].into_py_dict(py)?;
    known.set_item("file", place.file.map(|file| file.display().to_string()))?;
    known.set_item("field", place.field)?;
    Ok(PyErr::from_value(kind.call((message,), Some(&known))?))
}
