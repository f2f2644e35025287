//! Parameters beyond the four of each joint's affine sensors: a line for each quantity that several joints have, a line for each instrument.

use crate::joint_table::{Entry, each_once};
use crate::sensor_row::{shown_unit, split_name};
use crate::text::wrapped;

/// What is not estimated is not shown: a line has room for few numbers, and the full table has all.
pub(crate) fn further_parameters(entries: &[Entry<'_>]) -> String {
    let joints = each_once(entries.iter().filter(|entry| entry.is_in_table()).map(owner));
    let further = entries.iter().filter(|entry| !entry.is_in_table() && entry.cell != Entry::FIXED);
    let (of_joints, others): (Vec<&Entry<'_>>, Vec<_>) = further.partition(|entry| joints.contains(&owner(entry)));
    let by_quantity = each_once(of_joints.iter().copied().map(quantity)).into_iter().map(|name| {
        let own: Vec<&Entry<'_>> = of_joints.iter().filter(|entry| quantity(entry) == name).copied().collect();
        of_quantity(name, &own, own.len() == joints.len())
    });
    let by_owner = each_once(others.iter().copied().map(owner)).into_iter().map(|name| {
        let own = others.iter().filter(|entry| owner(entry) == name);
        let reported: Vec<String> = own.map(|entry| reported(quantity(entry), entry)).collect();
        let of = if name.is_empty() { String::new() } else { format!("{name}: ") };
        wrapped("", "  ", &format!("{of}{}", reported.join(", ")))
    });
    by_quantity.chain(by_owner).collect()
}

fn owner<'a>(entry: &'a Entry<'_>) -> &'a str {
    split_name(entry.name).0
}

fn quantity<'a>(entry: &'a Entry<'_>) -> &'a str {
    split_name(entry.name).1
}

/// `coulomb_friction of each joint, N·m: 0.94(6), 0.52(7)`, or with the joints' names where not all have it.
fn of_quantity(quantity: &str, own: &[&Entry<'_>], all: bool) -> String {
    let unit = shown_unit(own[0].unit).0;
    let alike = own.iter().all(|entry| shown_unit(entry.unit).0 == unit);
    let reported: Vec<String> = own
        .iter()
        .map(|entry| match (all, alike) {
            (true, true) => entry.cell.clone(),
            (false, true) => format!("{} {}", owner(entry), entry.cell),
            _ => reported(owner(entry), entry),
        })
        .collect();
    let of = if all { " of each joint" } else { "" };
    let unit = if alike { format!(", {unit}") } else { String::new() };
    wrapped("", "  ", &format!("{quantity}{of}{unit}: {}", reported.join(", ")))
}

fn reported(name: &str, entry: &Entry<'_>) -> String {
    match entry.cell.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
        true => format!("{name} {} {}", entry.cell, shown_unit(entry.unit).0),
        false => format!("{name} {}", entry.cell),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_table::tests::entry;

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
