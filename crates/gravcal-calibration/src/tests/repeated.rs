//! Rows that repeat others.

use crate::testing::sarcos_shoulder;

#[test]
fn copies_of_rows_are_found_and_chance_is_not() {
    let mut session = sarcos_shoulder().session(0);
    session.repeated = session.find_repeated();
    assert!(session.repeated_note().is_none());
    let copies: Vec<_> = session.poses[..40].to_vec();
    session.poses.extend(copies);
    session.repeated = session.find_repeated();
    let repeated = &session.repeated;
    assert!(repeated[repeated.len() - 40..].iter().all(|repeated| *repeated));
    assert_eq!(repeated.iter().filter(|repeated| **repeated).count(), 40);
    assert!(session.repeated_note().unwrap().starts_with("40 of 447 rows repeat another one"));
    let mut other = sarcos_shoulder().session(0);
    let copy = other.poses[0].clone();
    other.poses.push(copy);
    assert!(!other.find_repeated().contains(&true), "one may be chance");
}
