//! `sensor_models` of each `[[joint]]`, and of `[joints]`: terms beyond gain and bias, and what is known of their parameters.

use gravcal_dynamics::JointKind;
use gravcal_recording::PoseMapping;

use super::context::Context;
use super::joints::{Entry, Said};
use super::knowledge::scaled;
use super::recordings::InMotion;
use crate::document::FileError;
use crate::parameter::Parameter;
use crate::sensors::{DeclaredInFile, Need, SensorModelName, SensorTerms, Site, declare, to_unit_of};
use crate::session::parameters::GIVEN;
use crate::session::{JointKnowledge, KnowledgeKind};

/// The terms of all joints, and their parameters.
pub(super) fn resolve(
    context: &Context<'_>,
    mapping: &PoseMapping,
    motion: &InMotion,
    joints: &[JointKnowledge],
    said: &[Said<'_>],
) -> Result<(SensorTerms, Vec<Parameter>), FileError> {
    let kinds: Vec<JointKind> = context.robot.chain.joints().iter().map(|joint| joint.kind).collect();
    let (mut terms, mut parameters) = (Vec::new(), Vec::new());
    let mut order: Vec<usize> = (0..said.len()).collect();
    order.sort_by_key(|joint| said[*joint].place().unwrap_or(usize::MAX));
    for joint in order {
        let Some(Entry { value: models, field, of_all, .. }) = said[joint].sensor_models() else { continue };
        let site = Site::new(joint, &context.joint_names, &kinds, &joints[joint]);
        // What is said of all joints is of those that have such a sensor.
        let passed_over = |model: SensorModelName| of_all && !model.is_of_position() && !site.reads_torque;
        let knows = |need| knows(mapping, motion, need);
        for found in declare(context.document, &field.key("sensor_models"), &site, models, knows, passed_over)? {
            parameters.push(with_knowledge(context, &found)?);
            terms.push(found.term);
        }
    }
    Ok((SensorTerms::new(terms), parameters))
}

/// Poses found in recordings in motion have a time and a direction, those of sweeps a velocity.
fn knows(mapping: &PoseMapping, motion: &InMotion, need: Need) -> bool {
    let (conditions, found) = (&mapping.conditions, motion.is_any());
    match need {
        Need::Time => found || conditions.time.is_some(),
        Need::Temperature => !conditions.temperature.is_empty(),
        Need::Velocity => motion.sweeps.is_some() || conditions.velocity.is_known(),
        Need::Direction => found || !conditions.direction.is_empty() || conditions.velocity.is_known(),
    }
}

fn with_knowledge(
    context: &Context<'_>,
    found: &DeclaredInFile<'_, super::knowledge::KnowledgeTable>,
) -> Result<Parameter, FileError> {
    let parameter = found.parameter.clone();
    let Some(table) = found.said else { return Ok(parameter) };
    let wrong = |message| context.document.error(&found.field.key("unit"), message);
    let factor = to_unit_of(&parameter.unit, table.unit()).map_err(wrong)?;
    let knowledge = scaled(table.knowledge(context.document, &found.field)?, factor);
    let held = (knowledge.kind == KnowledgeKind::Fixed).then_some(GIVEN);
    Ok(Parameter { knowledge, held, ..parameter })
}
