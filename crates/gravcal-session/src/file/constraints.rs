//! `[constraints]`: what the joint estimate must obey.

use gravcal_robot_model::session::Constraints;
use serde::Deserialize;

use super::context::Context;
use crate::document::{Field, FileError, OneOrNamed};

/// `[constraints]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ConstraintsTable {
    /// No link's mass is negative.
    ///
    /// Default: no constraint.
    /// Example: `masses = "positive"`
    masses: Option<Masses>,
    /// Largest distance of a centre of mass from the origin of its link's frame; one number, or by link.
    ///
    /// Default: no constraint.
    /// Example: `center_of_mass_within_m = { link2 = 0.3 }`
    center_of_mass_within_m: Option<OneOrNamed>,
    /// Largest difference of a torque gain from its nominal value, relative to that.
    ///
    /// Unit: 1.
    /// Default: no constraint.
    /// Example: `torque_gains_within = 0.2`
    torque_gains_within: Option<f64>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Masses {
    Positive,
}

/// What `[constraints]` comes to.
pub(super) fn resolve(context: &Context<'_>, table: &ConstraintsTable) -> Result<Constraints, FileError> {
    let field = |key: &str| Field::new("constraints").key(key);
    let gains = table.torque_gains_within.map(|share| {
        let what = "a share of the nominal gain";
        context.document.positive(&field("torque_gains_within"), share, what, "no unit, such as 0.2")
    });
    let radii = table.center_of_mass_within_m.as_ref();
    let links = ("link", context.link_names.as_slice());
    let radii = radii.map(|written| {
        context.document.positive_by_name(&field("center_of_mass_within_m"), written, links, ("a distance", "m"))
    });
    Ok(Constraints {
        positive_masses: matches!(table.masses, Some(Masses::Positive)),
        center_of_mass_within: radii.transpose()?.unwrap_or_else(|| vec![None; context.link_names.len()]),
        torque_gains_within: gains.transpose()?,
    })
}
