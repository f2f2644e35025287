//! What a model of an arm in motion gains over smaller ones, on readings that neither has seen: gravity and biases alone, then with friction.
//!
//! A smaller model is fitted to the same readings with the same noise, from the solution of the whole. Windows count as poses that stand where the
//! arm is on the mean; coefficients of friction are zero where it has none. Gains of sensors and zeros of position sensors are those of the
//! solution: they would make up for what is missing, and no fit would end. What explains readings that were fitted may be chance: only what predicts
//! others is gained.

use std::collections::BTreeSet;

use gravcal_estimation::BlockId;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::sensors::friction::{COULOMB, PRESLIDING, VISCOUS};
use gravcal_robot_model::session::Session;

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::reporting::held_out::{fixed_alike, of_validation, predict, stretches};
use crate::joint::solved::Solved;
use crate::joint::solving::fit::fit;
use crate::joint::variables::State;
use crate::result::{HeldOut, SmallerModel, SmallerModelKind};

/// The smaller models of a session with windows that converge, the smallest first.
///
/// # Errors
/// Where a residual cannot be evaluated.
pub(in crate::joint) fn smaller_models(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<SmallerModel>, EstimateError> {
    let (standing, friction, unseen) = (standing(session), friction(session), stretches(session, solved.readings()));
    let kinds = [SmallerModelKind::Gravity, SmallerModelKind::GravityAndFriction];
    let mut found = Vec::new();
    // Where sensors have no friction, both are one.
    for kind in kinds.into_iter().take(if friction.is_empty() { 1 } else { 2 }) {
        let none: &[usize] = if kind == SmallerModelKind::Gravity { &friction } else { &[] };
        let held_out = prediction(&standing, solved, (&unseen, none), environment)?;
        found.extend(held_out.map(|held_out| SmallerModel { kind, held_out }));
    }
    Ok(found)
}

/// The session with an arm that stands in each window.
fn standing(session: &Session) -> Session {
    let mut standing = session.clone();
    standing.poses.iter_mut().chain(&mut standing.validation).for_each(|pose| pose.course = None);
    standing
}

/// Places of the coefficients of friction among the further parameters.
fn friction(session: &Session) -> Vec<usize> {
    let models = session.terms.models().filter(|model| [COULOMB, VISCOUS, PRESLIDING].contains(&model.name));
    models.flat_map(|model| model.places().collect::<Vec<_>>()).collect()
}

/// How well a session without some terms predicts what was held out; nothing where it does not converge. `unseen`: the poses that are, where
/// no table is; `none`: places of what is zero.
fn prediction(
    session: &Session,
    solved: &Solved,
    (unseen, none): (&BTreeSet<usize>, &[usize]),
    environment: &SolveEnvironment<'_>,
) -> Result<Option<HeldOut>, EstimateError> {
    // What displaced joints, and such as bend, do in motion is not what they do to an arm that stands.
    let all = MeasurementSet { displaced: None, bending: None, ..solved.readings().clone() };
    let part = |held_out: bool| all.only(|id| unseen.contains(&id.pose) == held_out);
    let readings = if session.validation.is_empty() { part(false) } else { all.clone() };
    let mut start = solved.state(&State::nominal(session));
    none.iter().for_each(|place| start.further[*place] = 0.0);
    let Ok(built) = build_with_constraints(session, &readings, &start) else { return Ok(None) };
    let mut built = fixed_alike(solved, built)?;
    let zeros = none.iter().map(|place| built.variables.further[*place]);
    let scales =
        built.variables.sensors.iter().flat_map(|[gain, _, position_gain, offset]| [*gain, *position_gain, *offset]);
    let given: Vec<BlockId> = zeros.chain(scales).collect();
    built.problem = built.problem.with_fixed(&given, "as the whole model has it");
    // What a smaller model cannot do takes nothing from the answer.
    let Ok((built, estimate)) = fit(&built, environment) else { return Ok(None) };
    if !estimate.termination.converged() {
        return Ok(None);
    }
    let found = built.variables.state(&estimate.values, &start);
    match session.validation.is_empty() {
        true => predict(session, &part(true), &found),
        false => of_validation(session, &all, found),
    }
}
