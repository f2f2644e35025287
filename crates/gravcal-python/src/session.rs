//! Robots and sessions.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use gravcal::calibration::application::Effort;
use gravcal::calibration::check::check;
use gravcal::calibration::document::Document;
use gravcal::calibration::session as calibration_session;
use gravcal::calibration::session::{ReadingId, SessionError};
use gravcal::calibration::{EstimatorName, robot};
use gravcal::recording::{Memory, Numbers};
use gravcal_cli::{Choice, Phase, Stopwatch};
use gravcal_report::{CheckSummary, CheckTable, check_json};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::applied::Applied;
use crate::calibration::{self, Calibration};
use crate::failure::{bad_input, failure, file_error, session_error};
use crate::models::{Models, Said};
use crate::work::{Report, run};

/// The name in errors of a session that stands in no file.
const IN_MEMORY: &str = "Session";

/// A robot: names of its joints and links.
#[pyclass(frozen, module = "gravcal._native")]
pub struct Robot(gravcal::calibration::Robot);

#[pymethods]
impl Robot {
    /// From `robot.toml`.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Robot> {
        robot::read_robot(&path).map(Robot).map_err(|error| file_error(py, &error))
    }

    /// From a URDF.
    #[staticmethod]
    fn read_urdf(py: Python<'_>, path: PathBuf, base: &str, tips: Vec<String>) -> PyResult<Robot> {
        let tips: Vec<&str> = tips.iter().map(String::as_str).collect();
        robot::read_urdf(&path, base, &tips).map(Robot).map_err(|error| file_error(py, &error))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn joints(&self) -> Vec<String> {
        self.0.chain.joints().iter().map(|joint| joint.name.clone()).collect()
    }

    #[getter]
    fn links(&self) -> Vec<String> {
        self.0.chain.links().iter().map(|link| link.name.clone()).collect()
    }
}

/// A session that was read.
#[pyclass(frozen, module = "gravcal._native")]
pub struct Session {
    session: Arc<calibration_session::Session>,
    models: Models,
    path: PathBuf,
    read_ms: f64,
}

/// Coordinates and torques.
type Truth<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// A recording in memory: its name, its columns, and its numbers.
type Recording<'py> = (String, Vec<String>, PyReadonlyArray2<'py, f64>);

