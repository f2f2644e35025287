//! A session calibrated as `gravcal calibrate` does it.

use std::path::Path;

use cpu_time::ThreadTime;
use gravcal_calibration::result::EstimatorResult;
use gravcal_calibration::{SolveEnvironment, check_choice};
use gravcal_robot_model::EstimatorName;
use gravcal_session::read_session;
use gravcal_solvers::SolverName;

/// What a user gets.
pub struct Answer {
    /// The joint estimate, or why the session is refused.
    pub result: Result<EstimatorResult, String>,
    /// Processor time of this thread, reading included.
    pub seconds: f64,
}

/// Reads a session and runs the joint estimator with a method. To be called where rayon has but one thread, or the time is not its own.
pub fn calibrate(session: &Path, method: SolverName) -> Answer {
    let began = ThreadTime::now();
    let result = answer(session, method);
    Answer { result, seconds: began.elapsed().as_secs_f64() }
}

fn answer(path: &Path, method: SolverName) -> Result<EstimatorResult, String> {
    let session = read_session(path).map_err(|error| error.to_string())?;
    let (solver, quiet) = (method.build(), |_: &str| {});
    let estimators = [EstimatorName::Joint];
    check_choice(&session, &estimators, solver.as_ref()).map_err(|error| error.to_string())?;
    let results =
        gravcal_calibration::calibrate(&session, &estimators, &SolveEnvironment::new(solver.as_ref(), &quiet));
    results.into_iter().next().ok_or_else(|| "no estimator answered".to_owned())
}
