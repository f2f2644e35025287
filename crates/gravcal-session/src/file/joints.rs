//! `[[joint]]`: what is known of each joint's sensors beforehand; `[joints]`: what is known of all of them, unless a joint's own table says
//! it otherwise, key by key.
//!
//! What a parameter starts from is looked for in the session, then in the robot's file; where both are silent, a reading
//! that is a torque (or an angle) already is taken at its word: gain 1, bias and offset 0.
//!
//! **Signs.** Gains are positive numbers wherever they stand in a file. Whether the reading grows or falls with the
//! torque is said by `torque_sign` alone, and by `position_sign` whether the coordinate grows or falls with the reading:
//! `"reversed"` makes the gain negative, whether it is known exactly, as a prior, or only as a start. Biases and offsets
//! are what they are, sign included.

use std::fmt::Display;

use gravcal_dynamics::JointKind;
use gravcal_recording::{PoseMapping, PositionUnit, TorqueUnit};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::robot::{NominalPositionSensor, NominalTorqueSensor};
use gravcal_robot_model::session::units::UnitError;
use gravcal_robot_model::session::{JointPriors, ParameterPrior, units};
use serde::Deserialize;

use super::context::Context;
use super::parameter_prior::{ParameterPriorTable, scaled, start};
use super::rotors::RotorInertia;
use crate::document::{Field, FileError};
use crate::sensor_models::ModelTable;

/// `[[joint]]`, or `[joints]`, which has no name.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct JointTable {
    /// The joint's name. Not in `[joints]`.
    ///
    /// Example: `name = "shoulder"`
    name: Option<String>,
    /// Whether the torque sensor reads the other way. Not declared, gravcal tries both.
    ///
    /// Default: not declared.
    /// Example: `torque_sign = "reversed"`
    torque_sign: Option<Sign>,
    /// Whether the position sensor reads the other way.
    ///
    /// Default: `"normal"`.
    /// Example: `position_sign = "reversed"`
    position_sign: Option<Sign>,
    /// What is known of the torque gain.
    ///
    /// Default: the robot's.
    /// Example: `torque_gain = { nominal = 6.69, unit = "count/(N·m)" }`
    torque_gain: Option<ParameterPriorTable>,
    /// What is known of the torque bias.
    ///
    /// Default: the robot's.
    /// Example: `torque_bias = { nominal = 2048, unit = "count" }`
    torque_bias: Option<ParameterPriorTable>,
    /// What is known of the position gain.
    ///
    /// Default: the robot's.
    /// Example: `position_gain = { fixed = 1, unit = "deg/deg" }`
    position_gain: Option<ParameterPriorTable>,
    /// What is known of the position offset.
    ///
    /// Default: the robot's.
    /// Example: `position_offset = { nominal = 135, std = 2, unit = "deg" }`
    position_offset: Option<ParameterPriorTable>,
    /// What the sensors do beyond gain and bias: see [Sensor models](sensor-models.md).
    ///
    /// Default: nothing.
    /// Example: `sensor_models = [{ kind = "coulomb-friction" }]`
    sensor_models: Option<Vec<ModelTable<ParameterPriorTable>>>,
    /// In motion, what the joint's motor turns before its gear, felt at the joint: `reading = torque_gain * (torque + rotor_inertia *
    /// acceleration) + ...`. For torques that a motor's current tells; a sensor behind the gear does not feel it. `"unknown"`, or a table
    /// with what is known of it, in `kg·m²` (`kg` where the joint slides).
    ///
    /// Default: none.
    /// Example: `rotor_inertia = "unknown"`
    rotor_inertia: Option<RotorInertia>,
}

/// All that is said of one joint.
pub(super) struct Said<'a> {
    /// Its own table, with its place among these.
    own: Option<(usize, &'a JointTable)>,
    of_all: Option<&'a JointTable>,
}

/// What a key says of a joint, and where.
pub(super) struct Entry<'a, T> {
    pub value: &'a T,
    pub key: &'static str,
    /// Of the value; that of sensor models is the table's.
    pub field: Field,
    /// Whether it is said of all joints.
    pub of_all: bool,
}

impl<'a> Said<'a> {
    /// The place of its own table.
    pub fn place(&self) -> Option<usize> {
        self.own.map(|(place, _)| place)
    }

