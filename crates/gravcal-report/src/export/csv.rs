//! Every parameter in a row, with all digits, in SI units and rad: `parameter, unit, value, std, ci95_low, ci95_high, nominal, status,
//! note, convention`. What is not determined has an empty value; what is fixed has the value at which it is, and no deviation.
//!
//! A text that a spreadsheet would compute has an apostrophe before it. The convention stands in a column of its own, as CSV has no comments that every reader skips.

use super::numbers::float;
use super::rows::{Row, Status, rows};
use super::{Export, ExportError, Exported};
use crate::spreadsheet::text_cell;

const HEADER: [&str; 10] =
    ["parameter", "unit", "value", "std", "ci95_low", "ci95_high", "nominal", "status", "note", "convention"];

pub(super) fn export(export: &Export<'_>) -> Result<Exported, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let refused = |error: &dyn std::error::Error| ExportError::Unwritable { why: error.to_string() };
    writer.write_record(HEADER).map_err(|error| refused(&error))?;
    for row in rows(export.estimate) {
        writer.write_record(record(&row)).map_err(|error| refused(&error))?;
    }
    let bytes = writer.into_inner().map_err(|error| refused(&error))?;
    let text = String::from_utf8(bytes).map_err(|error| refused(&error))?;
    Ok(Exported { text, remarks: Vec::new() })
}

fn record(row: &Row<'_>) -> [String; 10] {
    let number = |value: Option<f64>| value.map_or_else(String::new, float);
    let (value, std, ci95, status, note) = match row.status {
        Status::Determined { value, std, ci95 } => (Some(value), std, ci95, "determined", ""),
        Status::Held { value, why } => (Some(value), None, None, "held", why),
        Status::Undetermined => (None, None, None, "undetermined", ""),
    };
    let [low, high] = ci95.map_or([None; 2], |interval| interval.map(Some));
    let text = |text: &str| text_cell(text).into_owned();
    [
        text(&row.name),
        text(row.unit),
        number(value),
        number(std),
        number(low),
        number(high),
        number(row.nominal),
        status.to_owned(),
        text(note),
        text(row.convention),
    ]
}
