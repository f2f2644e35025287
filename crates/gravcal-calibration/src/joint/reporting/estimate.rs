//! The joint estimator from readings to a result, for a reader or for batches.

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::method::conclude;
use crate::joint::problem::JointProblem;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::conclusion::Conclusion;
use crate::joint::reporting::held_out::{fit_with_held_out, fit_without_held_out};
use crate::joint::reporting::report::report;
use crate::joint::select::{Signals, select};
use crate::joint::variables::State;
use crate::judgement::TestsWanted;
use crate::result::{Brief, EstimatorResult};

/// Solves the joint problem, from `known` values (the sequential estimator's) if they start it better than the
/// nominal ones.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub fn estimate_jointly(
    session: &Session,
    signals: Signals,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let name = match signals {
        Signals::All => "joint",
        Signals::PaperSteps => "joint-paper-signals",
    };
    estimate(session, name, &select(session, signals), known, environment)
}

/// Solves the joint problem of these readings, in the order in which they are to enter, and tells it under `name`.
///
/// # Errors
/// As [`estimate_jointly`].
pub fn estimate(
    session: &Session,
    name: &str,
    readings: &MeasurementSet,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let conclusion = conclude(session, readings, known, TestsWanted::All, environment)?;
    let Answer { solved, mistakes, .. } = &conclusion.answer;
    // A second fit of a session with a mistake would take long, and tell nothing.
    let fit = match mistakes.found.is_some() && session.validation.is_empty() {
        false => fit_with_held_out(session, solved, environment)?,
        true => fit_without_held_out(session, solved, "not made, as the session has a mistake")?,
    };
    report(session, name, conclusion, fit, environment)
}

/// The same answer without what only a reader needs: no prediction of poses that were held out, no moments, no tests of sensor
/// models, nor of residuals where nothing is named. For batches.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub fn estimate_briefly(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<Brief, EstimateError> {
    let conclusion = conclude(session, readings, known, TestsWanted::WhereNamed, environment)?;
    let Conclusion { answer, verdict, termination, .. } = conclusion;
    let Answer { solved, gravity, parameters, .. } = answer;
    let iterations = solved.estimate.iterations.len().saturating_sub(1);
    Ok(Brief { verdict, termination, iterations, gravity, parameters })
}

/// The joint problem at nominal values, with its constraints: what a solver must be able to take.
pub(crate) fn build_at_nominal(session: &Session) -> Result<JointProblem, EstimateError> {
    Ok(build_with_constraints(session, &select(session, Signals::All), &State::nominal(session))?)
}
