//! `[readings]`: which column of the tables is which reading, in which unit, and how noisy.

use gravcal_recording::{MappingError, PoseMapping, PositionColumn, ReadingColumn, TorqueUnit};
use serde::Deserialize;

use super::Context;
use super::conditions::{self, ConditionTable, DirectionTable, TimeTable};
use crate::document::{Field, FileError, OneOrMany};
use crate::session::units::{self, UnitError};

/// `[readings]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ReadingsTable {
    position: PositionTable,
    torque: Option<TorqueTable>,
    time: Option<TimeTable>,
    temperature: Option<ConditionTable>,
    velocity: Option<ConditionTable>,
    direction: Option<DirectionTable>,
    sweep_column: Option<String>,
    #[serde(default)]
    merge_repeated_rows: bool,
}

/// `readings.position`. Units are mandatory; they are read as optional so that the error can say which fit.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct PositionTable {
    columns: Vec<String>,
    unit: Option<OneOrMany<String>>,
    std: Option<OneOrMany<f64>>,
}

/// `readings.torque`. In lists of columns, `""` means that there is none for the joint.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct TorqueTable {
    columns: Vec<String>,
    unit: Option<OneOrMany<String>>,
    std: Option<OneOrMany<f64>>,
    count: Option<OneOrMany<f64>>,
    std_columns: Option<Vec<String>>,
    count_columns: Option<Vec<String>>,
    usable_columns: Option<Vec<String>>,
}

/// What `[readings]` comes to.
pub(super) fn mapping(context: &Context<'_>, table: &ReadingsTable) -> Result<PoseMapping, FileError> {
    let conditions = conditions::Written {
        time: table.time.as_ref(),
        temperature: table.temperature.as_ref(),
        velocity: table.velocity.as_ref(),
        direction: table.direction.as_ref(),
    };
    let mapping = PoseMapping {
        positions: positions(context, &table.position)?,
        torques: torques(context, table.torque.as_ref())?,
        sweep_column: table.sweep_column.clone(),
        merge_repeated: table.merge_repeated_rows,
        conditions: conditions::resolve(context, &conditions)?,
    };
    mapping.check().map_err(|error| context.document.error(&field_of(&error), error))?;
    Ok(mapping)
}

/// Standard deviation of each joint's position reading in its inside unit; 0 where it is taken as exact.
pub(super) fn position_std(context: &Context<'_>, table: &ReadingsTable) -> Result<Vec<f64>, FileError> {
    let (field, units) = (position().key("std"), positions(context, &table.position)?);
    let Some(written) = &table.position.std else { return Ok(vec![0.0; units.len()]) };
    let written = context.document.for_each(&field, written, &context.joint_names)?;
    let inside = |(std, column): (&f64, &PositionColumn)| match std {
        0.0.. => Ok(std * column.unit.to_si()),
        _ => Err(context.document.error(&field, format!("{std} is no standard deviation: expected 0 or more"))),
    };
    written.iter().zip(&units).map(inside).collect()
}

fn position() -> Field {
    Field::new("readings").key("position")
}

fn torque() -> Field {
    Field::new("readings").key("torque")
}

/// The field to which a contradiction is laid.
fn field_of(error: &MappingError) -> Field {
    match error {
        MappingError::BadStd { .. } => torque().key("std"),
        MappingError::BadCount { .. } => torque().key("count"),
        MappingError::CountWithoutStd { .. } => torque(),
        _ => Field::new("readings"),
    }
}

fn positions(context: &Context<'_>, table: &PositionTable) -> Result<Vec<PositionColumn>, FileError> {
    let columns = context.document.one_each(&position().key("columns"), &table.columns, &context.joint_names)?;
    let units = Units::new(context, position().key("unit"), table.unit.as_ref())?;
    let column = |(joint, column): (usize, &String)| {
        if column.is_empty() {
            let name = context.joint_names[joint];
            let message = format!("joint `{name}` has no column, and every torque depends on every position: name one");
            return Err(context.document.error(&position().key("columns").at(joint), message));
        }
        Ok(PositionColumn { column: column.clone(), unit: units.of(joint, units::position_reading)? })
    };
    columns.iter().enumerate().map(column).collect()
}

