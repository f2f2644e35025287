//! Residuals whose functions are written in Python, for all rows at once.

use std::sync::Arc;

use gravcal::calibration::residual_models::{
    DeclaredResidual, ResidualModel, ResidualRow, ResidualTerm, Scene, Sees, Setting, Slopes, Tie,
};
use gravcal::calibration::sensors::{Options, RefusedOption};
use gravcal::calibration::session::Pose;
use gravcal::dynamics::LinkFrame;
use gravcal::estimation::EvaluateError;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::said::SaidParameter;
use crate::estimation::Raised;

/// What Python says of a residual: an object with these attributes.
#[derive(Debug, FromPyObject)]
pub struct SaidResidual {
    pub name: String,
    help: String,
    parameters: Vec<SaidParameter>,
    columns: Vec<String>,
    joints: Vec<String>,
    links: Vec<String>,
    sees_gravity: bool,
    std: f64,
    evaluate_rows: Py<PyAny>,
}

/// The model of it.
#[derive(Clone, Debug)]
pub struct PythonResidual {
    said: Arc<SaidResidual>,
    raised: Arc<Raised>,
}

impl PythonResidual {
    pub fn new(said: SaidResidual, raised: &Arc<Raised>) -> PythonResidual {
        PythonResidual { said: Arc::new(said), raised: Arc::clone(raised) }
    }
}

impl ResidualModel for PythonResidual {
    fn name(&self) -> &str {
        &self.said.name
    }

    fn help(&self) -> &str {
        &self.said.help
    }

    fn columns(&self) -> Vec<&str> {
        self.said.columns.iter().map(String::as_str).collect()
    }

    fn declare(&self, setting: &Setting<'_>, _options: &Options) -> Result<DeclaredResidual, RefusedOption> {
        let (said, chain) = (&self.said, setting.chain());
        let missing = |what: &str, name: &str| {
            RefusedOption::new(
                "kind",
                format!("residual `{}` reads the {what} `{name}`, and the robot has none", said.name),
            )
        };
        let joint = |name: &String| chain.joint_index(name).ok_or_else(|| missing("joint", name));
        let link = |name: &String| chain.link_index(name).ok_or_else(|| missing("link", name));
        let mut joints = said.joints.iter().map(joint).collect::<Result<Vec<_>, _>>()?;
        let links = said.links.iter().map(link).collect::<Result<Vec<_>, _>>()?;
        links.iter().for_each(|link| joints.extend(setting.joints_moving(*link)));
        let sees = Sees::nothing().coordinates(&joints);
        let term = PythonRows {
            said: Arc::clone(said),
            raised: Arc::clone(&self.raised),
            sees: if said.sees_gravity { sees.gravity() } else { sees },
            joints: chain.joint_count(),
            links,
            columns: said.columns.iter().map(|name| setting.column(name)).collect(),
        };
        let parameters: Vec<_> = said.parameters.iter().map(SaidParameter::spec).collect();
        Ok(DeclaredResidual::new(parameters, term))
    }
}

/// The rows of one residual.
#[derive(Debug)]
struct PythonRows {
    said: Arc<SaidResidual>,
    raised: Arc<Raised>,
    sees: Sees,
    /// How many joints the robot has.
    joints: usize,
    links: Vec<usize>,
    columns: Vec<usize>,
}

/// What Python answers: it has checked the lengths.
type Answer<'py> = (
    PyReadonlyArray1<'py, f64>,
    Option<PyReadonlyArray2<'py, f64>>,
    Option<PyReadonlyArray2<'py, f64>>,
    Option<PyReadonlyArray2<'py, f64>>,
);

impl PythonRows {
    /// Coordinates and position readings of all joints, columns, then the frames of links, each with its slopes.
    fn cells(&self, at: &Scene<'_>) -> Vec<f64> {
        let joints = || 0..self.joints;
        let mut cells: Vec<f64> = joints().map(|joint| at.coordinate(joint)).collect();
        cells.extend(joints().map(|joint| at.position(joint)));
        cells.extend(self.columns.iter().map(|column| at.column(*column)));
        for link in &self.links {
            let LinkFrame { rotation, origin, by_coordinate } = at.link_frame(*link);
            let slopes = by_coordinate.into_iter();
            for (rotation, origin) in std::iter::once((rotation, origin)).chain(slopes) {
                cells.extend(rotation.into_iter().flatten().chain(origin));
            }
        }
        cells
    }

    fn evaluate(
        &self,
        rows: &[ResidualRow<'_>],
        x: &[f64],
        values: &mut [f64],
        slopes: &mut [Slopes<'_>],
    ) -> Result<(), EvaluateError> {
        let cells: Vec<Vec<f64>> = rows.iter().map(|row| self.cells(&row.at[0])).collect();
        let gravity = rows[0].at[0].gravity();
        let width = cells[0].len();
        self.raised.watch(|py| {
            let (x, gravity) = (PyArray1::from_slice(py, x), PyArray1::from_slice(py, &gravity));
            let table = Array2::from_shape_fn((cells.len(), width), |(row, column)| cells[row][column]);
            let arguments = (x, gravity, table.into_pyarray(py), self.sees.joints(), !slopes.is_empty());
            let answer = self.said.evaluate_rows.bind(py).call1(arguments)?;
            let (found, by_parameter, by_gravity, by_coordinate): Answer<'_> = answer.extract()?;
            values.iter_mut().zip(found.as_array()).for_each(|(own, found)| *own = *found);
            let copy = |row: usize, from: &Option<PyReadonlyArray2<'_, f64>>, to: &mut [f64]| {
                let Some(from) = from else { return };
                to.iter_mut().zip(from.as_array().row(row)).for_each(|(own, slope)| *own = *slope);
            };
            for (row, slopes) in slopes.iter_mut().enumerate() {
                copy(row, &by_parameter, slopes.by_parameter);
                copy(row, &by_gravity, slopes.by_gravity);
                copy(row, &by_coordinate, slopes.by_coordinate);
            }
            Ok(())
        })
    }
}

impl ResidualTerm for PythonRows {
    fn sees(&self) -> Sees {
        self.sees.clone()
    }

    fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        let number = |pose: &Pose, column: &usize| pose.conditions.further.get(*column).is_some_and(|n| n.is_finite());
        let observed = |place: &usize| self.columns.iter().all(|column| number(&poses[*place], column));
        (0..poses.len()).filter(observed).map(|place| Tie::new([place], self.said.std)).collect()
    }

    /// In Python, where it says so in Python's words.
    fn checks_derivatives(&self) -> bool {
        true
    }

    fn is_batched(&self) -> bool {
        true
    }

    /// Not finite where Python gives no value.
    fn values(&self, rows: &[ResidualRow<'_>], x: &[f64], values: &mut [f64], slopes: &mut [Slopes<'_>]) {
        if self.evaluate(rows, x, values, slopes).is_err() {
            values.fill(f64::NAN);
        }
    }

    fn value(&self, tie: &Tie, at: &[Scene<'_>], x: &[f64], slopes: Option<Slopes<'_>>) -> f64 {
        let mut value = [f64::NAN];
        let mut slopes: Vec<Slopes<'_>> = slopes.into_iter().collect();
        self.values(&[ResidualRow { tie, at }], x, &mut value, &mut slopes);
        value[0]
    }
}
