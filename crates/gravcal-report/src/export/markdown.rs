//! A Markdown table for people: each value rounded to the second digit of its standard deviation, offsets of angles in degrees.

use super::rows::{Row, Status, rows};
use super::{Export, Exported, head};
use crate::number::{measured, shortest};
use crate::sensor_row::shown_unit;

/// What both tables for people say.
pub(super) const CONVENTION: [&str; 2] = [
    "reading = torque_gain * torque + torque_bias, coordinate = position_gain * reading + position_offset; torque is what the \
     joint exerts to carry gravity, gravity points down in base coordinates.",
    "Value and standard deviation, rounded to the second digit of the latter.",
];

pub(super) fn export(export: &Export<'_>) -> Exported {
    let head: String = head(export, &CONVENTION, &[]).iter().map(|line| format!("{}\n\n", escaped(line))).collect();
    let rows: String = rows(export.estimate).iter().map(line).collect();
    let text = format!("{head}| parameter | unit | value | ± | nominal |\n|---|---|---:|---:|---:|\n{rows}");
    Exported { text, remarks: Vec::new() }
}

fn line(row: &Row<'_>) -> String {
    let [unit, value, std, nominal] = cells(row);
    format!("| {} | {unit} | {value} | {std} | {nominal} |\n", escaped(&row.name))
}

/// Unit, value, standard deviation and nominal value in words.
pub(super) fn cells(row: &Row<'_>) -> [String; 4] {
    let (unit, factor) = shown_unit(row.unit);
    let nominal = row.nominal.map_or_else(String::new, |nominal| shortest(factor * nominal));
    let (value, std) = match row.status {
        Status::Determined { value, std: Some(std), .. } => measured(factor * value, factor * std),
        Status::Determined { value, .. } => (shortest(factor * value), String::new()),
        Status::Held { value, .. } => (shortest(factor * value), "held".to_owned()),
        Status::Undetermined => ("undetermined".to_owned(), String::new()),
    };
    [unit.to_owned(), value, std, nominal]
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('|', "\\|").replace('_', "\\_").replace('*', "\\*")
}
