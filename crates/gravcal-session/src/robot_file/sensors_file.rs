//! Sensors of a joint as files describe them: nominal ones in a robot's, true ones in a simulation's.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::robot::{NominalPositionSensor, NominalSensors, NominalTorqueSensor};
use gravcal_robot_model::session::units;
use gravcal_robot_model::session::units::UnitError;
use serde::Deserialize;

use crate::document::{Document, Field, FileError};

/// `torque_sensor`: `reading = gain · torque + bias`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct TorqueSensorTable {
    /// Gain.
    ///
    /// Example: `gain = { value = 6.69, unit = "count/(N·m)" }`
    gain: ValueTable,
    /// Bias.
    ///
    /// Default: 0.
    /// Example: `bias = { value = 2048.0, unit = "count" }`
    bias: Option<ValueTable>,
}

/// `position_sensor`: `coordinate = gain · reading + offset`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct PositionSensorTable {
    /// Gain.
    ///
    /// Example: `gain = { value = 1.0, unit = "deg/deg" }`
    gain: ValueTable,
    /// Offset.
    ///
    /// Default: 0.
    /// Example: `offset = { value = 0.0, unit = "deg" }`
    offset: Option<ValueTable>,
}

/// A number with its unit.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct ValueTable {
    /// The number.
    ///
    /// Unit: as `unit` says.
    /// Example: `value = 6.69`
    pub value: f64,
    // Read as optional so that the error can say which units fit.
    /// Unit of the number.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "count/(N·m)"`
    unit: Option<String>,
}

impl ValueTable {
    /// The unit as it is written.
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }
}

/// The sensors of one joint.
pub(crate) struct SensorTables<'a> {
    /// The joint's kind, which settles the units of torque and coordinate.
    pub kind: JointKind,
    /// `torque_sensor`.
    pub torque: Option<&'a TorqueSensorTable>,
    /// `position_sensor`.
    pub position: Option<&'a PositionSensorTable>,
}

impl SensorTables<'_> {
    /// What the tables come to, in SI. A bias or offset that is not given is zero; `joint` is the field that holds them.
    ///
    /// # Errors
    /// A unit is missing or does not fit, or a gain is not positive.
    pub fn nominal(&self, document: &Document, joint: &Field) -> Result<NominalSensors, FileError> {
        let place = Place { document, joint, kind: self.kind };
        Ok(NominalSensors {
            torque: self.torque.map(|sensor| place.torque(sensor)).transpose()?,
            position: self.position.map(|sensor| place.position(sensor)).transpose()?,
        })
    }
}

/// The joint whose sensors are read, and where it stands.
struct Place<'a> {
    document: &'a Document,
    joint: &'a Field,
    kind: JointKind,
}

impl Place<'_> {
    fn torque(&self, sensor: &TorqueSensorTable) -> Result<NominalTorqueSensor, FileError> {
        let field = self.joint.key("torque_sensor");
        let (gain, bias) = (field.key("gain"), field.key("bias"));
        let unit = units::torque_gain(sensor.gain.unit(), self.kind);
        let turned = |unit: &str| units::torque_gain(Some(unit), self.kind).is_ok();
        let unit = self.fitting(&gain, unit.map_err(|error| error.of_gain(Some(sensor.gain.value), turned)))?;
        let nominal = NominalTorqueSensor { unit, gain: self.gain(&gain, &sensor.gain)?, bias: 0.0 };
        let Some(table) = &sensor.bias else { return Ok(nominal) };
        let bias_unit = self.fitting(&bias, units::torque_reading(table.unit()))?;
        if bias_unit != unit {
            let message = format!("the bias is in {bias_unit}, but the gain is of readings in {unit}: make them agree");
            return Err(self.document.error(&bias.key("unit"), message));
        }
        Ok(NominalTorqueSensor { bias: table.value, ..nominal })
    }

    fn position(&self, sensor: &PositionSensorTable) -> Result<NominalPositionSensor, FileError> {
        let field = self.joint.key("position_sensor");
        let (gain, offset) = (field.key("gain"), field.key("offset"));
        let unit = units::position_gain(sensor.gain.unit(), self.kind);
        let turned = |unit: &str| units::position_gain(Some(unit), self.kind).is_ok();
        let unit = self.fitting(&gain, unit.map_err(|error| error.of_gain(Some(sensor.gain.value), turned)))?;
        let value = self.gain(&gain, &sensor.gain)? * unit.to_si();
        let nominal = NominalPositionSensor { unit: unit.reading, gain: value, offset: 0.0 };
        let Some(table) = &sensor.offset else { return Ok(nominal) };
        let offset_unit = self.fitting(&offset, units::coordinate(table.unit(), self.kind))?;
        Ok(NominalPositionSensor { offset: table.value * offset_unit.to_si(), ..nominal })
    }

    fn gain(&self, field: &Field, table: &ValueTable) -> Result<f64, FileError> {
        if table.value > 0.0 {
            return Ok(table.value);
        }
        let message = format!(
            "{} is not a gain: expected a positive number; that a sensor is reversed is said in the session, by \
             torque_sign or position_sign",
            table.value
        );
        Err(self.document.error(&field.key("value"), message))
    }

    fn fitting<U>(&self, field: &Field, unit: Result<U, UnitError>) -> Result<U, FileError> {
        unit.map_err(|error| self.document.error(&field.key("unit"), error))
    }
}
