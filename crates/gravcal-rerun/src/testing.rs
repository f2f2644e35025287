//! Calibrations to record.

use std::path::Path;
use std::sync::LazyLock;

use gravcal_calibration::result::EstimatorResult;
use gravcal_calibration::{SolveEnvironment, calibrate};
use gravcal_robot_model::{EstimatorName, Session};
use gravcal_session::read_session;
use gravcal_solvers::LevenbergMarquardt;

use crate::contents::CalibrationRecording;
use crate::read_back::ReadBack;

/// A session with its results.
#[derive(Clone)]
pub struct Calibrated {
    pub session: Session,
    pub results: Vec<EstimatorResult>,
}

impl Calibrated {
    /// The Sarcos shoulder, calibrated once, with the default estimators.
    pub fn sarcos_shoulder() -> &'static Calibrated {
        static CALIBRATED: LazyLock<Calibrated> = LazyLock::new(|| {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
            Calibrated::of(read_session(&root.join("experiments/sarcos-shoulder/session.toml")).unwrap())
        });
        &CALIBRATED
    }

    pub fn of(session: Session) -> Calibrated {
        let solver = LevenbergMarquardt::default();
        let environment = SolveEnvironment::new(&solver, &|_| {});
        let results = calibrate(&session, &EstimatorName::DEFAULT, &environment);
        Calibrated { session, results }
    }

    pub fn recording(&self) -> CalibrationRecording<'_> {
        let Calibrated { session, results } = self;
        CalibrationRecording { id: "test", session, results, table: "the table\n" }
    }

    /// Its recording, read back.
    pub fn read_back(&self) -> ReadBack {
        ReadBack::of(&self.recording().to_rrd().unwrap())
    }
}
