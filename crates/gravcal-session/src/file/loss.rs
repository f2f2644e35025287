//! `[loss]`: how much a torque reading far beyond its noise still counts in the joint estimate.

use gravcal_estimation::{Loss, LossName};
use serde::Deserialize;

use super::context::Context;
use crate::document::{Field, FileError};

/// `[loss]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct LossTable {
    /// `"none"`, `"huber"`, `"cauchy"`, `"tukey"` or `"geman-mcclure"`.
    ///
    /// Example: `kind = "huber"`
    kind: String,
    /// Residual, in standard deviations, from which a reading counts less.
    ///
    /// Unit: standard deviations.
    /// Default: the one that loses 5 % of the information of normal noise.
    /// Example: `width = 1.345`
    width: Option<f64>,
}

/// What `[loss]` comes to; without a width, the one that loses 5 % of the information of normal noise.
pub(super) fn resolve(context: &Context<'_>, table: Option<&LossTable>) -> Result<Loss, FileError> {
    let Some(table) = table else { return Ok(Loss::None) };
    let [kind, width] = ["kind", "width"].map(|key| Field::new("loss").key(key));
    let refused = |error| context.document.error(&kind, error);
    match (table.kind.parse::<LossName>().map_err(refused)?, table.width) {
        (LossName::None, Some(_)) => {
            let message = "without a loss there is no width: choose another kind, or leave the width out";
            Err(context.document.error(&width, message))
        }
        (name, None) => Ok(name.efficient()),
        (name, Some(value)) => name.with_width(value).checked().map_err(|error| context.document.error(&width, error)),
    }
}
