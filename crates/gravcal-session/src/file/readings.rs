//! `[readings]`: which column of the tables is which reading, in which unit, and how noisy.

use std::collections::BTreeMap;

use gravcal_recording::{MappingError, PoseMapping, PositionColumn, ReadingColumn, TorqueUnit};
use gravcal_robot_model::session::units;
use serde::Deserialize;

use super::conditions::{self, ConditionTable, DirectionTable, MotionTable, TimeTable};
use super::context::Context;
use super::csv::{self, CsvTable};
use super::instruments::Instruments;
use super::motion::MotionWindowsTable;
use super::orientation::{self, OrientationTable};
use super::reading_columns::{ReadingColumns, ReadingColumnsTable, Units};
use super::select::{self, SelectTable};
use super::still::StillTable;
use super::sweeps::SweepsTable;
use super::unexplained;
use crate::document::{Field, FileError, OneOrMany};

/// `[readings]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ReadingsTable {
    /// Position readings of the joints.
    ///
    /// Example: `position = { columns = ["q1", "q2"], unit = "deg" }`
    pub(super) position: Option<PositionTable>,
    /// How the body stood, in a session without a robot.
    ///
    /// Example: `orientation = { columns = ["qx", "qy", "qz", "qw"], order = "xyzw", rotation = "base-from-body" }`
    pub(super) orientation: Option<OrientationTable>,
    /// Torque readings of the joints; `""` for a joint without a sensor.
    ///
    /// Example: `torque = { columns = ["y1", ""], unit = "count", std = 0.8 }`
    torque: Option<ReadingColumnsTable>,
    /// The clock, one for all tables.
    ///
    /// Example: `time = { column = "t", unit = "s" }`
    time: Option<TimeTable>,
    /// Temperatures, one column for all joints or one for each.
    ///
    /// Example: `temperature = { columns = "T", unit = "degC" }`
    temperature: Option<ConditionTable>,
    /// Velocities: columns, or the slope of the positions.
    ///
    /// Example: `velocity = { slope_over_s = 0.1 }`
    velocity: Option<MotionTable>,
    /// Accelerations: columns, or the slope of the velocities.
    ///
    /// Example: `acceleration = { slope_over_s = 0.1 }`
    acceleration: Option<MotionTable>,
    /// From which side each joint came: 1 rising, -1 falling, 0 not known.
    ///
    /// Example: `direction = { columns = ["d1", "d2"] }`
    direction: Option<DirectionTable>,
    /// Columns that only models of sensors know, by what these call them.
    ///
    /// Default: none.
    /// Example: `further = { oil = "p_oil" }`
    #[serde(default)]
    further: BTreeMap<String, String>,
    /// Which readings of an arm in motion count.
    ///
    /// Default: all.
    /// Example: `select = { joint = { speed_above = { value = 1, unit = "deg/s" } } }`
    #[serde(default)]
    select: SelectTable,
    /// The tables are recordings in motion; poses are the standstills found in them.
    ///
    /// Example: `still = {}`
    pub(super) still: Option<StillTable>,
    /// Poses are what a joint passes slowly in both directions. May stand beside `still`.
    ///
    /// Example: `sweeps = {}`
    pub(super) sweeps: Option<SweepsTable>,
    /// Every moment of recordings of an arm in motion counts, by the whole dynamics. May stand beside `still`, not beside `sweeps`.
    ///
    /// Example: `motion = {}`
    pub(super) motion: Option<MotionWindowsTable>,
    /// How CSV files are written, where gravcal finds it wrongly.
    ///
    /// Default: found by the first lines.
    /// Example: `csv = { delimiter = ";", decimal_comma = true }`
    #[serde(default)]
    csv: CsvTable,
    /// Column with labels of sweeps.
    ///
    /// Default: sweeps are found by movement.
    /// Example: `sweep_column = "sweep"`
    sweep_column: Option<String>,
    /// Rows of one standstill become one pose.
    ///
    /// Default: `false`.
    /// Example: `merge_repeated_rows = true`
    #[serde(default)]
    merge_repeated_rows: bool,
}

// Units are read as optional, so that the error can say which fit.
/// `[readings.position]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct PositionTable {
    /// One column for each joint.
    ///
    /// Example: `columns = ["q1", "q2"]`
    columns: Vec<String>,
    /// Unit of the readings: rad, deg, m, mm, count or V; one for all or a list.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "deg"`
    unit: Option<OneOrMany<String>>,
    /// Standard deviation of each reading, in its unit. With it every pose has its own errors of positions as unknowns.
    ///
    /// Unit: the reading's.
    /// Default: taken as exact.
    /// Example: `std = 0.02`
    std: Option<OneOrMany<f64>>,
}

impl ReadingsTable {
    /// What it says that only joints have, by key.
    pub(super) fn of_joints(&self) -> Vec<&'static str> {
        let said = [
            ("position", self.position.is_some()),
            ("torque", self.torque.is_some()),
            ("velocity", self.velocity.is_some()),
            ("acceleration", self.acceleration.is_some()),
            ("direction", self.direction.is_some()),
            ("still", self.still.is_some()),
            ("sweeps", self.sweeps.is_some()),
            ("motion", self.motion.is_some()),
        ];
        said.into_iter().filter(|(_, said)| *said).map(|(key, _)| key).collect()
    }
}

