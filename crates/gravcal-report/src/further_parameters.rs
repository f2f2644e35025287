//! Parameters beyond the four of each joint's affine sensors: a line for each quantity that several joints have, a line for each instrument.

use crate::joint_table::Entry;
use crate::sensor_row::{shown_unit, split_name};
use crate::text::wrapped;

/// What is not estimated is not shown: a line has room for few numbers, and the full table has all.
pub(crate) fn further_parameters(entries: &[Entry<'_>]) -> String {
    let joints = owners(entries.iter().filter(|entry| entry.is_in_table()));
    let further: Vec<&Entry<'_>> =
        entries.iter().filter(|entry| !entry.is_in_table() && entry.cell != Entry::FIXED).collect();
    let of_joint = |entry: &&Entry<'_>| joints.contains(&split_name(entry.name).0);
    let (of_joints, others): (Vec<_>, Vec<_>) = further.into_iter().partition(of_joint);
    let mut quantities: Vec<&str> = of_joints.iter().map(|entry| split_name(entry.name).1).collect();
    let mut seen = Vec::new();
    quantities.retain(|quantity| {
        !seen.contains(quantity) && {
            seen.push(*quantity);
            true
        }
    });
    let by_quantity = quantities.into_iter().map(|quantity| {
        let own: Vec<&Entry<'_>> =
            of_joints.iter().filter(|entry| split_name(entry.name).1 == quantity).copied().collect();
        of_quantity(quantity, &own, own.len() == joints.len())
    });
    let by_owner = owners(others.iter().copied()).into_iter().map(|owner| {
        let own = others.iter().filter(|entry| split_name(entry.name).0 == owner);
        let told: Vec<String> = own.map(|entry| told(split_name(entry.name).1, entry)).collect();
        match owner {
            "" => wrapped("", "  ", &told.join(", ")),
            owner => wrapped("", "  ", &format!("{owner}: {}", told.join(", "))),
        }
    });
    by_quantity.chain(by_owner).collect()
}

/// `coulomb_friction of each joint, N·m: 0.94(6), 0.52(7)`, or with the joints' names where not all have it.
fn of_quantity(quantity: &str, own: &[&Entry<'_>], all: bool) -> String {
    let unit = shown_unit(own[0].unit).0;
    let alike = own.iter().all(|entry| shown_unit(entry.unit).0 == unit);
    let told: Vec<String> = own
        .iter()
        .map(|entry| match (all, alike) {
            (true, true) => entry.cell.clone(),
            (false, true) => format!("{} {}", split_name(entry.name).0, entry.cell),
            _ => told(split_name(entry.name).0, entry),
        })
        .collect();
    let of = if all { " of each joint" } else { "" };
    let unit = if alike { format!(", {unit}") } else { String::new() };
    wrapped("", "  ", &format!("{quantity}{of}{unit}: {}", told.join(", ")))
}

fn told(name: &str, entry: &Entry<'_>) -> String {
    match entry.cell.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
        true => format!("{name} {} {}", entry.cell, shown_unit(entry.unit).0),
        false => format!("{name} {}", entry.cell),
    }
}

/// Whose parameters these are, each once.
fn owners<'e, 'n: 'e>(entries: impl Iterator<Item = &'e Entry<'n>>) -> Vec<&'e str> {
    let mut owners = Vec::new();
    for entry in entries {
        let owner = split_name(entry.name).0;
        if !owners.contains(&owner) {
            owners.push(owner);
        }
    }
    owners
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry<'a>(name: &'a str, unit: &'a str, cell: &str) -> Entry<'a> {
        Entry { name, unit, cell: cell.into() }
    }

    #[test]
    fn a_quantity_of_several_joints_has_one_line_and_so_has_an_instrument() {
        let entries = [
            entry("a.torque_bias", "N·m", "0.1(1)"),
            entry("b.torque_bias", "N·m", "0.1(1)"),
            entry("a.coulomb_friction", "N·m", "0.94(6)"),
            entry("b.coulomb_friction", "N·m", "open"),
            entry("b.torque_gain_2", "N·m/(N·m)^2", "0.01(1)"),
            entry("wrist.gain_fx", "N/N", "fixed"),
            entry("wrist.bias_fx", "N", "9.08(1)"),
            entry("wrist.mass", "kg", "determined"),
        ];
        assert_eq!(
            further_parameters(&entries),
            "coulomb_friction of each joint, N·m: 0.94(6), open\n\
             torque_gain_2, N·m/(N·m)^2: b 0.01(1)\n\
             wrist: bias_fx 9.08(1) N, mass determined\n"
        );
        assert_eq!(further_parameters(&entries[..2]), "");
    }
}
