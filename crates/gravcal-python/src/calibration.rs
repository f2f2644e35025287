//! What estimators answered.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use gravcal::calibration::result::{EstimatorResult, ReadingResidual};
use gravcal::calibration::{Session, SolveEnvironment, doubts_of_results};
use gravcal::estimation::IterationRecord;
use gravcal_cli::{Choice, Exit, Failure, Phase, Stopwatch, provenance};
use gravcal_report::{
    CalibrationFile, CalibrationPage, CalibrationSummary, CalibrationTable, Contents, OutputFolder, Provenance, Timing,
    Written, report_doubts,
};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

use crate::failure::failure;
use crate::work::Report;

/// A calibration.
#[pyclass(frozen, module = "gravcal._native")]
pub struct Calibration {
    session: Arc<Session>,
    results: Vec<EstimatorResult>,
    provenance: Provenance,
    doubts: Vec<String>,
    timing: Timing,
    json: String,
}

/// As `gravcal calibrate` does, of the session that was read at `path` in so many milliseconds.
pub fn calibrate(
    (session, path, read_ms): (&Arc<Session>, &Path, f64),
    choice: &Choice,
    report: &Report<'_>,
    stop: &AtomicBool,
) -> Result<Calibration, Failure> {
    let provenance = provenance(session, path, choice)?;
    let watch = Stopwatch::start(Phase::Start);
    let stage = |stage: &str| {
        watch.enter(Phase::of_stage(stage));
        report(stage.to_owned());
    };
    let iteration = |record: &IterationRecord| {
        let IterationRecord { iteration, cost, .. } = record;
        report(format!("iteration {iteration}, cost {cost:.6e}"));
    };
    let environment =
        SolveEnvironment::new(choice.solver.method.as_ref(), &stage).observed_by(&iteration).stopped_by(stop);
    let results = gravcal::calibration::calibrate(session, &choice.estimators, &environment);
    let timing = Timing { read_ms, ..watch.times() };
    let doubts = [&session.doubts[..], &doubts_of_results(session, &results)].concat();
    let file = CalibrationFile { doubts: &doubts, estimators: &results, provenance: &provenance };
    let json = file.to_json().map_err(|error| Failure::no_convergence(&error))?;
    Ok(Calibration { session: Arc::clone(session), results, provenance, doubts, timing, json })
}

/// Residuals of readings: pose, channel, residual, residual before the calibration, standard deviation, weight.
type Residuals<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

#[pymethods]
impl Calibration {
    /// `calibration.json`.
    #[getter]
    fn json(&self) -> &str {
        &self.json
    }

    /// What the program prints: one screen.
    fn summary(&self) -> String {
        let robot = &self.session.robot.name;
        let summary = CalibrationSummary { robot, results: &self.results, file: "calibration.json" };
        match report_doubts(&self.doubts) {
            doubts if doubts.is_empty() => summary.to_string(),
            doubts => format!("{doubts}\n{summary}"),
        }
    }

    /// `table.txt`.
    fn table(&self) -> String {
        let robot = &self.session.robot.name;
        CalibrationTable { robot, doubts: &self.doubts, results: &self.results }.to_string()
    }

    /// `report.html`.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let page = py.detach(|| self.to_html());
        page.map_err(|error| failure(py, &error))
    }

    /// The exit code that the program would have.
    #[getter]
    fn exit_code(&self) -> u8 {
        Exit::of_calibration(&self.results).code()
    }

    /// Writes what `gravcal calibrate` writes; whether anything was written, as the same may be there already.
    fn save(&self, py: Python<'_>, folder: PathBuf, overwrite: bool) -> PyResult<bool> {
        let written = py.detach(|| {
            let timing = self.timing.to_json().map_err(|error| Failure::no_convergence(&error))?;
            let (table, page) = (self.table(), self.to_html()?);
            let contents = Contents { calibration: &self.json, table: &table, page: &page, timing: &timing };
            let folder = OutputFolder::new(folder, overwrite);
            folder.check().and_then(|()| folder.write(&contents)).map_err(|error| Failure::bad_input(&error))
        });
        written.map(|written| written == Written::New).map_err(|error| failure(py, &error))
    }

    /// Those of the estimator at this place among the results, each reading once.
    fn residuals<'py>(&self, py: Python<'py>, place: usize) -> Residuals<'py> {
        let fit = self.results.get(place).and_then(|result| result.fit.as_ref());
        let all = fit.map_or(&[][..], |fit| &fit.residuals);
        let floats =
            |number: &dyn Fn(&ReadingResidual) -> f64| all.iter().map(number).collect::<Vec<f64>>().into_pyarray(py);
        let pose: Vec<i64> = all.iter().map(|residual| residual.id.pose as i64).collect();
        let channel: Vec<i64> = all.iter().map(|residual| residual.id.channel as i64).collect();
        (
            pose.into_pyarray(py),
            channel.into_pyarray(py),
            floats(&|reading| reading.residual),
            floats(&|reading| reading.nominal_residual),
            floats(&|reading| reading.std),
            floats(&|reading| reading.weight),
        )
    }
}

impl Calibration {
    fn to_html(&self) -> Result<String, Failure> {
        let Calibration { session, results, provenance, .. } = self;
        CalibrationPage { session, results, provenance }.to_html().map_err(|error| Failure::no_convergence(&error))
    }
}
