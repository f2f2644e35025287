//! `[inertia]`: what is known of the links' masses and moments.

use serde::Deserialize;

use super::Context;
use crate::document::{Field, FileError};
use crate::session::InertiaKnowledge;

/// `[inertia]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct InertiaTable {
    #[serde(default)]
    links: Links,
    relative_std: Option<f64>,
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
    match (table.links, table.relative_std) {
        (Links::Unknown, None) => Ok(InertiaKnowledge::Unknown),
        (Links::Unknown, Some(_)) => Err(context
            .document
            .error(&relative, "of unknown links nothing is known: write links = \"model\", or leave it out")),
        (Links::Model, None) => {
            let message = "how well is the model known? add relative_std, 0.1 for ten per cent of each value";
            Err(context.document.error(&relative, message))
        }
        (Links::Model, Some(std)) => {
            check_all_known(context)?;
            let what = "a relative standard deviation";
            let relative_std = context.document.positive(&relative, std, what, "no unit, such as 0.1")?;
            Ok(InertiaKnowledge::Model { relative_std })
        }
    }
}

fn check_all_known(context: &Context<'_>) -> Result<(), FileError> {
    let links = context.robot.chain.links().iter();
    let unknown: Vec<&str> = links.filter(|link| link.inertia.is_none()).map(|link| link.name.as_str()).collect();
    if unknown.is_empty() {
        return Ok(());
    }
    let message = format!(
        "the model needs the mass of every link, but {} has none for {}: add them there, or write links = \"unknown\"",
        context.robot_path.display(),
        unknown.join(", ")
    );
    Err(context.document.error(&Field::new("inertia").key("links"), message))
}
