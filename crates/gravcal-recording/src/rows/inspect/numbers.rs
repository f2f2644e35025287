//! The numbers that names of columns carry, such as the 3 of `J3 [°]`: in most tables those of the joints.

use super::names::without_unit;
use crate::rows::joint_state::ColumnName;

/// The numbers in the names of columns, where each name carries one (in units and topics none counts) and no two the same.
pub fn column_numbers<'a>(columns: impl IntoIterator<Item = &'a str>) -> Option<Vec<u64>> {
    let mut numbers = Vec::new();
    for column in columns {
        let number = column_number(column)?;
        if numbers.contains(&number) {
            return None;
        }
        numbers.push(number);
    }
    Some(numbers)
}

fn column_number(column: &str) -> Option<u64> {
    let (head, _) = without_unit(column);
    let name = ColumnName::parse(&head).map_or(head.as_str(), |name| name.joint);
    let mut numbers = name.split(|letter: char| !letter.is_ascii_digit()).filter(|digits| !digits.is_empty());
    let first = numbers.next()?;
    if numbers.next().is_none() { first.parse().ok() } else { None }
}

/// Whether both lists have the same numbers, in whatever order.
pub fn are_same_numbers(these: &[u64], those: &[u64]) -> bool {
    these.len() == those.len() && these.iter().all(|number| those.contains(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_has_one_number_of_its_own_or_none_counts() {
        let numbers = |columns: &[&str]| column_numbers(columns.iter().copied());
        assert_eq!(numbers(&["J1 [°]", "J3 [°]", "T6 (m/s)"]), Some(vec![1, 3, 6]));
        assert_eq!(numbers(&["/arm1:joint_a7.position", "joint_a2.position"]), Some(vec![7, 2]));
        for none in [&["J1", "J"][..], &["J1", "T1"], &["ur10_joint_1"], &["elbow"], &["q99999999999999999999999"]] {
            assert_eq!(numbers(none), None, "{none:?}");
        }
        assert!(are_same_numbers(&[1, 3, 2], &[2, 1, 3]) && !are_same_numbers(&[1, 2], &[0, 1]));
        assert!(!are_same_numbers(&[1], &[1, 2]));
    }
}
