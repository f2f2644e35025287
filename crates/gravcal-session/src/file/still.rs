//! `[readings.still]`: the tables are recordings of an arm in motion, and poses are the standstills found in them.

use gravcal_recording::{PoseMapping, ReadingColumn, Selection, Stillness};
use serde::Deserialize;

use super::context::Context;
use crate::document::{Field, FileError};

/// `[readings.still]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct StillTable {
    /// Shorter standstills are left out.
    ///
    /// Default: 0.1, and a third of their median.
    /// Example: `least_duration_s = 1.0`
    least_duration_s: Option<f64>,
}

fn field() -> Field {
    Field::new("readings").key("still")
}

/// What it comes to. What a recording says itself, `[readings]` must not say.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &StillTable,
    mapping: &PoseMapping,
) -> Result<Stillness, FileError> {
    let document = context.document;
    let least_duration = table
        .least_duration_s
        .map(|duration| document.positive(&field().key("least_duration_s"), duration, "a duration", "s"));
    refuse_said_twice(context, &field(), mapping)?;
    Ok(Stillness { least_duration: least_duration.transpose()?, ..Stillness::default() })
}

/// Of recordings in motion, which `field` says that the tables are, some things cannot be said.
pub(super) fn refuse_said_twice(context: &Context<'_>, field: &Field, mapping: &PoseMapping) -> Result<(), FileError> {
    match said_twice(mapping) {
        Some(what) => {
            let message = format!("poses are found in the recordings, and {what}");
            Err(context.document.error(field, message))
        }
        None => Ok(()),
    }
}

/// What a mapping says that is found in the recording, or has no meaning there.
fn said_twice(mapping: &PoseMapping) -> Option<&'static str> {
    let readings =
        || mapping.torques.iter().flatten().map(|(column, _)| column).chain(mapping.instruments.iter().flatten());
    let noise = |column: &ReadingColumn| {
        column.std.is_some() || column.std_column.is_some() || column.count.is_some() || column.count_column.is_some()
    };
    if readings().any(noise) {
        return Some("so is the noise of each mean: delete std, count, std_columns and count_columns");
    }
    if readings().any(|column| column.usable_column.is_some()) {
        return Some("what cannot be used is an empty cell there: delete usable_columns");
    }
    if mapping.merge_repeated || mapping.sweep_column.is_some() {
        return Some("no rows are merged or labelled there: delete merge_repeated_rows and sweep_column");
    }
    if !mapping.conditions.direction.is_empty() || mapping.conditions.acceleration.is_known() {
        return Some("so is the side from which each joint came: delete direction and acceleration");
    }
    (mapping.selection != Selection::default()).then_some("how the arm moves in them is looked after: delete select")
}