    /// What its sensors do beyond gain and bias; the field is that of the table which says it.
    pub fn sensor_models(&self) -> Option<Entry<'a, Vec<ModelTable<ParameterPriorTable>>>> {
        let own = self.own.and_then(|(_, own)| own.sensor_models.as_ref()).map(|value| (value, false));
        let of_all = self.of_all.and_then(|table| table.sensor_models.as_ref()).map(|value| (value, true));
        own.or(of_all).map(|(value, of_all)| Entry {
            value,
            key: "sensor_models",
            field: self.table_field(of_all),
            of_all,
        })
    }

    /// What is said of a parameter.
    pub fn of(&self, quantity: SensorParameter) -> Option<Entry<'a, ParameterPriorTable>> {
        self.entry(quantity.as_str(), |table| match quantity {
            SensorParameter::TorqueGain => table.torque_gain.as_ref(),
            SensorParameter::TorqueBias => table.torque_bias.as_ref(),
            SensorParameter::PositionGain => table.position_gain.as_ref(),
            SensorParameter::PositionOffset => table.position_offset.as_ref(),
        })
    }

    /// What is said of the rotor inertia.
    pub fn rotor_inertia(&self) -> Option<Entry<'a, RotorInertia>> {
        self.entry("rotor_inertia", |table| table.rotor_inertia.as_ref())
    }

    fn entry<T>(&self, key: &'static str, value: impl Fn(&'a JointTable) -> Option<&'a T>) -> Option<Entry<'a, T>> {
        let own = self.own.and_then(|(_, own)| value(own)).map(|value| (value, false));
        let found = own.or_else(|| Some((value(self.of_all?)?, true)));
        found.map(|(value, of_all)| Entry { value, key, field: self.table_field(of_all).key(key), of_all })
    }

    fn table_field(&self, of_all: bool) -> Field {
        match self.own.filter(|_| !of_all) {
            Some((place, _)) => Field::new("joint").at(place),
            None => Field::new("joints"),
        }
    }
}

/// The tables of all joints of the robot, each of which is named once at most.
pub(super) fn said<'a>(
    context: &Context<'_>,
    tables: &'a [JointTable],
    of_all: Option<&'a JointTable>,
) -> Result<Vec<Said<'a>>, FileError> {
    if of_all.is_some_and(|table| table.name.is_some()) {
        let message = "[joints] is said of all joints: delete the name, or write [[joint]]";
        return Err(context.document.error(&Field::new("joints").key("name"), message));
    }
    let name_field = |i: usize| Field::new("joint").at(i).key("name");
    let missing = |i: usize| context.document.error(&Field::new("joint").at(i), "missing field `name`");
    let name = |(i, table): (usize, &'a JointTable)| table.name.as_deref().ok_or_else(|| missing(i));
    let names: Vec<&str> = tables.iter().enumerate().map(name).collect::<Result<_, _>>()?;
    context.document.check_names(names.iter().copied(), name_field)?;
    let mut all: Vec<Said<'a>> = context.joint_names.iter().map(|_| Said { own: None, of_all }).collect();
    for (i, (table, name)) in tables.iter().zip(names).enumerate() {
        let joint = context.document.lookup(&name_field(i), "joint", name, &context.joint_names)?;
        all[joint].own = Some((i, table));
    }
    Ok(all)
}

/// Whether a sensor is mounted the other way round.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Sign {
    Normal,
    Reversed,
}

/// What is said comes to: one for each joint of the robot.
pub(super) fn resolve(
    context: &Context<'_>,
    mapping: &PoseMapping,
    said: &[Said<'_>],
) -> Result<Vec<JointPriors>, FileError> {
    said.iter().enumerate().map(|(joint, said)| Joint::new(context, mapping, joint, said).prior()).collect()
}

/// One joint and all that is said of it.
struct Joint<'a> {
    context: &'a Context<'a>,
    name: &'a str,
    kind: JointKind,
    said: &'a Said<'a>,
    torque_unit: Option<TorqueUnit>,
    position_unit: PositionUnit,
    nominal_torque: Option<NominalTorqueSensor>,
    nominal_position: Option<NominalPositionSensor>,
}

