//! `[constraints]`: what the joint estimate must obey.

use serde::Deserialize;

use super::Context;
use crate::document::{Field, FileError, OneOrNamed};
use crate::session::Constraints;

/// `[constraints]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ConstraintsTable {
    masses: Option<Masses>,
    center_of_mass_within_m: Option<OneOrNamed>,
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
    let radii = radii.map(|written| radii_by_link(context, &field("center_of_mass_within_m"), written));
    Ok(Constraints {
        positive_masses: matches!(table.masses, Some(Masses::Positive)),
        center_of_mass_within: radii.transpose()?.unwrap_or_else(|| vec![None; context.link_names.len()]),
        torque_gains_within: gains.transpose()?,
    })
}

fn radii_by_link(context: &Context<'_>, field: &Field, written: &OneOrNamed) -> Result<Vec<Option<f64>>, FileError> {
    let radius = |field: &Field, radius: f64| context.document.positive(field, radius, "a distance", "m");
    match written {
        OneOrNamed::One(all) => Ok(vec![Some(radius(field, *all)?); context.link_names.len()]),
        OneOrNamed::Named(named) => {
            let mut radii = vec![None; context.link_names.len()];
            for (name, value) in named {
                let field = field.key(name);
                let link = context.document.lookup(&field, "link", name, &context.link_names)?;
                radii[link] = Some(radius(&field, *value)?);
            }
            Ok(radii)
        }
    }
}
