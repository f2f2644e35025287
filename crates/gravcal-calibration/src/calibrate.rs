//! Runs the estimators of a session.

use gravcal_estimation::{Solver, Unsupported};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::EstimatorName;
use gravcal_robot_model::session::Session;
use thiserror::Error;

use crate::joint::{
    EstimateError, MeasurementSet, Signals, State, build_at_nominal, estimate, estimate_briefly, pose_by_pose, select,
    step_by_step, why_not_by_groups,
};
use crate::plan::Plan;
use crate::result::{Brief, EstimatorResult, ParameterResult, Verdict};
use crate::sequential::{SequentialValues, report_steps, report_steps_briefly, run_steps};

/// What is chosen does not go with the session.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UnsuitableChoice {
    /// The joint problem is not for the solver.
    #[error(transparent)]
    Solver(#[from] Unsupported),
    /// Constraints, and no estimator that obeys them.
    #[error(
        "only the joint estimators obey constraints, and none of them is chosen: choose `joint`, or drop the constraints"
    )]
    ConstraintsIgnored,
    /// Knowledge from an earlier calibration, and no estimator that heeds it.
    #[error(
        "only the joint estimators heed an earlier calibration, and none of them is chosen: choose `joint`, or drop [prior]"
    )]
    EarlierIgnored,
    /// Residuals of one's own, and no estimator that heeds them.
    #[error(
        "only the joint estimators heed residuals, and none of them is chosen: choose `joint`, or drop each [[residual]]"
    )]
    ResidualsIgnored,
    /// Estimators that read as the paper's steps do, for a body without joints.
    #[error(
        "`{0}` follows the paper's steps along the joints of a robot, and the session has none: choose `joint` (--estimator joint, or estimators = [\"joint\"])"
    )]
    NoJoints(EstimatorName),
    /// Estimators that read as the paper's steps do, for a robot that is no serial chain.
    #[error(
        "`{0}` follows the paper's steps along one serial chain, and this robot branches or has joints that mimic others: \
         choose `joint` (--estimator joint, or estimators = [\"joint\"])"
    )]
    NoSerialChain(EstimatorName),
    /// Estimators that read as the paper's steps do, where these have nothing to read.
    #[error(
        "`{0}` reads what the paper's steps read, and the session has no sweeps for them: choose `joint` (--estimator joint, or estimators = [\"joint\"])"
    )]
    NoSweeps(EstimatorName),
    /// Readings that cannot enter group by group.
    #[error("`{estimator}` takes readings group by group, each group once, and {why}: choose `joint`, or drop it")]
    NotByGroups {
        /// Which estimator.
        estimator: EstimatorName,
        /// What of the session stands against it.
        why: &'static str,
    },
}

/// Whether estimators and solver can do what the session asks.
///
/// # Errors
/// Says in words why not.
pub fn check_choice(
    session: &Session,
    estimators: &[EstimatorName],
    solver: &dyn Solver,
) -> Result<(), UnsuitableChoice> {
    if let (true, Some(name)) = (session.joints.is_empty(), in_vain_on_branches(estimators)) {
        return Err(UnsuitableChoice::NoJoints(name));
    }
    if let (false, Some(name)) = (session.robot.chain.is_serial(), in_vain_on_branches(estimators)) {
        return Err(UnsuitableChoice::NoSerialChain(name));
    }
    if let Some(name) = reading_as_steps(estimators)
        && Plan::new(session).readings().is_empty()
    {
        return Err(UnsuitableChoice::NoSweeps(name));
    }
    if estimators.iter().all(|name| *name == EstimatorName::Sequential) {
        return match session {
            Session { constraints, .. } if !constraints.is_empty() => Err(UnsuitableChoice::ConstraintsIgnored),
            Session { earlier: Some(_), .. } => Err(UnsuitableChoice::EarlierIgnored),
            Session { residuals, .. } if !residuals.is_empty() => Err(UnsuitableChoice::ResidualsIgnored),
            _ => Ok(()),
        };
    }
    match build_at_nominal(session).and_then(|built| Ok(built.with_loss(session.loss)?)) {
        Ok(built) => {
            let by_groups = [EstimatorName::SequentialWithCovariance, EstimatorName::Recursive];
            let against = why_not_by_groups(session, &built);
            match (by_groups.into_iter().find(|name| estimators.contains(name)), against) {
                (Some(estimator), Some(why)) => Err(UnsuitableChoice::NotByGroups { estimator, why }),
                _ => Ok(solver.check(&built.problem)?),
            }
        }
        Err(_) => Ok(()), // the estimator will say why there is no problem to take
    }
}