impl<'a> Joint<'a> {
    fn new(context: &'a Context<'a>, mapping: &PoseMapping, joint: usize, said: &'a Said<'a>) -> Joint<'a> {
        let sensors = &context.robot.sensors[joint];
        Joint {
            context,
            name: context.joint_names[joint],
            kind: context.robot.chain.joints()[joint].kind,
            said,
            torque_unit: mapping.torques[joint].as_ref().map(|(_, unit)| *unit),
            position_unit: mapping.positions[joint].unit,
            nominal_torque: sensors.torque,
            nominal_position: sensors.position,
        }
    }

    fn prior(&self) -> Result<JointPriors, FileError> {
        let [torque_gain, torque_bias] = match self.torque_unit {
            Some(reading) => [self.torque_gain(reading)?, self.torque_bias(reading)?],
            None => self.no_torque_sensor()?,
        };
        let parameters = [torque_gain, torque_bias, self.position_gain()?, self.position_offset()?];
        Ok(JointPriors {
            torque_unit: self.torque_unit,
            torque_sign_declared: self.torque_sign().is_some(),
            position_unit: self.position_unit,
            parameters,
        })
    }

    fn torque_sign(&self) -> Option<Entry<'a, Sign>> {
        self.said.entry("torque_sign", |table| table.torque_sign.as_ref())
    }

    fn position_sign(&self) -> Option<Entry<'a, Sign>> {
        self.said.entry("position_sign", |table| table.position_sign.as_ref())
    }

    /// What is said of a sensor that is not read would be passed over in silence; what is said of all joints is of those that have one.
    fn no_torque_sensor(&self) -> Result<[ParameterPrior; 2], FileError> {
        let own = |field: Field, of_all: bool| (!of_all).then_some(field);
        let gain = self.said.of(SensorParameter::TorqueGain).and_then(|entry| own(entry.field, entry.of_all));
        let bias = || self.said.of(SensorParameter::TorqueBias).and_then(|entry| own(entry.field, entry.of_all));
        let sign = || self.torque_sign().and_then(|entry| own(entry.field, entry.of_all));
        match gain.or_else(bias).or_else(sign) {
            Some(field) => {
                let name = self.name;
                let message = format!("joint `{name}` has no column in readings.torque: name one, or delete this");
                Err(self.context.document.error(&field, message))
            }
            None => Ok([start(1.0), start(0.0)]),
        }
    }

    fn torque_gain(&self, reading: TorqueUnit) -> Result<ParameterPrior, FileError> {
        let sign = factor(self.torque_sign().map(|entry| *entry.value));
        if let Some(entry) = self.said.of(SensorParameter::TorqueGain) {
            let Entry { value: table, field, .. } = &entry;
            let unit = units::torque_gain(table.unit(), self.kind);
            let turned = |unit: &str| units::torque_gain(Some(unit), self.kind).is_ok();
            let unit = self.fitting(&entry, unit.map_err(|error| error.of_gain(table.value(), turned)))?;
            self.check_reading(&entry, unit, reading)?;
            return table.gain(self.context.document, field, sign);
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

    fn torque_bias(&self, reading: TorqueUnit) -> Result<ParameterPrior, FileError> {
        if let Some(entry) = self.said.of(SensorParameter::TorqueBias) {
            let Entry { value: table, field, .. } = &entry;
            let unit = self.fitting(&entry, units::torque_reading(table.unit()))?;
            self.check_reading(&entry, unit, reading)?;
            return table.prior(self.context.document, field);
        }
        Ok(start(self.nominal_torque_in(reading)?.map_or(0.0, |nominal| nominal.bias)))
    }

    fn position_gain(&self) -> Result<ParameterPrior, FileError> {
        let sign = factor(self.position_sign().map(|entry| *entry.value));
        let reading = self.position_unit.si();
        if let Some(entry) = self.said.of(SensorParameter::PositionGain) {
            let Entry { value: table, field, .. } = &entry;
            let unit = units::position_gain(table.unit(), self.kind);
            let turned = |unit: &str| units::position_gain(Some(unit), self.kind).is_ok();
            let unit = self.fitting(&entry, unit.map_err(|error| error.of_gain(table.value(), turned)))?;
            self.check_reading(&entry, unit.reading.si(), reading)?;
            let gain = table.gain(self.context.document, field, sign)?;
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

    fn position_offset(&self) -> Result<ParameterPrior, FileError> {
        if let Some(entry) = self.said.of(SensorParameter::PositionOffset) {
            let Entry { value: table, field, .. } = &entry;
            let unit = self.fitting(&entry, units::coordinate(table.unit(), self.kind))?;
            let offset = table.prior(self.context.document, field)?;
            return Ok(scaled(offset, unit.to_si()));
        }
        // An offset does not depend on the reading's unit.
        Ok(start(self.nominal_position.map_or(0.0, |nominal| nominal.offset)))
    }

    fn fitting<U>(&self, entry: &Entry<'_, ParameterPriorTable>, unit: Result<U, UnitError>) -> Result<U, FileError> {
        unit.map_err(|error| self.wrong_unit(entry, error))
    }

    /// What is said of all joints may not fit one of them: it is named.
    fn wrong_unit(&self, entry: &Entry<'_, ParameterPriorTable>, error: impl Display) -> FileError {
        let field = entry.field.key("unit");
        match entry.of_all {
            false => self.context.document.error(&field, error),
            true => {
                let (name, key) = (self.name, entry.key);
                let message = format!("joint `{name}`: {error}; or say {key} in a [[joint]] of its own");
                self.context.document.error(&field, message)
            }
        }
    }

    /// The unit that a parameter is written for must be that of the readings.
    fn check_reading<U: PartialEq + Display>(
        &self,
        entry: &Entry<'_, ParameterPriorTable>,
        written: U,
        reading: U,
    ) -> Result<(), FileError> {
        if written == reading {
            return Ok(());
        }
        let message =
            format!("this is for readings in {written}, but those of the joint are in {reading}: make them agree");
        Err(self.wrong_unit(entry, message))
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
        let (name, robot) = (self.name, self.context.robot_path);
        // A URDF has no place for it.
        let described = robot.extension().is_some_and(|extension| extension == "toml");
        let in_robot = if described { format!(", or a {sensor}_sensor in {}", robot.display()) } else { String::new() };
        let message = format!(
            "{sensor} readings of joint `{name}` are in {reading}, and nothing says roughly what that is: add {sensor}_gain = {{ nominal = \
             ..., unit = \"{unit}\" }} to its [[joint]] (name = \"{name}\"), or to [joints] for all of them{in_robot}"
        );
        self.context.document.error(&Field::new("readings").key(sensor).key("unit"), message)
    }
}

pub(super) fn factor(sign: Option<Sign>) -> f64 {
    match sign {
        None | Some(Sign::Normal) => 1.0,
        Some(Sign::Reversed) => -1.0,
    }
}