/// The units that are written for the joints: one for all, or a list.
struct Units<'a> {
    context: &'a Context<'a>,
    field: Field,
    written: Option<&'a OneOrMany<String>>,
}

impl<'a> Units<'a> {
    fn new(
        context: &'a Context<'_>,
        field: Field,
        written: Option<&'a OneOrMany<String>>,
    ) -> Result<Units<'a>, FileError> {
        if let Some(OneOrMany::Many(units)) = written {
            context.document.one_each(&field, units, &context.joint_names)?;
        }
        Ok(Units { context, field, written })
    }

    fn of<U>(&self, joint: usize, parse: fn(Option<&str>) -> Result<U, UnitError>) -> Result<U, FileError> {
        let (written, field) = match self.written {
            Some(OneOrMany::Many(units)) => (Some(&units[joint]), self.field.at(joint)),
            Some(OneOrMany::One(unit)) => (Some(unit), self.field.clone()),
            None => (None, self.field.clone()),
        };
        parse(written.map(String::as_str)).map_err(|error| self.context.document.error(&field, error))
    }
}

fn torques(
    context: &Context<'_>,
    table: Option<&TorqueTable>,
) -> Result<Vec<Option<(ReadingColumn, TorqueUnit)>>, FileError> {
    let no_torque = "no joint has a torque reading, and without torque there is nothing to calibrate: name the columns \
                     of the torque readings, readings.torque = { columns = [...], unit = \"...\" }";
    let table = table.ok_or_else(|| context.document.error(&torque(), no_torque))?;
    let columns = TorqueColumns::new(context, table)?;
    if table.columns.iter().all(String::is_empty) {
        return Err(context.document.error(&torque().key("columns"), no_torque));
    }
    (0..context.joint_names.len()).map(|joint| columns.of(joint)).collect()
}

/// The parts of `readings.torque`, one for each joint.
struct TorqueColumns<'a> {
    columns: &'a [String],
    units: Units<'a>,
    std: Option<Vec<f64>>,
    count: Option<Vec<f64>>,
    std_columns: Option<Vec<String>>,
    count_columns: Option<Vec<String>>,
    usable_columns: Option<Vec<String>>,
}

impl<'a> TorqueColumns<'a> {
    fn new(context: &'a Context<'_>, table: &'a TorqueTable) -> Result<Self, FileError> {
        let (document, names) = (context.document, context.joint_names.as_slice());
        let numbers = |key: &str, numbers: &Option<OneOrMany<f64>>| {
            numbers.as_ref().map(|numbers| document.for_each(&torque().key(key), numbers, names)).transpose()
        };
        let columns = |key: &str, columns: &Option<Vec<String>>| {
            columns.as_ref().map(|columns| document.one_each(&torque().key(key), columns, names).cloned()).transpose()
        };
        Ok(TorqueColumns {
            columns: document.one_each(&torque().key("columns"), &table.columns, names)?,
            units: Units::new(context, torque().key("unit"), table.unit.as_ref())?,
            std: numbers("std", &table.std)?,
            count: numbers("count", &table.count)?,
            std_columns: columns("std_columns", &table.std_columns)?,
            count_columns: columns("count_columns", &table.count_columns)?,
            usable_columns: columns("usable_columns", &table.usable_columns)?,
        })
    }

    /// The reading of a joint; `None` where it has no column (and needs no unit).
    fn of(&self, joint: usize) -> Result<Option<(ReadingColumn, TorqueUnit)>, FileError> {
        let Some(name) = named(&self.columns[joint]) else { return Ok(None) };
        let number = |numbers: &Option<Vec<f64>>| numbers.as_ref().map(|numbers| numbers[joint]);
        let column = |columns: &Option<Vec<String>>| columns.as_ref().and_then(|columns| named(&columns[joint]));
        let reading = ReadingColumn {
            column: name,
            std_column: column(&self.std_columns),
            count_column: column(&self.count_columns),
            usable_column: column(&self.usable_columns),
            std: number(&self.std),
            count: number(&self.count),
        };
        Ok(Some((reading, self.units.of(joint, units::torque_reading)?)))
    }
}

/// The name of a column; `""` is none.
fn named(column: &str) -> Option<String> {
    (!column.is_empty()).then(|| column.to_owned())
}
