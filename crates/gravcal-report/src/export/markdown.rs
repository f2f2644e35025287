//! A Markdown table for people: each value rounded to the second digit of its standard deviation, offsets of angles in degrees.

use super::rows::{Row, Status, conventions, rows};
use super::{Export, Exported, head};
use crate::sensor_row::shown_unit;
use gravcal_robot_model::number::{measured, shortest};

pub(super) fn export(export: &Export<'_>) -> Exported {
    let rows = rows(export.estimate);
    let head: String = head(export, &said(&rows), &[]).iter().map(|line| format!("{}\n\n", escaped(line))).collect();
    let rows: String = rows.iter().map(line).collect();
    let text = format!("{head}| parameter | unit | value | ± | nominal |\n|---|---|---:|---:|---:|\n{rows}");
    Exported { text, remarks: Vec::new() }
}

/// What both tables for people say: the convention of each quantity in them, and what the numbers are.
pub(super) fn said(rows: &[Row<'_>]) -> Vec<String> {
    let mut said = conventions(rows);
    said.push("Torque is what the joint exerts to carry gravity.".to_owned());
    said.push("Value and standard deviation, rounded to the second digit of the latter.".to_owned());
    said
}

fn line(row: &Row<'_>) -> String {
    let [unit, value, std, nominal] = cells(row);
    format!("| {} | {} | {value} | {std} | {nominal} |\n", escaped(&row.name), escaped(&unit))
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

/// Every character that Markdown gives a meaning, with a backslash before it.
fn escaped(text: &str) -> String {
    const SPECIAL: &str = "\\|_*`<>[]&~$#";
    text.chars().flat_map(|c| SPECIAL.contains(c).then_some('\\').into_iter().chain([c])).collect()
}
