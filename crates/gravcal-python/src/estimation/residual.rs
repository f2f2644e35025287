//! A residual that is computed in Python.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use gravcal::estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyArithmeticError;
use pyo3::prelude::*;

/// What functions of the user raised first. Nothing is asked of them after it, and the work ends.
#[derive(Debug, Default)]
pub struct Raised {
    error: Mutex<Option<PyErr>>,
    stop: AtomicBool,
}

impl Raised {
    /// Set once something was raised, or by whoever wants the work to end.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// What was raised since this was asked last.
    pub fn take(&self) -> Option<PyErr> {
        self.stop.store(false, Ordering::Relaxed);
        self.error.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Does `work` with the interpreter, unless something was raised before. Where numbers leave no value (a division by zero), a solver
    /// may shorten its step; all else that is raised ends the work.
    pub fn watch<T>(&self, work: impl FnOnce(Python<'_>) -> PyResult<T>) -> Result<T, EvaluateError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(EvaluateError("stopped".into()));
        }
        Python::attach(|py| {
            work(py).map_err(|error| {
                let reported = EvaluateError(error.to_string());
                if !error.is_instance_of::<PyArithmeticError>(py) {
                    self.error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    self.stop.store(true, Ordering::Relaxed);
                }
                reported
            })
        })
    }
}

/// `evaluate(x, jacobian)` in Python, with x block after block, gives the residuals and, where `jacobian` is true, their derivatives, rows
/// by x.
#[derive(Debug)]
pub struct PythonResidual {
    pub blocks: Vec<BlockId>,
    pub rows: usize,
    pub evaluate: Py<PyAny>,
    pub raised: Arc<Raised>,
}

/// What Python answers: it has checked the lengths.
type Answer<'py> = (PyReadonlyArray1<'py, f64>, Option<PyReadonlyArray2<'py, f64>>);

impl Residual for PythonResidual {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        self.raised.watch(|py| {
            let x = PyArray1::from_slice(py, x.as_slice());
            let answer = self.evaluate.bind(py).call1((x, jacobian.is_some()))?;
            let (values, slopes): Answer<'_> = answer.extract()?;
            residual.iter_mut().zip(values.as_array()).for_each(|(own, value)| *own = *value);
            if let (Some(mut rows), Some(slopes)) = (jacobian, slopes) {
                for (row, slopes) in slopes.as_array().rows().into_iter().enumerate() {
                    rows.row(row).iter_mut().zip(slopes).for_each(|(own, slope)| *own = *slope);
                }
            }
            Ok(())
        })
    }
}
