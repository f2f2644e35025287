//! Recordings that others wrote, in `GRAVCAL_SHARED_DATA` or `../shared/data` beside the project; a test says where they
//! are not there.

#![allow(clippy::unwrap_used)] // also in the functions that the tests share

use std::fs;
use std::path::{Path, PathBuf};

use gravcal_recording::{Row, Rows, open};

/// Where a file of the shared data is; says so if it is not there.
fn shared(path: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let found = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from).join(path);
    if !found.exists() {
        println!("skipped: there is no {}", found.display());
        return None;
    }
    Some(found)
}

fn all(rows: &mut dyn Rows) -> Vec<Vec<f64>> {
    let mut row = Row::default();
    let mut all = Vec::new();
    while rows.read(&mut row).unwrap() {
        assert_eq!(row.cells.len(), rows.columns().len());
        all.push(row.cells.clone());
    }
    all
}

/// Cells as bits, so that equal is the same.
fn bits(rows: &[Vec<f64>]) -> Vec<Vec<u64>> {
    rows.iter().map(|cells| cells.iter().map(|cell| cell.to_bits()).collect()).collect()
}

const KUKA: [&str; 5] = [
    "kuka_mcap-ros2-support_none.mcap",
    "kuka_mcap-ros2-support_lz4.mcap",
    "kuka_mcap-ros2-support_zstd.mcap",
    "rosbags_bag/rosbags_bag.mcap",
    "rosbags_bag",
];

fn kuka(name: &str) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let mut rows = open(&shared("mcap/kuka_jointstate")?.join(name)).unwrap();
    let read = all(rows.as_mut());
    assert_eq!(rows.remarks(), Vec::<String>::new(), "{name}");
    assert_eq!(rows.progress(), 1.0, "{name}");
    Some((rows.columns().to_vec(), read))
}

#[test]
fn two_writers_and_three_compressions_say_the_same_bits() {
    let Some((columns, first)) = kuka(KUKA[0]) else { return };
    assert_eq!((columns.len(), first.len()), (22, 1006));
    for name in &KUKA[1..] {
        let Some((others, rows)) = kuka(name) else { return };
        assert_eq!(columns, others, "{name}");
        assert_eq!(bits(&first), bits(&rows), "{name}");
    }
}

#[test]
fn first_and_last_message_are_as_expected() {
    let Some((_, rows)) = kuka(KUKA[0]) else { return };
    let text = fs::read_to_string(shared("mcap/kuka_jointstate/expected_first_last.csv").unwrap()).unwrap();
    let expected: Vec<Vec<f64>> =
        text.lines().map(|line| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect()).collect();
    let found = [&rows[0], &rows[rows.len() - 1]].map(|row| row[1..].to_vec());
    assert_eq!(bits(&found), bits(&expected));
}

#[test]
fn the_bag_is_every_fifth_row_of_the_table_to_its_nine_digits() {
    let (Some((_, rows)), Some(table)) = (kuka(KUKA[0]), shared("kuka_lwr4/recording_1.csv")) else { return };
    let table: Vec<Vec<f64>> = all(open(&table).unwrap().as_mut()).into_iter().step_by(5).collect();
    assert_eq!(rows.len(), table.len());
    for (row, (found, expected)) in rows.iter().zip(&table).enumerate() {
        let time = found[0] - rows[0][0];
        assert!((time - expected[0]).abs() < 1e-6, "row {row}: {time} and {} s", expected[0]);
        for (found, expected) in found[1..].iter().zip(&expected[1..]) {
            // Half a unit in the ninth digit.
            let digit = 10_f64.powi(expected.abs().log10().floor() as i32 - 8);
            assert!((found - expected).abs() <= 0.500_001 * digit, "row {row}: {found} and {expected}");
        }
    }
}

#[test]
fn a_bag_of_many_types_without_statistics_is_read() {
    let Some(path) = shared("mcap/test_bag_mcap.mcap") else { return };
    let mut rows = open(&path).unwrap();
    let columns: Vec<&str> = rows.columns()[1..].iter().map(String::as_str).collect();
    let names = |quantity| (1..=3).map(move |joint| format!("joint{joint}.{quantity}"));
    let expected: Vec<String> = ["position", "velocity", "effort"].into_iter().flat_map(names).collect();
    assert_eq!(columns, expected);
    let read = all(rows.as_mut());
    assert!(!read.is_empty());
    for row in &read {
        assert_eq!(row[1..], [0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 1.0, 2.0, 3.0]);
    }
    assert_eq!(rows.remarks(), Vec::<String>::new());
}

#[test]
fn bags_in_sqlite_are_read() {
    for (name, robot, rows, length) in [("ur10", "shoulder_pan_joint", 3441, 27.52), ("panda", "fer_joint1", 727, 24.2)]
    {
        let Some(path) = shared(&format!("bags_sqlite/{name}_exciting_trajectory.db3")) else { return };
        let mut bag = open(&path).unwrap();
        assert_eq!(bag.columns()[..2], ["time_s".to_owned(), format!("{robot}.position")]);
        let read = all(bag.as_mut());
        assert_eq!((read.len(), bag.remarks(), bag.progress()), (rows, Vec::new(), 1.0), "{name}");
        assert!(read.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{name}");
        let lasts = read[rows - 1][0] - read[0][0];
        assert!((lasts - length).abs() < 0.01, "{name}: {lasts} s");
        assert_eq!(bag.source().topics[0].messages, rows as u64);
    }
}
