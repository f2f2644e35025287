//! What disturbs the readings, and under which conditions they are read.

use gravcal_robot_model::session::Session;

use super::reader::Reader;
use super::tables::{ConverterTable, OutliersTable};
use crate::document::{Field, FileError, OneOrMany};
use crate::simulation::{Converter, Deflection, Disturbance, Outliers, SimulatedConditions};

impl Reader<'_> {
    pub fn conditions(&self) -> Result<SimulatedConditions, FileError> {
        let Some(table) = &self.table.conditions else { return Ok(SimulatedConditions::default()) };
        let field = Field::new("conditions");
        let positive = |key: &str, value: Option<f64>, what: &str, unit: &str| {
            value.map(|value| self.document.positive(&field.key(key), value, what, unit)).transpose()
        };
        Ok(SimulatedConditions {
            pose_interval: positive("pose_interval_s", table.pose_interval_s, "an interval", "s")?,
            temperature: table.temperature_degc,
            largest_speed: positive(
                "largest_speed_rad_or_m_per_s",
                table.largest_speed_rad_or_m_per_s,
                "a speed",
                "rad/s or m/s",
            )?,
            direction: table.direction,
        })
    }

    pub fn disturbance(&self) -> Result<Disturbance, FileError> {
        let (names, table) = (self.names(), self.table);
        let torque = Field::new("torque").key("std");
        let torque_std = self.document.for_each(&torque, &table.torque.std, &names)?;
        for std in &torque_std {
            self.document.positive(&torque, *std, "a standard deviation", "the reading's unit")?;
        }
        let zero = OneOrMany::One(0.0);
        let position = Field::new("position").key("std");
        let position_std = self.document.for_each(&position, table.position.std.as_ref().unwrap_or(&zero), &names)?;
        self.not_negative(&position, &position_std)?;
        Ok(Disturbance {
            torque_std,
            instrument_std: Vec::new(),
            position_std,
            converter: table.torque.converter.map(|c| self.converter(c)).transpose()?,
            outliers: table.torque.outliers.map(|o| self.outliers(o)).transpose()?,
            deflection: self.deflection()?,
        })
    }

    fn deflection(&self) -> Result<Deflection, FileError> {
        let (field, table) = (|key: &str| Field::new("deflection").key(key), &self.table.deflection);
        let angle = |key: &str, written: Option<f64>| {
            let angle = written.unwrap_or(0.0).to_radians();
            self.not_negative(&field(key), &[angle]).map(|()| angle)
        };
        let zero = OneOrMany::One(0.0);
        let compliance = table.compliance_rad_per_newton_metre.as_ref().unwrap_or(&zero);
        Ok(Deflection {
            hold_std: angle("hold_std_deg", table.hold_std_deg)?,
            pose_std: angle("pose_std_deg", table.pose_std_deg)?,
            compliance: self.document.for_each(&field("compliance_rad_per_newton_metre"), compliance, &self.names())?,
            seen: table.seen,
        })
    }

    /// Readings that see a deflection are made by gain and offset alone.
    pub fn check_seen(&self, template: &Session) -> Result<(), FileError> {
        if self.table.deflection.seen && template.terms.of_positions().next().is_some() {
            let message = "a deflection can be seen by affine position sensors only: drop the sensor models of positions, or \
                           this";
            return Err(self.document.error(&Field::new("deflection").key("seen"), message));
        }
        Ok(())
    }

    pub fn not_negative(&self, field: &Field, values: &[f64]) -> Result<(), FileError> {
        match values.iter().find(|value| **value < 0.0) {
            Some(value) => Err(self.document.error(field, format!("{value} is negative: expected zero or more"))),
            None => Ok(()),
        }
    }

    fn outliers(&self, OutliersTable { share, std }: OutliersTable) -> Result<Outliers, FileError> {
        let field = Field::new("torque").key("outliers");
        if !(0.0..=1.0).contains(&share) {
            return Err(self
                .document
                .error(&field.key("share"), format!("{share} is no probability: expected 0 to 1")));
        }
        let std = self.document.positive(&field.key("std"), std, "a standard deviation", "the reading's unit")?;
        Ok(Outliers { share, std })
    }

    fn converter(&self, ConverterTable { bits, range }: ConverterTable) -> Result<Converter, FileError> {
        let field = Field::new("torque").key("converter");
        if !(1..=32).contains(&bits) {
            return Err(self.document.error(&field.key("bits"), format!("{bits} bits: expected 1 to 32")));
        }
        if range[0] >= range[1] {
            return Err(self.document.error(&field.key("range"), "expected [lowest, highest] reading"));
        }
        Ok(Converter { bits, range })
    }
}