/// The estimator, if there is one, that is chosen in vain for a robot that is no serial chain. The steps beside the joint
/// estimator are not, as they are where nothing is chosen: they say themselves that they have nothing to do.
fn in_vain_on_branches(estimators: &[EstimatorName]) -> Option<EstimatorName> {
    let steps = estimators.first().filter(|_| !estimators.contains(&EstimatorName::Joint));
    reading_as_steps(estimators).or(steps.copied())
}

/// The first estimator that reads only what the paper's steps read, and is none of them.
fn reading_as_steps(estimators: &[EstimatorName]) -> Option<EstimatorName> {
    let as_steps = [EstimatorName::JointPaperSignals, EstimatorName::SequentialWithCovariance];
    estimators.iter().find(|name| as_steps.contains(name)).copied()
}

/// Runs the estimators in the given order. The sequential steps, where they reach gravity, also offer the joint
/// estimators a start. An estimator that has no answer at all has failed, and says why; it takes no other with it.
#[must_use]
pub fn calibrate(
    session: &Session,
    estimators: &[EstimatorName],
    environment: &SolveEnvironment<'_>,
) -> Vec<EstimatorResult> {
    let steps = run_steps(session, &Plan::new(session), environment);
    let answer = |estimator: EstimatorName| match task_of(estimator, session, &steps, environment)? {
        None => report_steps(session, &steps, environment),
        Some(Task { readings, known }) => estimate(session, estimator.as_str(), &readings, known.as_ref(), environment),
    };
    let each = estimators.iter().map(|name| answer(*name).unwrap_or_else(|error| failed(session, *name, &error)));
    each.collect()
}

/// The same of sensors and gravity alone: what batches need.
///
/// # Errors
/// One for each estimator that has no answer at all.
pub fn calibrate_briefly(
    session: &Session,
    estimators: &[EstimatorName],
    environment: &SolveEnvironment<'_>,
) -> Vec<Result<Brief, EstimateError>> {
    let steps = run_steps(session, &Plan::new(session), environment);
    let brief = |estimator: &EstimatorName| match task_of(*estimator, session, &steps, environment)? {
        None => Ok(report_steps_briefly(session, &steps)),
        Some(Task { readings, known }) => estimate_briefly(session, &readings, known.as_ref(), environment),
    };
    estimators.iter().map(brief).collect()
}

/// What an estimator of the joint problem reads, and from where it may start.
struct Task {
    readings: MeasurementSet,
    known: Option<State>,
}

/// The readings of the joint problem in the order in which they enter; nothing for the steps, which have no such problem.
fn task_of(
    estimator: EstimatorName,
    session: &Session,
    steps: &SequentialValues,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Task>, EstimateError> {
    let readings = match estimator {
        EstimatorName::Sequential => return Ok(None),
        EstimatorName::Joint => select(session, Signals::All),
        EstimatorName::JointPaperSignals => select(session, Signals::PaperSteps),
        EstimatorName::SequentialWithCovariance => step_by_step(session),
        // The sequential steps have seen all poses.
        EstimatorName::Recursive => {
            return Ok(Some(Task { readings: pose_by_pose(session, environment)?, known: None }));
        }
    };
    Ok(Some(Task { readings, known: steps.as_start(session) }))
}

/// An answer without any value.
fn failed(session: &Session, estimator: EstimatorName, error: &EstimateError) -> EstimatorResult {
    let blank = session.parameters().into_iter().map(|id| ParameterResult::blank(session, id));
    let parameters = blank.map(|parameter| ParameterResult { determined: false, ..parameter }).collect();
    EstimatorResult { parameters, ..EstimatorResult::blank(estimator.to_string(), Verdict::Failed, error.to_string()) }
}
