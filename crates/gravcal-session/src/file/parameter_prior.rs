//! What is known of one parameter beforehand, as it is written.

use gravcal_robot_model::session::{ParameterPrior, PriorKind};
use serde::Deserialize;

use crate::document::{Document, Field, FileError};

/// `{ nominal, unit }`, `{ nominal, std, unit }` or `{ fixed, unit }`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct ParameterPriorTable {
    /// Where the search begins; with `std` it is knowledge. Give this or `fixed`.
    ///
    /// Unit: as `unit` says.
    /// Example: `nominal = 6.69`
    nominal: Option<f64>,
    /// How well the nominal value is known.
    ///
    /// Unit: as `unit` says.
    /// Default: a start only.
    /// Example: `std = 0.1`
    std: Option<f64>,
    /// The exact value.
    ///
    /// Unit: as `unit` says.
    /// Example: `fixed = 1`
    fixed: Option<f64>,
    // Read as optional so that the error can say which units fit.
    /// Unit of these numbers.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "count/(N·m)"`
    unit: Option<String>,
}

impl ParameterPriorTable {
    /// The unit as it is written.
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }

    /// The number that is written, whatever is known of it.
    pub fn value(&self) -> Option<f64> {
        self.nominal.or(self.fixed)
    }

    /// Whether it is said to be exact.
    pub fn is_fixed(&self) -> bool {
        self.fixed.is_some()
    }

    /// A bias or offset, in the written unit.
    pub fn prior(&self, document: &Document, field: &Field) -> Result<ParameterPrior, FileError> {
        match (self.nominal, self.std, self.fixed) {
            (Some(nominal), None, None) => Ok(start(nominal)),
            (Some(nominal), Some(std), None) => {
                let unit = self.unit().unwrap_or_default();
                let std = document.positive(&field.key("std"), std, "a standard deviation", unit)?;
                Ok(ParameterPrior { nominal, kind: PriorKind::Gaussian { std } })
            }
            (None, None, Some(nominal)) => Ok(ParameterPrior { nominal, kind: PriorKind::Fixed }),
            _ => Err(document.error(
                field,
                "expected { nominal, unit } (a start), { nominal, std, unit } (known that well), or { fixed, unit } \
                 (known exactly)",
            )),
        }
    }

    /// A gain, in the written unit: a positive number that is given its declared sign, 1 or −1.
    pub fn gain(&self, document: &Document, field: &Field, sign: f64) -> Result<ParameterPrior, FileError> {
        let written = self.prior(document, field)?;
        if written.nominal > 0.0 {
            return Ok(ParameterPrior { nominal: sign * written.nominal, ..written });
        }
        let key = if self.is_fixed() { "fixed" } else { "nominal" };
        let message = format!(
            "{} is not a gain: expected a positive number; a sensor that is mounted the other way round is declared by \
             torque_sign, position_sign or (of an instrument) sign = \"reversed\"",
            written.nominal
        );
        Err(document.error(&field.key(key), message))
    }
}

/// Where the estimation starts, and nothing more.
pub(super) fn start(nominal: f64) -> ParameterPrior {
    ParameterPrior { nominal, kind: PriorKind::Flat }
}

/// The same knowledge in a unit that is `factor` times smaller.
pub(super) fn scaled(prior: ParameterPrior, factor: f64) -> ParameterPrior {
    let kind = match prior.kind {
        PriorKind::Gaussian { std } => PriorKind::Gaussian { std: std * factor },
        kind => kind,
    };
    ParameterPrior { nominal: prior.nominal * factor, kind }
}
