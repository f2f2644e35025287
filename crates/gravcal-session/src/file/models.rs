//! `sensor_models` of each `[[joint]]`, and of `[joints]`: terms beyond gain and bias, and what is known of their parameters.

use gravcal_dynamics::JointKind;
use gravcal_recording::PoseMapping;
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::{Parameter, same_in};
use gravcal_robot_model::sensors::{Need, SensorModel, SensorTerms, Side, Site};
use gravcal_robot_model::session::parameters::GIVEN;
use gravcal_robot_model::session::{JointPriors, PriorKind};

use super::context::Context;
use super::joints::{Entry, Said};
use super::parameter_prior::{ParameterPriorTable, scaled};
use super::recordings::InMotion;
use crate::document::FileError;
use crate::sensor_models::{ModelContext, ParameterInFile, declare, to_unit_of};

/// The terms of all joints, and their parameters.
pub(super) fn resolve(
    context: &Context<'_>,
    registry: &Registry,
    mapping: &PoseMapping,
    motion: &InMotion,
    joints: &[JointPriors],
    said: &[Said<'_>],
) -> Result<(SensorTerms, Vec<Parameter>), FileError> {
    let kinds: Vec<JointKind> = context.robot.chain.joints().iter().map(|joint| joint.kind).collect();
    let (mut terms, mut parameters) = (SensorTerms::default(), Vec::new());
    let mut order: Vec<usize> = (0..said.len()).collect();
    order.sort_by_key(|joint| said[*joint].place().unwrap_or(usize::MAX));
    for joint in order {
        let Some(Entry { value: models, field, of_all, .. }) = said[joint].sensor_models() else { continue };
        let site = Site::new(joint, &context.joint_names, &kinds, &joints[joint])
            .with_further_columns(&mapping.conditions.further);
        // What is said of all joints is of those that have such a sensor.
        let passed_over = |model: &dyn SensorModel| of_all && model.side() == Side::Torque && !site.reads_torque();
        let knows = |need| knows(mapping, motion, need);
        let models_context = ModelContext { document: context.document, registry, models: field.key("sensor_models") };
        for found in declare(&models_context, &site, models, knows, passed_over)? {
            for parameter in found.parameters {
                let owner = context.joint_names[joint];
                let parameter = if parameter.parameter.owner == owner {
                    with_prior(context, parameter)?
                } else {
                    shared(context, &parameters, parameter)?
                };
                parameters.push(parameter);
            }
            terms.extend([found.term]);
        }
    }
    Ok((terms, parameters))
}

/// A parameter that sensors share: where it was declared before, the same as there.
fn shared(
    context: &Context<'_>,
    known: &[Parameter],
    found: ParameterInFile<'_, ParameterPriorTable>,
) -> Result<Parameter, FileError> {
    let place = check_shared(context, known, &found)?;
    match place {
        None => with_prior(context, found),
        Some(place) => Ok(Parameter { same_as: Some(place), ..known[place].clone() }),
    }
}

/// The place of the parameter that a shared one is the same as.
pub(super) fn check_shared(
    context: &Context<'_>,
    known: &[Parameter],
    found: &ParameterInFile<'_, ParameterPriorTable>,
) -> Result<Option<usize>, FileError> {
    let refuse = |message: String| Err(context.document.error(&found.field, message));
    let owner = found.parameter.owner.as_str();
    if owner == "gravity" {
        return refuse("`gravity` is what the calibration finds: share the parameter under another name".to_owned());
    }
    if context.joint_names.contains(&owner) || context.link_names.contains(&owner) {
        return refuse(format!("`{owner}` is a joint or link of the robot: share the parameter under another name"));
    }
    let place = same_in(known, &found.parameter).map_err(|message| context.document.error(&found.field, message))?;
    match (place, found.said) {
        (Some(_), Some(_)) => {
            refuse(format!("what is known of {} is said where it stands first: delete this", found.parameter.name()))
        }
        _ => Ok(place),
    }
}

/// Poses found in recordings in motion have a time and a direction, those of sweeps and windows a velocity.
fn knows(mapping: &PoseMapping, motion: &InMotion, need: Need) -> bool {
    let (conditions, found) = (&mapping.conditions, motion.is_any());
    match need {
        Need::Time => found || conditions.time.is_some(),
        Need::Temperature => !conditions.temperature.is_empty(),
        Need::Velocity => motion.sweeps.is_some() || motion.windows.is_some() || conditions.velocity.is_known(),
        Need::Presliding => motion.windows.is_some(),
        Need::Direction => found || !conditions.direction.is_empty() || conditions.velocity.is_known(),
    }
}

pub(super) fn with_prior(
    context: &Context<'_>,
    ParameterInFile { parameter, field, said }: ParameterInFile<'_, ParameterPriorTable>,
) -> Result<Parameter, FileError> {
    let Some(table) = said else { return Ok(parameter) };
    let wrong = |message| context.document.error(&field.key("unit"), message);
    let factor = to_unit_of(&parameter.unit, table.unit()).map_err(wrong)?;
    let prior = scaled(table.prior(context.document, &field)?, factor);
    let fixed = (prior.kind == PriorKind::Fixed).then_some(GIVEN);
    Ok(Parameter { prior, fixed, ..parameter })
}
