//! `[recording]`: the tables are recordings in motion.

use super::Reader;
use crate::document::{Field, FileError};
use crate::simulation::{Dirt, Motion};

impl Reader<'_> {
    pub fn motion(&self) -> Result<Option<Motion>, FileError> {
        let Some(table) = &self.table.recording else { return Ok(None) };
        let field = |key: &str| Field::new("recording").key(key);
        if self.table.conditions.is_some() {
            let message = "time and direction of approach are those of the motion: delete this, or [recording]";
            return Err(self.document.error(&Field::new("conditions"), message));
        }
        let positive = |key: &str, value: f64, unit: &str| self.document.positive(&field(key), value, "a number", unit);
        let not_negative = |key: &str, value: Option<f64>| {
            let value = value.unwrap_or(0.0);
            self.not_negative(&field(key), &[value]).map(|()| value)
        };
        let share = |key: &str, value: Option<f64>| match value.unwrap_or(0.0) {
            value if (0.0..1.0).contains(&value) => Ok(value),
            value => Err(self.document.error(&field(key), format!("{value} is no share: expected 0 to 1"))),
        };
        if table.samples < 2 {
            return Err(self.document.error(&field("samples"), "expected 2 samples at least"));
        }
        Ok(Some(Motion {
            rate: positive("rate_hz", table.rate_hz, "Hz")?,
            samples: table.samples,
            moving: positive("move_s", table.move_s, "s")?,
            settling: not_negative("settling_s", table.settling_s)?,
            vibration: not_negative("vibration", table.vibration)?,
            settling_time: positive("settling_time_constant_s", table.settling_time_constant_s.unwrap_or(0.05), "s")?,
            correlation: not_negative("noise_correlation_s", table.noise_correlation_s)?,
            dirt: Dirt {
                outliers: share("outliers", table.outliers)?,
                dropped: share("dropped", table.dropped)?,
                touched: table.touched.unwrap_or(0),
            },
        }))
    }
}
