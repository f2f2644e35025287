//! Runs what is missing of a study.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use gravcal_calibration::sequential::Plan;
use gravcal_calibration::{UnsuitableChoice, check_choice};
use gravcal_estimation::Solver;
use gravcal_robot_model::EstimatorName;
use rayon::prelude::*;

use super::BatchError;
use super::folder::StudyFolder;
use super::part::Part;
use super::trial::{self, Took, Which, bounds_of};
use crate::bounds::Bounds;
use crate::plan::{Study, reported};

/// A method by its name.
pub type NamedSolver = (String, Box<dyn Solver>);

/// What a run is handed.
pub struct Helpers<'a> {
    /// The methods by their names.
    pub solvers: &'a [NamedSolver],
    /// A clock, s; nothing but the table of times depends on it.
    pub clock: &'a (dyn Fn() -> f64 + Sync),
    /// Told how many trials are done, and how many there are.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
    /// Set by whoever wants the run to stop: parts that are not done are then given up.
    pub stop: &'a AtomicBool,
}

/// A share of the parts: every `of`-th, from `number` (counted from 1) on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which one.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All parts of the shard are done.
    Done {
        /// Trials that this run did.
        trials: u64,
    },
    /// Stopped before; what is done stays.
    Stopped,
}

/// Runs the parts of a shard that the folder does not have yet, in parallel.
///
/// # Errors
/// A part cannot be written. A trial that fails is a row.
pub fn run(study: &Study, folder: &StudyFolder, shard: Shard, helpers: &Helpers<'_>) -> Result<Ended, BatchError> {
    if folder.is_complete() {
        return Ok(Ended::Done { trials: 0 });
    }
    let done = folder.done()?;
    let parts: Vec<Part> = folder.manifest.parts();
    let own = parts.into_iter().filter(|part| part.number % shard.of == shard.number - 1);
    let missing: Vec<Part> = own.filter(|part| !done.contains(&part.number)).collect();
    let total: u64 = missing.iter().map(|part| part.trials.end - part.trials.start).sum();
    let bounds: Vec<Option<Bounds>> = (0..study.points.len()).map(|point| bounds_of_point(study, point)).collect();
    let counted = AtomicU64::new(0);
    let report = || (helpers.progress)(counted.fetch_add(1, Ordering::Relaxed) + 1, total);
    (helpers.progress)(0, total);
    missing
        .par_iter()
        .try_for_each(|part| run_part(study, folder, part, bounds[part.point].as_ref(), helpers, &report))?;
    Ok(if helpers.stop.load(Ordering::Relaxed) { Ended::Stopped } else { Ended::Done { trials: total } })
}

fn run_part(
    study: &Study,
    folder: &StudyFolder,
    part: &Part,
    bounds: Option<&Bounds>,
    helpers: &Helpers<'_>,
    report: &dyn Fn(),
) -> Result<(), BatchError> {
    let mut rows = Vec::new();
    let mut all = Took::default();
    for trial in part.trials.clone() {
        if helpers.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        let (of_trial, took) = trial::run(Which { study, point: part.point, trial, bounds }, helpers);
        rows.extend(of_trial);
        all.simulating += took.simulating;
        all.calibrating += took.calibrating;
        report();
    }
    folder.write(part, &rows, all)
}

/// The bounds of a point whose trials differ in their noise only. Where there are none, trials say why.
fn bounds_of_point(study: &Study, point: usize) -> Option<Bounds> {
    let point = &study.points[point];
    if point.bound_varies() {
        return None;
    }
    bounds_of(study, &point.instance(0, &study.quantities).ok()?).ok()
}

/// Sees to it that each estimator and solver can take a first trial of each point.
///
/// # Errors
/// Names the point, and what cannot be.
pub fn check(study: &Study, solvers: &[NamedSolver]) -> Result<(), BatchError> {
    for point in &study.points {
        let Ok(instance) = point.instance(0, &study.quantities) else { continue };
        let reported = reported(&study.axes, &point.places);
        let at = || if reported.is_empty() { String::new() } else { format!("at {reported}: ") };
        let estimators: Vec<EstimatorName> = study.estimators.iter().map(|compared| compared.estimator()).collect();
        for (_, solver) in solvers {
            check_choice(&instance.session, &estimators, solver.as_ref())
                .map_err(|error| BatchError::Choice { point: at(), error })?;
        }
        // Beside others the steps may have nothing to do; a column of a study may not.
        let steps = estimators.contains(&EstimatorName::Sequential);
        if steps && Plan::new(&instance.session).sweeps.is_empty() {
            let error = UnsuitableChoice::NoSweeps(EstimatorName::Sequential);
            return Err(BatchError::Choice { point: at(), error });
        }
    }
    Ok(())
}
