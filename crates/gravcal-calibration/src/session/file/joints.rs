//! `[[joint]]`: what is known of each joint's sensors beforehand.
//!
//! What a parameter starts from is looked for in the session, then in the robot's file; where both are silent, a reading
//! that is a torque (or an angle) already is taken at its word: gain 1, bias and offset 0.
//!
//! **Signs.** Gains are positive numbers wherever they stand in a file. Whether the reading grows or falls with the
//! torque is said by `torque_sign` alone, and by `position_sign` whether the coordinate grows or falls with the reading:
//! `"reversed"` makes the gain negative, whether it is known exactly, as a prior, or only as a start. Biases and offsets
//! are what they are, sign included.

use std::fmt::Display;

use gravcal_kinematics::JointKind;
use gravcal_recording::{PoseMapping, PositionUnit, TorqueUnit};
use serde::Deserialize;

use super::Context;
use super::knowledge::{KnowledgeTable, scaled, start};
use crate::document::{Field, FileError};
use crate::parameter::Quantity;
use crate::robot::{NominalPositionSensor, NominalTorqueSensor};
use crate::sensors::ModelTable;
use crate::session::units::{self, UnitError};
use crate::session::{JointKnowledge, Knowledge};

/// `[[joint]]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct JointTable {
    pub name: String,
    torque_sign: Option<Sign>,
    position_sign: Option<Sign>,
    torque_gain: Option<KnowledgeTable>,
    torque_bias: Option<KnowledgeTable>,
    position_gain: Option<KnowledgeTable>,
    position_offset: Option<KnowledgeTable>,
    #[serde(default)]
    pub sensor_models: Vec<ModelTable<KnowledgeTable>>,
}

/// Whether a sensor is mounted the other way round.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Sign {
    Normal,
    Reversed,
}

/// What the `[[joint]]` come to: one for each joint of the robot.
pub(super) fn resolve(
    context: &Context<'_>,
    mapping: &PoseMapping,
    tables: &[JointTable],
) -> Result<Vec<JointKnowledge>, FileError> {
    let name_field = |i: usize| Field::new("joint").at(i).key("name");
    context.document.check_names(tables.iter().map(|table| table.name.as_str()), name_field)?;
    let mut declared: Vec<Option<usize>> = vec![None; context.joint_names.len()];
    for (i, table) in tables.iter().enumerate() {
        let joint = context.document.lookup(&name_field(i), "joint", &table.name, &context.joint_names)?;
        declared[joint] = Some(i);
    }
    let silent = JointTable::default();
    let knowledge = declared.iter().enumerate().map(|(joint, declared)| {
        let table = declared.map_or(&silent, |i| &tables[i]);
        // Of a joint that is not declared no field is ever at fault.
        let field = declared.map_or(Field::new("joint"), |i| Field::new("joint").at(i));
        Joint::new(context, mapping, joint, field, table).knowledge()
    });
    knowledge.collect()
}

/// One joint and all that is said of it.
struct Joint<'a> {
    context: &'a Context<'a>,
    name: &'a str,
    kind: JointKind,
    field: Field,
    table: &'a JointTable,
    torque_unit: Option<TorqueUnit>,
    position_unit: PositionUnit,
    nominal_torque: Option<NominalTorqueSensor>,
    nominal_position: Option<NominalPositionSensor>,
}

