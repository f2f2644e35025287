//! `readings.time`, `.temperature`, `.velocity`, `.acceleration`, `.direction`, `.further`: the conditions that models of sensors and the
//! choice of readings need.

use std::collections::BTreeMap;

use gravcal_dynamics::JointKind;
use gravcal_recording::{ConditionColumn, ConditionColumns, ConditionUnit, FurtherColumn, MotionSource, Slope};
use serde::Deserialize;

use super::context::Context;
use crate::document::{Field, FileError, OneOrMany};

/// A column of all joints, with the unit of its numbers.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct TimeTable {
    /// The column.
    ///
    /// Example: `column = "t"`
    column: String,
    /// s, ms, µs, ns, min, h, or `"ISO 8601"` where cells are dates with times.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "ms"`
    unit: Option<String>,
}

/// A column for all joints or a list with one for each; so the units of their numbers.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ConditionTable {
    /// One column for all joints, or a list.
    ///
    /// Example: `columns = "T"`
    columns: OneOrMany<String>,
    /// `"degC"` or `"K"`.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "degC"`
    unit: Option<OneOrMany<String>>,
}

/// Columns as above, or that the derivative is taken numerically.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct MotionTable {
    /// One column for each joint. Give this or `slope_over_s`.
    ///
    /// Example: `columns = ["dq1", "dq2"]`
    columns: Option<OneOrMany<String>>,
    /// Unit of the columns, such as `"deg/s"`, or `"rad/s²"` of accelerations.
    ///
    /// Unit: none.
    /// Example: `unit = "deg/s"`
    unit: Option<OneOrMany<String>>,
    /// Width in time of the straight line whose slope is taken. Needs `time`.
    ///
    /// Example: `slope_over_s = 0.1`
    slope_over_s: Option<f64>,
}

/// A list of columns, one for each joint.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct DirectionTable {
    /// One column for each joint.
    ///
    /// Example: `columns = ["d1", "d2"]`
    columns: Vec<String>,
}

/// Those as they stand in `[readings]`.
pub(super) struct Written<'a> {
    pub time: Option<&'a TimeTable>,
    pub temperature: Option<&'a ConditionTable>,
    pub velocity: Option<&'a MotionTable>,
    pub acceleration: Option<&'a MotionTable>,
    pub direction: Option<&'a DirectionTable>,
    /// Names of columns, by what models call them.
    pub further: &'a BTreeMap<String, String>,
}

/// What they come to. One column of temperatures for all joints is also that of each of so many instruments, whose follow those of
/// the joints.
pub(super) fn resolve(
    context: &Context<'_>,
    written: &Written<'_>,
    instruments: usize,
) -> Result<ConditionColumns, FileError> {
    let field = |key: &str| Field::new("readings").key(key);
    let time = written.time.map(|table| {
        let unit = unit(context, &field("time"), table.unit.as_deref(), &ConditionUnit::TIME)?;
        Ok::<_, FileError>(ConditionColumn { column: table.column.clone(), unit })
    });
    let temperature = written.temperature.map(|table| {
        let units = |_| &ConditionUnit::TEMPERATURE[..];
        let mut columns = by_joint(context, &field("temperature"), &table.columns, table.unit.as_ref(), units)?;
        if let (OneOrMany::One(column), None | Some(OneOrMany::One(_))) = (&table.columns, &table.unit) {
            let written = table.unit.as_ref().and_then(|unit| unit.as_slice().first()).map(String::as_str);
            let unit = unit(context, &field("temperature"), written, &ConditionUnit::TEMPERATURE)?;
            columns.resize(columns.len() + instruments, ConditionColumn { column: column.clone(), unit });
        }
        Ok::<_, FileError>(columns)
    });
    let velocity = written.velocity.map(|table| motion(context, &field("velocity"), table, speed_units));
    let acceleration =
        written.acceleration.map(|table| motion(context, &field("acceleration"), table, acceleration_units));
    let direction = written.direction.map(|table| {
        context.document.one_each(&field("direction").key("columns"), &table.columns, &context.joint_names).cloned()
    });
    Ok(ConditionColumns {
        time: time.transpose()?,
        temperature: temperature.transpose()?.unwrap_or_default(),
        velocity: velocity.transpose()?.unwrap_or_default(),
        acceleration: acceleration.transpose()?.unwrap_or_default(),
        direction: direction.transpose()?.unwrap_or_default(),
        further: written.further.iter().map(further).collect(),
    })
}

fn further((name, column): (&String, &String)) -> FurtherColumn {
    FurtherColumn { name: name.clone(), column: column.clone(), may_be_empty: false }
}

/// Units in which the speed of a joint may be given.
pub(super) fn speed_units(kind: JointKind) -> &'static [ConditionUnit] {
    match kind {
        JointKind::Revolute => &ConditionUnit::ANGULAR_VELOCITY,
        JointKind::Prismatic => &ConditionUnit::VELOCITY,
    }
}

/// Units in which the acceleration of a joint may be given.
pub(super) fn acceleration_units(kind: JointKind) -> &'static [ConditionUnit] {
    match kind {
        JointKind::Revolute => &ConditionUnit::ANGULAR_ACCELERATION,
        JointKind::Prismatic => &ConditionUnit::ACCELERATION,
    }
}

fn motion(
    context: &Context<'_>,
    field: &Field,
    table: &MotionTable,
    units: impl Fn(JointKind) -> &'static [ConditionUnit],
) -> Result<MotionSource, FileError> {
    match (&table.columns, table.slope_over_s) {
        (Some(columns), None) => {
            Ok(MotionSource::Columns(by_joint(context, field, columns, table.unit.as_ref(), units)?))
        }
        (None, Some(window)) => {
            if table.unit.is_some() {
                let message = "a slope over time has SI units: delete this";
                return Err(context.document.error(&field.key("unit"), message));
            }
            Ok(MotionSource::Slope(Slope { window }))
        }
        _ => {
            let message = "expected columns with their unit, or slope_over_s, the time over which the slope is taken";
            Err(context.document.error(field, message))
        }
    }
}

fn by_joint(
    context: &Context<'_>,
    field: &Field,
    columns: &OneOrMany<String>,
    unit: Option<&OneOrMany<String>>,
    units: impl Fn(JointKind) -> &'static [ConditionUnit],
) -> Result<Vec<ConditionColumn>, FileError> {
    let columns = context.document.for_each(&field.key("columns"), columns, &context.joint_names)?;
    let units = units_of_joints(context, field, unit, units)?;
    Ok(columns.into_iter().zip(units).map(|(column, unit)| ConditionColumn { column, unit }).collect())
}

/// The unit of each joint's number; `field` is the table in which the unit stands.
pub(super) fn units_of_joints(
    context: &Context<'_>,
    field: &Field,
    written: Option<&OneOrMany<String>>,
    units: impl Fn(JointKind) -> &'static [ConditionUnit],
) -> Result<Vec<ConditionUnit>, FileError> {
    let for_each = |unit| context.document.for_each(&field.key("unit"), unit, &context.joint_names);
    let written: Option<Vec<String>> = written.map(for_each).transpose()?;
    let joints = context.robot.chain.joints().iter().enumerate();
    let of = |(joint, kind): (usize, JointKind)| {
        unit(context, field, written.as_ref().map(|written| written[joint].as_str()), units(kind))
    };
    joints.map(|(index, joint)| of((index, joint.kind))).collect()
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