/// What `[readings]` comes to.
///
/// `instruments`: what else reads gravity.
pub(super) fn mapping(
    context: &Context<'_>,
    table: &ReadingsTable,
    instruments: &Instruments,
) -> Result<PoseMapping, FileError> {
    let conditions = conditions::Written {
        time: table.time.as_ref(),
        temperature: table.temperature.as_ref(),
        velocity: table.velocity.as_ref(),
        acceleration: table.acceleration.as_ref(),
        direction: table.direction.as_ref(),
        further: &table.further,
    };
    let orientation = table.orientation.as_ref().map(|table| orientation::resolve(context.document, table));
    let mapping = PoseMapping {
        positions: positions(context, table.position.as_ref())?,
        torques: torques(context, table.torque.as_ref(), !instruments.columns.is_empty())?,
        orientation: orientation.transpose()?,
        instruments: instruments.columns.clone(),
        sweep_column: table.sweep_column.clone(),
        merge_repeated: table.merge_repeated_rows,
        conditions: conditions::resolve(context, &conditions, instruments.instruments.len())?,
        selection: select::resolve(context, &table.select)?,
        csv: csv::resolve(context, &table.csv)?,
    };
    mapping.check().map_err(|error| context.document.error(&field_of(&error), error))?;
    Ok(mapping)
}

/// Standard deviation of each joint's position reading in its inside unit; 0 where it is taken as exact.
pub(super) fn position_std(context: &Context<'_>, table: &ReadingsTable) -> Result<Vec<f64>, FileError> {
    let (field, units) = (position().key("std"), positions(context, table.position.as_ref())?);
    let Some(written) = table.position.as_ref().and_then(|position| position.std.as_ref()) else {
        return Ok(vec![0.0; units.len()]);
    };
    let written = context.document.for_each(&field, written, &context.joint_names)?;
    let inside = |(std, column): (&f64, &PositionColumn)| match std {
        0.0.. => Ok(std * column.unit.to_si()),
        _ => Err(context.document.error(&field, format!("{std} is no standard deviation: expected 0 or more"))),
    };
    written.iter().zip(&units).map(inside).collect()
}

/// What is said of unexplained errors of the joints' torque readings, one for each joint.
pub(super) fn unexplained(
    context: &Context<'_>,
    table: &ReadingsTable,
) -> Result<Vec<Option<unexplained::Said>>, FileError> {
    match &table.torque {
        Some(table) => unexplained::said(context, &torque(), &context.joint_names, table),
        None => Ok(vec![None; context.joint_names.len()]),
    }
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
        MappingError::BadRange { .. } => torque().key("highest"),
        MappingError::CountWithoutStd { .. } => torque(),
        MappingError::SlopeWithoutTime => Field::new("readings").key("time"),
        MappingError::BadWindow { .. }
        | MappingError::SlopeOfSensorUnit { .. }
        | MappingError::AccelerationWithoutVelocity => Field::new("readings").key("velocity"),
        MappingError::SpeedUnknown | MappingError::AccelerationUnknown => Field::new("readings").key("select"),
        _ => Field::new("readings"),
    }
}

/// None where there are no joints.
fn positions(context: &Context<'_>, table: Option<&PositionTable>) -> Result<Vec<PositionColumn>, FileError> {
    let Some(table) = table else { return Ok(Vec::new()) };
    let columns = context.document.one_each(&position().key("columns"), &table.columns, &context.joint_names)?;
    let units = Units::new(context, position().key("unit"), &context.joint_names, table.unit.as_ref())?;
    let column = |(joint, column): (usize, &String)| {
        if column.is_empty() {
            let name = context.joint_names[joint];
            let message = format!("joint `{name}` has no column, and every torque depends on every position: name one");
            return Err(context.document.error(&position().key("columns").at(joint), message));
        }
        Ok(PositionColumn::new(column, units.of(joint, units::position_reading)?))
    };
    columns.iter().enumerate().map(column).collect()
}

fn torques(
    context: &Context<'_>,
    table: Option<&ReadingColumnsTable>,
    instruments: bool,
) -> Result<Vec<Option<(ReadingColumn, TorqueUnit)>>, FileError> {
    let no_torque = "no joint has a torque reading, and without torque there is nothing to calibrate: name the columns \
                     of the torque readings, readings.torque = { columns = [...], unit = \"...\" }";
    let Some(table) = table else {
        let none = vec![None; context.joint_names.len()];
        return if instruments { Ok(none) } else { Err(context.document.error(&torque(), no_torque)) };
    };
    let columns = ReadingColumns::new(context, &torque(), &context.joint_names, table)?;
    if table.columns.iter().all(String::is_empty) && !instruments {
        return Err(context.document.error(&torque().key("columns"), no_torque));
    }
    (0..context.joint_names.len()).map(|joint| columns.of(joint, units::torque_reading)).collect()
}