impl<'a> Joint<'a> {
    fn new(
        context: &'a Context<'a>,
        mapping: &PoseMapping,
        joint: usize,
        field: Field,
        table: &'a JointTable,
    ) -> Joint<'a> {
        let sensors = &context.robot.sensors[joint];
        Joint {
            context,
            name: context.joint_names[joint],
            kind: context.robot.chain.joints()[joint].kind,
            field,
            table,
            torque_unit: mapping.torques[joint].as_ref().map(|(_, unit)| *unit),
            position_unit: mapping.positions[joint].unit,
            nominal_torque: sensors.torque,
            nominal_position: sensors.position,
        }
    }

    fn knowledge(&self) -> Result<JointKnowledge, FileError> {
        let [torque_gain, torque_bias] = match self.torque_unit {
            Some(reading) => [self.torque_gain(reading)?, self.torque_bias(reading)?],
            None => self.no_torque_sensor()?,
        };
        let parameters = [torque_gain, torque_bias, self.position_gain()?, self.position_offset()?];
        Ok(JointKnowledge {
            torque_unit: self.torque_unit,
            torque_sign_declared: self.table.torque_sign.is_some(),
            position_unit: self.position_unit,
            parameters,
        })
    }

    /// What is said of a sensor that is not read would be passed over in silence.
    fn no_torque_sensor(&self) -> Result<[Knowledge; 2], FileError> {
        let said = [
            ("torque_gain", self.table.torque_gain.is_some()),
            ("torque_bias", self.table.torque_bias.is_some()),
            ("torque_sign", self.table.torque_sign.is_some()),
        ];
        match said.into_iter().find(|(_, said)| *said) {
            Some((key, _)) => {
                let name = self.name;
                let message = format!("joint `{name}` has no column in readings.torque: name one, or delete this");
                Err(self.context.document.error(&self.field.key(key), message))
            }
            None => Ok([start(1.0), start(0.0)]),
        }
    }

    fn torque_gain(&self, reading: TorqueUnit) -> Result<Knowledge, FileError> {
        let sign = factor(self.table.torque_sign);
        if let Some(table) = &self.table.torque_gain {
            let unit = self.fitting(Quantity::TorqueGain, units::torque_gain(table.unit(), self.kind))?;
            self.check_reading(Quantity::TorqueGain, unit, reading)?;
            return table.gain(self.context.document, &self.field_of(Quantity::TorqueGain), sign);
        }
        match (self.nominal_torque_in(reading)?, reading.of(units::effort(self.kind))) {
            (Some(nominal), _) => Ok(start(sign * nominal.gain)),
            (None, Some(natural)) => Ok(start(sign * natural)),
            (None, None) => {
                let unit = match units::effort(self.kind) {
                    TorqueUnit::NewtonMeter => format!("{reading}/(N·m)"),
                    effort => format!("{reading}/{effort}"),
                };
                Err(self.no_nominal_gain("torque", reading, &unit))
            }
        }
    }

    fn torque_bias(&self, reading: TorqueUnit) -> Result<Knowledge, FileError> {
        if let Some(table) = &self.table.torque_bias {
            let unit = self.fitting(Quantity::TorqueBias, units::torque_reading(table.unit()))?;
            self.check_reading(Quantity::TorqueBias, unit, reading)?;
            return table.knowledge(self.context.document, &self.field_of(Quantity::TorqueBias));
        }
        Ok(start(self.nominal_torque_in(reading)?.map_or(0.0, |nominal| nominal.bias)))
    }

    fn position_gain(&self) -> Result<Knowledge, FileError> {
        let sign = factor(self.table.position_sign);
        let reading = self.position_unit.si();
        if let Some(table) = &self.table.position_gain {
            let unit = self.fitting(Quantity::PositionGain, units::position_gain(table.unit(), self.kind))?;
            self.check_reading(Quantity::PositionGain, unit.reading.si(), reading)?;
            let gain = table.gain(self.context.document, &self.field_of(Quantity::PositionGain), sign)?;
            return Ok(scaled(gain, unit.to_si()));
        }
        match self.nominal_position_in(reading)? {
            Some(nominal) => Ok(start(sign * nominal.gain)),
            None if reading == units::si_coordinate(self.kind) => Ok(start(sign)),
            None => {
                let unit = format!("{}/{}", units::si_coordinate(self.kind), self.position_unit);
                Err(self.no_nominal_gain("position", self.position_unit, &unit))
            }
        }
    }

    fn position_offset(&self) -> Result<Knowledge, FileError> {
        if let Some(table) = &self.table.position_offset {
            let unit = self.fitting(Quantity::PositionOffset, units::coordinate(table.unit(), self.kind))?;
            let offset = table.knowledge(self.context.document, &self.field_of(Quantity::PositionOffset))?;
            return Ok(scaled(offset, unit.to_si()));
        }
        // An offset does not depend on the reading's unit.
        Ok(start(self.nominal_position.map_or(0.0, |nominal| nominal.offset)))
    }

    fn field_of(&self, quantity: Quantity) -> Field {
        self.field.key(quantity.as_str())
    }

    fn fitting<U>(&self, quantity: Quantity, unit: Result<U, UnitError>) -> Result<U, FileError> {
        unit.map_err(|error| self.context.document.error(&self.field_of(quantity).key("unit"), error))
    }

    /// The unit that a parameter is written for must be that of the readings.
    fn check_reading<U: PartialEq + Display>(
        &self,
        quantity: Quantity,
        written: U,
        reading: U,
    ) -> Result<(), FileError> {
        if written == reading {
            return Ok(());
        }
        let message =
            format!("this is for readings in {written}, but those of the joint are in {reading}: make them agree");
        Err(self.context.document.error(&self.field_of(quantity).key("unit"), message))
    }

    /// The robot's nominal torque sensor, which must be read in its unit.
    fn nominal_torque_in(&self, reading: TorqueUnit) -> Result<Option<NominalTorqueSensor>, FileError> {
        match self.nominal_torque {
            Some(nominal) if nominal.unit != reading => {
                Err(self.other_nominal("torque", reading, nominal.unit, "torque_gain and torque_bias"))
            }
            nominal => Ok(nominal),
        }
    }

    /// The robot's nominal position sensor, which must be read in its unit (or one that is the same in SI).
    fn nominal_position_in(&self, reading: PositionUnit) -> Result<Option<NominalPositionSensor>, FileError> {
        match self.nominal_position {
            Some(nominal) if nominal.unit.si() != reading => {
                Err(self.other_nominal("position", self.position_unit, nominal.unit, "position_gain"))
            }
            nominal => Ok(nominal),
        }
    }

    fn other_nominal(&self, sensor: &str, here: impl Display, there: impl Display, remedy: &str) -> FileError {
        let (name, robot) = (self.name, self.context.robot_path.display());
        let message = format!(
            "{sensor} readings of joint `{name}` are in {here} here, but in {there} in {robot}: make the two files agree, \
             or give {remedy} under [[joint]]"
        );
        self.context.document.error(&Field::new("readings").key(sensor).key("unit"), message)
    }

    fn no_nominal_gain(&self, sensor: &str, reading: impl Display, unit: &str) -> FileError {
        let (name, robot) = (self.name, self.context.robot_path.display());
        let message = format!(
            "{sensor} readings of joint `{name}` are in {reading}, and nothing says roughly what that is: add [[joint]] \
             name = \"{name}\", {sensor}_gain = {{ nominal = ..., unit = \"{unit}\" }}, or a {sensor}_sensor in {robot}"
        );
        self.context.document.error(&Field::new("readings").key(sensor).key("unit"), message)
    }
}

fn factor(sign: Option<Sign>) -> f64 {
    match sign {
        None | Some(Sign::Normal) => 1.0,
        Some(Sign::Reversed) => -1.0,
    }
}