#[pymethods]
impl Session {
    /// From `session.toml`.
    #[staticmethod]
    #[pyo3(signature = (path, models, progress=None))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        models: Vec<Said>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Session> {
        let models = Models::new(py, models)?;
        let registry = models.registry();
        let read = |watch: &Watch<'_>| calibration_session::read_session_watched(&path, &registry, watch);
        let read = Session::of(py, &path, models, progress, read)?;
        read.map_err(|error| session_error(py, &error, false))
    }

    /// From what a `session.toml` would say, as JSON, and recordings under the names that it says.
    #[staticmethod]
    #[pyo3(signature = (said, recordings, models, progress=None))]
    fn in_memory(
        py: Python<'_>,
        said: &str,
        recordings: Vec<Recording<'_>>,
        models: Vec<Said>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Session> {
        let said: serde_json::Value = serde_json::from_str(said).map_err(|error| bad_input(py, &error))?;
        let text = toml::to_string(&said).map_err(|error| bad_input(py, &error))?;
        let path = Path::new(IN_MEMORY);
        let document = Document::of(path, text).map_err(|error| file_error(py, &error.without_line()))?;
        let mut memory = Memory::default();
        for (name, columns, cells) in recordings {
            // Row by row, whatever their order in memory.
            let cells = cells.as_array().iter().copied().collect();
            memory = memory.with(name, Numbers::new(columns, cells).map_err(|error| bad_input(py, &error))?);
        }
        let models = Models::new(py, models)?;
        let registry = models.registry();
        let read =
            |watch: &Watch<'_>| calibration_session::read_session_in_memory(&document, &registry, &memory, watch);
        let read = Session::of(py, path, models, progress, read)?;
        read.map_err(|error| session_error(py, &error, true))
    }

    #[getter]
    fn robot(&self) -> &str {
        &self.session.robot.name
    }

    #[getter]
    fn joints(&self) -> Vec<String> {
        self.session.robot.chain.joints().iter().map(|joint| joint.name.clone()).collect()
    }

    /// Names and units of all that gives a number in a pose, besides positions.
    #[getter]
    fn channels(&self) -> Vec<(String, String)> {
        let channels = 0..self.session.channel_count();
        channels.map(|channel| (self.session.channel_name(channel), self.session.channel_unit(channel))).collect()
    }

    #[getter]
    fn doubts(&self) -> Vec<String> {
        self.session.doubts.clone()
    }

    #[getter]
    fn inputs(&self) -> Vec<PathBuf> {
        self.session.input_paths().cloned().collect()
    }

    /// The load in each pose.
    #[getter]
    fn loads(&self) -> Vec<Option<String>> {
        let name = |load: usize| self.session.loads[load].name.clone();
        self.session.poses.iter().map(|pose| pose.load.map(name)).collect()
    }

    /// Position readings, a row each pose: rad, m, or the sensor's own unit.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let poses = &self.session.poses;
        let shape = (poses.len(), self.session.joints.len());
        Array2::from_shape_fn(shape, |(pose, joint)| poses[pose].position[joint]).into_pyarray(py)
    }

    /// Readings of all channels, a row each pose; NaN where there is none.
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.of_readings(|reading| Some(reading.value)).into_pyarray(py)
    }

    /// Their standard deviations as stated; NaN where they are not.
    #[getter]
    fn std<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.of_readings(|reading| reading.std).into_pyarray(py)
    }

    /// Runs estimators: those that are named, else the session's, else the default.
    #[pyo3(signature = (estimators, solver=None, progress=None))]
    fn calibrate(
        &self,
        py: Python<'_>,
        estimators: Vec<String>,
        solver: Option<&str>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Calibration> {
        let estimators = estimators.iter().map(|name| name.parse::<EstimatorName>()).collect::<Result<Vec<_>, _>>();
        let estimators = estimators.map_err(|error| bad_input(py, &error))?;
        let calibrated = self.work(py, progress, |report, stop| {
            let choice = self.choice(&estimators, solver)?;
            calibration::calibrate((&self.session, &self.path, self.read_ms), &choice, report, stop)
        })?;
        calibrated.map_err(|error| failure(py, &error))
    }

    /// What it can determine: as JSON, on one screen, as a table, and whether that is all that is asked for.
    fn check(&self, py: Python<'_>) -> PyResult<(String, String, String, bool)> {
        let reported = self.work(py, None, |_, _| {
            let choice = self.choice(&[], None)?;
            let steps = choice.estimators.iter().any(|estimator| estimator.follows_steps());
            let bad = |error: &dyn std::error::Error| gravcal_cli::Failure::bad_input(error);
            let report = check(&self.session).map_err(|error| bad(&error))?;
            let json = check_json(&report).map_err(|error| bad(&error))?;
            let robot = &self.session.robot.name;
            let summary = CheckSummary { robot, report: &report, steps }.to_string();
            let table = CheckTable { robot, report: &report, steps }.to_string();
            Ok((json, summary, table, report.complete))
        })?;
        reported.map_err(|error: gravcal_cli::Failure| failure(py, &error))
    }

    /// Coordinates and torques behind readings, a row each sample.
    #[expect(clippy::too_many_arguments)] // Python names each of them
    fn apply<'py>(
        &self,
        py: Python<'py>,
        calibration: PathBuf,
        estimator: &str,
        position: PyReadonlyArray2<'_, f64>,
        torque: PyReadonlyArray2<'_, f64>,
        load: Option<String>,
        residual: bool,
        nominal: bool,
    ) -> PyResult<Truth<'py>> {
        let effort = if residual { Effort::Residual { load } } else { Effort::Torque };
        let applied = Applied { calibration: &calibration, estimator, effort, nominal };
        let readings = (position.as_array(), torque.as_array());
        let found = self.work(py, None, |_, _| applied.to(&self.session, readings))?;
        let found = found.map_err(|error| failure(py, &error))?;
        Ok((found.0.into_pyarray(py), found.1.into_pyarray(py)))
    }
}

/// Who is told how far a recording is read.
type Watch<'a> = dyn Fn(&Path, f64) + 'a;

impl Session {
    /// What runs, by which method.
    fn choice(&self, estimators: &[EstimatorName], solver: Option<&str>) -> Result<Choice, gravcal_cli::Failure> {
        Choice::new((estimators, solver), (self.session.as_ref(), self.path.as_path()), &self.models.registry())
    }

    fn of(
        py: Python<'_>,
        path: &Path,
        models: Models,
        progress: Option<&Bound<'_, PyAny>>,
        read: impl FnOnce(&Watch<'_>) -> Result<gravcal::calibration::Session, SessionError> + Send,
    ) -> PyResult<Result<Session, SessionError>> {
        let raised = models.raised().cloned();
        let read = run(py, progress, &AtomicBool::new(false), |report| {
            let watch = Stopwatch::start(Phase::Read);
            let reported =
                |path: &Path, share: f64| report(format!("reading {}: {:.0} %", path.display(), 100.0 * share));
            let session = Arc::new(read(&reported)?);
            models.know_poses(&session);
            Ok(Session { session, models, path: path.to_owned(), read_ms: watch.times().read_ms })
        })?;
        raised.and_then(|raised| raised.take()).map_or(Ok(read), Err)
    }

    /// Work that may ask models in Python: what they raise ends it, and is raised.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Report<'_>, &AtomicBool) -> T + Send,
    ) -> PyResult<T> {
        let Some(raised) = self.models.raised() else {
            let stop = AtomicBool::new(false);
            return run(py, progress, &stop, |report| work(report, &stop));
        };
        let done = run(py, progress, raised.stop(), |report| work(report, raised.stop()));
        raised.take().map_or(done, Err)
    }

    fn of_readings(&self, number: impl Fn(&gravcal::recording::Reading) -> Option<f64>) -> Array2<f64> {
        let shape = (self.session.poses.len(), self.session.channel_count());
        Array2::from_shape_fn(shape, |(pose, channel)| {
            self.session.reading(ReadingId { pose, channel }).and_then(&number).unwrap_or(f64::NAN)
        })
    }
}
