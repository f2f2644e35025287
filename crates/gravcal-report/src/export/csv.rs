//! Every parameter in a row, with all digits, in SI units and rad: `parameter, unit, value, std, ci95_low, ci95_high, nominal, status,
//! note, convention`. What is not determined has an empty value; what is held has the value at which it is, and no deviation.
//!
//! The convention stands in a column of its own, as CSV has no comments that every reader skips.

use super::numbers::float;
use super::rows::{Row, Status, rows};
use super::{Export, Exported};

const HEADER: [&str; 10] =
    ["parameter", "unit", "value", "std", "ci95_low", "ci95_high", "nominal", "status", "note", "convention"];

pub(super) fn export(export: &Export<'_>) -> Exported {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut records = vec![HEADER.map(str::to_owned)];
    records.extend(rows(export.estimate).iter().map(record));
    // Neither can fail: it is written to memory, and all records have one length.
    let written = records.iter().try_for_each(|record| writer.write_record(record));
    let bytes = writer.into_inner().unwrap_or_default();
    debug_assert!(written.is_ok());
    Exported { text: String::from_utf8_lossy(&bytes).into_owned(), remarks: Vec::new() }
}

fn record(row: &Row<'_>) -> [String; 10] {
    let number = |value: Option<f64>| value.map_or_else(String::new, float);
    let (value, std, ci95, status, note) = match row.status {
        Status::Determined { value, std, ci95 } => (Some(value), std, ci95, "determined", ""),
        Status::Held { value, why } => (Some(value), None, None, "held", why),
        Status::Undetermined => (None, None, None, "undetermined", ""),
    };
    let [low, high] = ci95.map_or([None; 2], |interval| interval.map(Some));
    [
        row.name.clone(),
        row.unit.to_owned(),
        number(value),
        number(std),
        number(low),
        number(high),
        number(row.nominal),
        status.to_owned(),
        note.to_owned(),
        row.convention.to_owned(),
    ]
}
