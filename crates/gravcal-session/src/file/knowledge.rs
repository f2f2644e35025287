//! What is known of one parameter beforehand, as it is written.

use gravcal_robot_model::session::{Knowledge, KnowledgeKind};
use serde::Deserialize;

use crate::document::{Document, Field, FileError};

/// `{ nominal, unit }`, `{ nominal, std, unit }` or `{ fixed, unit }`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct KnowledgeTable {
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
    /// Mandatory; read as optional so that the error can say which units fit.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "count/(N·m)"`
    unit: Option<String>,
}

impl KnowledgeTable {
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
    pub fn knowledge(&self, document: &Document, field: &Field) -> Result<Knowledge, FileError> {
        match (self.nominal, self.std, self.fixed) {
            (Some(nominal), None, None) => Ok(start(nominal)),
            (Some(nominal), Some(std), None) => {
                let unit = self.unit().unwrap_or_default();
                let std = document.positive(&field.key("std"), std, "a standard deviation", unit)?;
                Ok(Knowledge { nominal, kind: KnowledgeKind::Prior { std } })
            }
            (None, None, Some(nominal)) => Ok(Knowledge { nominal, kind: KnowledgeKind::Fixed }),
            _ => Err(document.error(
                field,
                "expected { nominal, unit } (a start), { nominal, std, unit } (known that well), or { fixed, unit } \
                 (known exactly)",
            )),
        }
    }

    /// A gain, in the written unit: a positive number that is given its declared sign, 1 or −1.
    pub fn gain(&self, document: &Document, field: &Field, sign: f64) -> Result<Knowledge, FileError> {
        let written = self.knowledge(document, field)?;
        if written.nominal > 0.0 {
            return Ok(Knowledge { nominal: sign * written.nominal, ..written });
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
pub(super) fn start(nominal: f64) -> Knowledge {
    Knowledge { nominal, kind: KnowledgeKind::Start }
}

/// The same knowledge in a unit that is `factor` times smaller.
pub(super) fn scaled(knowledge: Knowledge, factor: f64) -> Knowledge {
    let kind = match knowledge.kind {
        KnowledgeKind::Prior { std } => KnowledgeKind::Prior { std: std * factor },
        kind => kind,
    };
    Knowledge { nominal: knowledge.nominal * factor, kind }
}
