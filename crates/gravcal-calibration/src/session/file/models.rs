//! `sensor_models` of each `[[joint]]`: terms beyond gain and bias, and what is known of their parameters.

use gravcal_kinematics::JointKind;
use gravcal_recording::PoseMapping;

use super::Context;
use super::joints::JointTable;
use super::knowledge::scaled;
use super::recordings::InMotion;
use crate::document::{Field, FileError};
use crate::parameter::Parameter;
use crate::sensors::{DeclaredInFile, Need, SensorTerms, Site, declare, to_unit_of};
use crate::session::parameters::GIVEN;
use crate::session::{JointKnowledge, KnowledgeKind};

/// The terms of all joints, and their parameters.
pub(super) fn resolve(
    context: &Context<'_>,
    mapping: &PoseMapping,
    motion: &InMotion,
    joints: &[JointKnowledge],
    tables: &[JointTable],
) -> Result<(SensorTerms, Vec<Parameter>), FileError> {
    let kinds: Vec<JointKind> = context.robot.chain.joints().iter().map(|joint| joint.kind).collect();
    let (mut terms, mut parameters) = (Vec::new(), Vec::new());
    for (index, table) in tables.iter().enumerate() {
        let Some(joint) = context.joint_names.iter().position(|name| *name == table.name) else { continue };
        let site = Site::new(joint, &context.joint_names, &kinds, &joints[joint]);
        let field = Field::new("joint").at(index);
        for found in
            declare(context.document, &field, &site, &table.sensor_models, |need| knows(mapping, motion, need))?
        {
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
