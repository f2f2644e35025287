//! `readings.time`, `.temperature`, `.velocity`, `.direction`: the conditions that models of sensors need.

use gravcal_kinematics::JointKind;
use gravcal_recording::{ConditionColumn, ConditionColumns, ConditionUnit};
use serde::Deserialize;

use super::Context;
use crate::document::{Field, FileError, OneOrMany};

/// A column of all joints, with the unit of its numbers.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct TimeTable {
    column: String,
    unit: Option<String>,
}

/// A column for all joints or a list with one for each; so the units of their numbers.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ConditionTable {
    columns: OneOrMany<String>,
    unit: Option<OneOrMany<String>>,
}

/// A list of columns, one for each joint.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct DirectionTable {
    columns: Vec<String>,
}

/// The four as they stand in `[readings]`.
pub(super) struct Written<'a> {
    pub time: Option<&'a TimeTable>,
    pub temperature: Option<&'a ConditionTable>,
    pub velocity: Option<&'a ConditionTable>,
    pub direction: Option<&'a DirectionTable>,
}

/// What they come to.
pub(super) fn resolve(context: &Context<'_>, written: &Written<'_>) -> Result<ConditionColumns, FileError> {
    let field = |key: &str| Field::new("readings").key(key);
    let time = written.time.map(|table| {
        let unit = unit(context, &field("time"), table.unit.as_deref(), &ConditionUnit::TIME)?;
        Ok::<_, FileError>(ConditionColumn { column: table.column.clone(), unit })
    });
    let temperature = written
        .temperature
        .map(|table| by_joint(context, &field("temperature"), table, |_| &ConditionUnit::TEMPERATURE));
    let velocity = written.velocity.map(|table| {
        by_joint(context, &field("velocity"), table, |joint| match context.robot.chain.joints()[joint].kind {
            JointKind::Revolute => &ConditionUnit::ANGULAR_VELOCITY,
            JointKind::Prismatic => &ConditionUnit::VELOCITY,
        })
    });
    let direction = written.direction.map(|table| {
        context.document.one_each(&field("direction").key("columns"), &table.columns, &context.joint_names).cloned()
    });
    Ok(ConditionColumns {
        time: time.transpose()?,
        temperature: temperature.transpose()?.unwrap_or_default(),
        velocity: velocity.transpose()?.unwrap_or_default(),
        direction: direction.transpose()?.unwrap_or_default(),
    })
}

fn by_joint(
    context: &Context<'_>,
    field: &Field,
    table: &ConditionTable,
    units: impl Fn(usize) -> &'static [ConditionUnit],
) -> Result<Vec<ConditionColumn>, FileError> {
    let columns = context.document.for_each(&field.key("columns"), &table.columns, &context.joint_names)?;
    let for_each = |unit| context.document.for_each(&field.key("unit"), unit, &context.joint_names);
    let written: Option<Vec<String>> = table.unit.as_ref().map(for_each).transpose()?;
    let column = |(joint, column): (usize, String)| {
        let written = written.as_ref().map(|written| written[joint].as_str());
        Ok(ConditionColumn { column, unit: unit(context, field, written, units(joint))? })
    };
    columns.into_iter().enumerate().map(column).collect()
}

fn unit(
    context: &Context<'_>,
    field: &Field,
    written: Option<&str>,
    known: &[ConditionUnit],
) -> Result<ConditionUnit, FileError> {
    known.iter().copied().find(|unit| Some(unit.name) == written).ok_or_else(|| {
        let found = written.map_or("the unit is missing".to_owned(), |unit| format!("the unit `{unit}` does not fit"));
        let names: Vec<&str> = known.iter().map(|unit| unit.name).collect();
        context.document.error(&field.key("unit"), format!("{found}: expected one of {}", names.join(", ")))
    })
}
