//! One line for each joint, a column for each parameter of its affine sensors.

use crate::grid::{Cell, Grid, Side};
use crate::sensor_row::{shown_unit, split_name};

const COLUMNS: [&str; 4] = ["torque_gain", "torque_bias", "position_gain", "position_offset"];

/// What stands for one parameter.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    /// `joint1.torque_gain`.
    pub name: &'a str,
    /// As files have it.
    pub unit: &'a str,
    /// What is shown.
    pub cell: String,
}

impl Entry<'_> {
    /// In place of a number that is not estimated.
    pub const FIXED: &'static str = "fixed";

    /// Whether it has a place in the table.
    pub fn is_in_table(&self) -> bool {
        COLUMNS.contains(&split_name(self.name).1)
    }
}

/// The table of those that have a place in it, under the units of all; nothing where none has.
pub(crate) fn joint_table(entries: &[Entry<'_>]) -> String {
    let joints = each_once(entries.iter().filter(|entry| entry.is_in_table()).map(|entry| split_name(entry.name).0));
    if joints.is_empty() {
        return String::new();
    }
    let mut grid = Grid::new(vec![Side::Left, Side::Right, Side::Right, Side::Right, Side::Right]);
    let row =
        |first: &str, cells: [String; 4]| std::iter::once(Cell::text(first)).chain(cells.map(Cell::text)).collect();
    grid.row(row("", COLUMNS.map(|name| name.replace('_', " "))));
    grid.row(row("", COLUMNS.map(|name| common_unit(entries, name).to_owned())));
    for joint in joints {
        let cell = |name: &str| entries.iter().find(|entry| split_name(entry.name) == (joint, name));
        grid.row(row(joint, COLUMNS.map(|name| cell(name).map_or_else(String::new, |entry| entry.cell.clone()))));
    }
    grid.lines("")
}

/// Names in their order, without those that stand before.
pub(crate) fn each_once<'n>(names: impl Iterator<Item = &'n str>) -> Vec<&'n str> {
    let mut seen = Vec::new();
    for name in names {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    seen
}

fn common_unit<'a>(entries: &[Entry<'a>], name: &str) -> &'a str {
    let mut units =
        entries.iter().filter(|entry| split_name(entry.name).1 == name).map(|entry| shown_unit(entry.unit).0);
    let first = units.next().unwrap_or_default();
    if units.all(|unit| unit == first) { first } else { "several units" }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn entry<'a>(name: &'a str, unit: &'a str, cell: &str) -> Entry<'a> {
        Entry { name, unit, cell: cell.into() }
    }

    #[test]
    fn a_joint_has_one_line_and_other_parameters_none() {
        let entries = [
            entry("a.torque_gain", "N·m/(N·m)", "1.00(1)"),
            entry("a.position_offset", "rad", "fixed"),
            entry("a.coulomb_friction", "N·m", "0.1"),
            entry("b.torque_gain", "N/N", "open"),
        ];
        let reported = joint_table(&entries);
        let lines: Vec<&str> = reported.lines().collect();
        assert_eq!(lines.len(), 4, "{reported}");
        assert!(lines[0].contains("torque gain") && lines[1].contains("several units") && lines[1].contains("deg"));
        assert!(lines[2].starts_with('a') && lines[2].contains("1.00(1)") && lines[2].ends_with("fixed"));
        assert!(!entries[2].is_in_table() && joint_table(&entries[2..3]).is_empty());
    }
}
