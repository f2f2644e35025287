//! `[inertia]`: what is known of the links' masses and moments.

use serde::Deserialize;

use super::Context;
use crate::document::{Field, FileError, OneOrNamed};
use crate::session::InertiaKnowledge;

/// `[inertia]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct InertiaTable {
    #[serde(default)]
    links: Links,
    relative_std: Option<OneOrNamed>,
}

/// Where knowledge of the links comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Links {
    #[default]
    Unknown,
    Model,
}

/// What `[inertia]` comes to.
pub(super) fn resolve(context: &Context<'_>, table: &InertiaTable) -> Result<InertiaKnowledge, FileError> {
    let relative = Field::new("inertia").key("relative_std");
    match (table.links, &table.relative_std) {
        (Links::Unknown, None) => Ok(InertiaKnowledge::Unknown),
        (Links::Unknown, Some(_)) => Err(context
            .document
            .error(&relative, "of unknown links nothing is known: write links = \"model\", or leave it out")),
        (Links::Model, None) => {
            let message = "how well is the model known? add relative_std, 0.1 for ten per cent of each value, or by link \
                           { link2 = 0.1 }";
            Err(context.document.error(&relative, message))
        }
        (Links::Model, Some(std)) => {
            let links = ("link", context.link_names.as_slice());
            let what = ("a relative standard deviation", "no unit, such as 0.1");
            let relative_std = context.document.positive_by_name(&relative, std, links, what)?;
            check_known(context, &relative_std)?;
            Ok(InertiaKnowledge::Model { relative_std })
        }
    }
}

/// A link that is said to be known needs a mass in the robot's file.
fn check_known(context: &Context<'_>, relative_std: &[Option<f64>]) -> Result<(), FileError> {
    let links = context.robot.chain.links().iter().zip(relative_std);
    let unknown = links.filter(|(link, std)| std.is_some() && link.inertia.is_none());
    let unknown: Vec<&str> = unknown.map(|(link, _)| link.name.as_str()).collect();
    if unknown.is_empty() {
        return Ok(());
    }
    let message = format!(
        "the model needs the mass of every link, but {} has none for {}: add them there, name only other links in \
         relative_std, or write links = \"unknown\"",
        context.robot_path.display(),
        unknown.join(", ")
    );
    Err(context.document.error(&Field::new("inertia").key("links"), message))
}
