//! A term of a sensor's model, computed in Python.

use std::sync::Arc;

use gravcal::calibration::sensors::{Moment, Partials, Reads, SensorTerm};
use gravcal::estimation::EvaluateError;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::batch::Batch;
use crate::estimation::Raised;

/// `evaluate(joint, x, poses, slopes)` in Python, of a table with a row each pose, gives values and, where `slopes` is true, derivatives by
/// parameters, by the joint's torque and by its coordinate.
#[derive(Debug)]
pub struct Function {
    pub evaluate: Py<PyAny>,
    pub joint: usize,
    pub raised: Arc<Raised>,
}

/// Values and derivatives of poses.
#[derive(Debug, Default)]
pub struct Evaluated {
    pub values: Vec<f64>,
    /// Poses by parameters, row-major.
    pub by_parameter: Vec<f64>,
    by_torque: Vec<f64>,
    by_coordinate: Vec<f64>,
}

/// What Python answers: it has checked the lengths.
type Answer<'py> = (
    PyReadonlyArray1<'py, f64>,
    Option<PyReadonlyArray2<'py, f64>>,
    Option<PyReadonlyArray1<'py, f64>>,
    Option<PyReadonlyArray1<'py, f64>>,
);

impl Function {
    /// Of rows as [`row`] gives them, one after the other.
    pub fn evaluate(&self, x: &[f64], rows: &[f64], width: usize, slopes: bool) -> Result<Evaluated, EvaluateError> {
        self.raised.watch(|py| {
            let x = PyArray1::from_slice(py, x);
            let table = Array2::from_shape_fn((rows.len() / width, width), |(row, column)| rows[row * width + column]);
            let answer = self.evaluate.bind(py).call1((self.joint, x, table.into_pyarray(py), slopes))?;
            let (values, by_parameter, by_torque, by_coordinate): Answer<'_> = answer.extract()?;
            let list = |array: Option<PyReadonlyArray1<'_, f64>>| {
                array.map_or_else(Vec::new, |array| array.as_array().iter().copied().collect())
            };
            Ok(Evaluated {
                values: values.as_array().iter().copied().collect(),
                by_parameter: by_parameter.map_or_else(Vec::new, |array| array.as_array().iter().copied().collect()),
                by_torque: list(by_torque),
                by_coordinate: list(by_coordinate),
            })
        })
    }
}

/// What a term may read of a pose: torque and coordinate of its joint, time, temperature, velocity and direction of its joint, and the
/// position readings of all joints.
pub fn row(joint: usize, joints: usize, at: &Moment<'_>) -> Vec<f64> {
    let temperature = at.temperature(joint).unwrap_or(f64::NAN);
    let own = [at.torque(joint), at.coordinate(joint), at.time(), temperature, at.velocity(joint), at.direction(joint)];
    own.into_iter().chain((0..joints).map(|other| at.position(other))).collect()
}

/// The term of one joint.
#[derive(Debug)]
pub struct PythonTerm {
    pub function: Function,
    pub reads: Reads,
    /// How many joints the robot has.
    pub joints: usize,
    /// Where it reads nothing but what poses say.
    pub batch: Option<Arc<Batch>>,
}

impl SensorTerm for PythonTerm {
    fn reads(&self) -> Reads {
        self.reads.clone()
    }

    /// In Python, where it says so in Python's words.
    fn checks_derivatives(&self) -> bool {
        true
    }

    /// Not finite where Python gives no value.
    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        let joint = self.function.joint;
        let row = row(joint, self.joints, at);
        if let Some(batch) = &self.batch {
            let slopes = partials.map(|partials| partials.by_parameter);
            return batch.value(&self.function, &row, x, slopes);
        }
        let Ok(found) = self.function.evaluate(x, &row, row.len(), partials.is_some()) else { return f64::NAN };
        if let Some(partials) = partials {
            partials.by_parameter.iter_mut().zip(&found.by_parameter).for_each(|(own, slope)| *own = *slope);
            for (all, slopes) in
                [(partials.by_torque, &found.by_torque), (partials.by_coordinate, &found.by_coordinate)]
            {
                if let (Some(own), Some(slope)) = (all.get_mut(joint), slopes.first()) {
                    *own = *slope;
                }
            }
        }
        found.values.first().copied().unwrap_or(f64::NAN)
    }
}
