//! `[constraints]`: what the joint estimate must obey.

use gravcal_dynamics::BodyInertia;
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
    /// `"physical"`: masses, centres of mass and inertia tensors are also told as rigid bodies can have them, for exports. The estimate
    /// itself does not change. The robot's file must state the inertia of every link; `inertia.relative_std` says how well it does.
    ///
    /// Default: not told.
    /// Example: `inertia = "physical"`
    inertia: Option<Inertia>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Inertia {
    Physical,
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
    let physical_inertias = matches!(table.inertia, Some(Inertia::Physical));
    if physical_inertias {
        check_assumed(context, &field("inertia"))?;
    }
    Ok(Constraints {
        positive_masses: matches!(table.masses, Some(Masses::Positive)),
        center_of_mass_within: radii.transpose()?.unwrap_or_else(|| vec![None; context.link_names.len()]),
        torque_gains_within: gains.transpose()?,
        physical_inertias,
    })
}

/// Tensor over mass, m², up to which a body is a point but for rounding.
const POINT: f64 = 1e-12;

/// Of all bodies that explain the readings alike, the one nearest to the robot's file is taken: that must state one of every link.
fn check_assumed(context: &Context<'_>, field: &Field) -> Result<(), FileError> {
    let chain = &context.robot.chain;
    let stated = chain
        .inertial_parameters()
        .map_err(|error| context.document.error(field, format!("{}: {error}", context.robot_path.display())))?;
    let (bodies, _) = stated.as_chunks::<10>();
    let without = |which: &dyn Fn(&[f64; 10]) -> bool| -> Vec<&str> {
        let missing = chain.links().iter().zip(bodies).filter(|(_, body)| which(body));
        missing.map(|(link, _)| link.name.as_str()).collect()
    };
    let massless = without(&|[mass, ..]| *mass <= 0.0);
    // About the centre of mass: about the link's origin a point mass has one, too. A `robot.toml` that states none has zeros there.
    let is_point = |body: &[f64; 10]| {
        let [mass, _, _, _, stated @ ..] = *body;
        let tensor = BodyInertia::from_parameters(*body).tensor_about_center();
        mass > 0.0 && (stated == [0.0; 6] || tensor.iter().all(|entry| entry.abs() <= POINT * mass))
    };
    let pointlike = without(&is_point);
    let missing: Vec<String> = [("a mass", massless), ("an inertia tensor", pointlike)]
        .into_iter()
        .filter(|(_, links)| !links.is_empty())
        .map(|(what, links)| format!("{what} for {}", links.join(", ")))
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    let message = format!(
        "readings tell combinations of inertias only, and the rest is taken from the robot's file; {} has not {}: describe the robot by \
         a URDF with an <inertial> for each of these links, or by inertia_kg_m2 in robot.toml (rough values serve: a cylinder of the link's \
         size and mass), or leave this out",
        context.robot_path.display(),
        missing.join(", nor ")
    );
    Err(context.document.error(field, message))
}
