//! Recordings as users have them: `gravcal inspect` tells what is in one, `gravcal apply` writes it again calibrated.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use gravcal_recording::{Heading, Row, create, open};
use tempfile::TempDir;

use crate::program::{Run, gravcal_in};
use crate::small_session::small_session;
use crate::tree;

/// The small session, calibrated, and its first table as an MCAP file whose joints have the names of the table's columns.
struct Calibrated {
    folder: TempDir,
}

impl Calibrated {
    fn new() -> Calibrated {
        let calibrated = Calibrated { folder: small_session() };
        let run = calibrated.run(&["calibrate", "--full", "session.toml", "--output", "results"]);
        assert!([0, 3].contains(&run.code), "{run:?}");
        calibrated
    }

    fn run(&self, arguments: &[&str]) -> Run {
        gravcal_in(self.folder.path(), arguments)
    }

    fn apply(&self, more: &[&str]) -> Run {
        let given = ["apply", "results/calibration.json", "plate-a.csv", "out.csv"];
        self.run(&[&given[..], more].concat())
    }

    fn rows(&self, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
        rows(&self.folder.path().join(name))
    }
}

fn rows(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut rows = open(path).unwrap();
    let (mut row, mut all) = (Row::default(), Vec::new());
    while rows.read(&mut row).unwrap() {
        all.push(row.cells.clone());
    }
    (rows.columns().to_vec(), all)
}

/// The parameter of a calibration.
fn parameter(calibrated: &Calibrated, name: &str) -> f64 {
    let text = fs::read_to_string(calibrated.folder.path().join("results/calibration.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let joint = file["estimators"].as_array().unwrap().iter().find(|estimator| estimator["name"] == "joint").unwrap();
    let parameters = joint["parameters"].as_array().unwrap();
    parameters.iter().find(|parameter| parameter["name"] == name).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn a_table_becomes_torques_and_angles_and_little_is_left_without_gravity() {
    let calibrated = Calibrated::new();
    let run = calibrated.apply(&[]);
    assert_eq!(run.code, 0, "{run:?}");
    let (columns, before) = calibrated.rows("plate-a.csv");
    let (same, torques) = calibrated.rows("out.csv");
    assert_eq!((&columns, before.len()), (&same, torques.len()));
    let joints = columns.len() / 2;
    let value = |joint: usize, name: &str| parameter(&calibrated, &format!("joint{}.{name}", joint + 1));
    for joint in 0..joints {
        let [gain, bias] = ["torque_gain", "torque_bias"].map(|name| value(joint, name));
        for (before, torques) in before.iter().zip(&torques) {
            let expected = (before[joints + joint] - bias) / gain;
            assert!((torques[joints + joint] - expected).abs() < 1e-9);
        }
    }

    let run = calibrated.apply(&["--residual", "--load", "plate-a", "--overwrite"]);
    assert_eq!(run.code, 0, "{run:?}");
    let (_, left) = calibrated.rows("out.csv");
    for joint in 0..joints {
        // Noise of 0.8 count, in N·m.
        let noise = 0.8 / value(joint, "torque_gain").abs();
        let rms = (left.iter().map(|row| row[joints + joint].powi(2)).sum::<f64>() / left.len() as f64).sqrt();
        assert!(rms < 2.0 * noise, "joint {joint}: {rms} N·m left");
    }
}

#[test]
fn what_cannot_be_applied_is_refused_and_loses_nothing() {
    let calibrated = Calibrated::new();
    assert_eq!(calibrated.apply(&[]).code, 0);
    let old = fs::read(calibrated.folder.path().join("out.csv")).unwrap();
    let refused = |run: Run, reported: &[&str]| assert_eq!(run.refusal(reported), None);
    refused(calibrated.apply(&[]), &["there is such a file already", "--overwrite replaces it"]);
    let again = calibrated.run(&["apply", "results/calibration.json", "out.csv", "twice.csv"]);
    refused(again, &["it is calibrated already, by calibration.json (joint, sha256"]);
    let other = calibrated.run(&["apply", "results/calibration.json", "plate-a.csv", "out.mcap"]);
    refused(other, &["this is a CSV file, and becomes one"]);
    let load = calibrated.apply(&["--residual", "--load", "brick", "--overwrite"]);
    refused(load, &["the session has no load `brick`; it has plate-a, plate-b"]);
    let session = calibrated.folder.path().join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    fs::write(&session, format!("{text}\n# changed\n")).unwrap();
    refused(
        calibrated.apply(&["--overwrite"]),
        &["the session has changed since the calibration", "--session SESSION"],
    );
    assert_eq!(calibrated.apply(&["--overwrite", "--session", "session.toml"]).code, 0);
    assert_eq!(fs::read(calibrated.folder.path().join("out.csv")).unwrap(), old);
}

#[test]
fn a_bag_is_inspected_and_applied() {
    let calibrated = Calibrated::new();
    let (columns, table) = calibrated.rows("plate-a.csv");
    let joints = columns.len() / 2;
    let name = |quantity| (1..=joints).map(move |joint| format!("joint{joint}.{quantity}"));
    let heading = Heading {
        columns: ["time_s".to_owned()].into_iter().chain(name("position")).chain(name("effort")).collect(),
        metadata: [("load".to_owned(), "plate-a".to_owned())].into(),
    };
    let bag = calibrated.folder.path().join("bag.mcap");
    let mut writer = create(&bag, &heading, false).unwrap();
    for (row, cells) in table.iter().enumerate() {
        writer.write(&[&[0.1 * row as f64][..], cells].concat()).unwrap();
    }
    writer.finish().unwrap();

    let run = calibrated.run(&["inspect", "bag.mcap"]);
    assert_eq!(run.code, 0, "{run:?}");
    for reported in ["load = plate-a", "/joint_states", "joint1.position", "10.00 Hz"] {
        assert!(run.stdout.contains(reported), "{}", run.stdout);
    }
    let run = calibrated.run(&["inspect", "bag.mcap", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["rows"], table.len());

    // The same session, for the columns of the bag.
    let session = fs::read_to_string(calibrated.folder.path().join("session.toml")).unwrap();
    let mut other = session.clone();
    for (table_column, bag_column) in columns.iter().zip(&heading.columns[1..]) {
        other = other.replace(&format!("\"{table_column}\""), &format!("\"{bag_column}\""));
    }
    // Its tables, too: a session reads them.
    for table in ["bare.csv", "plate-a.csv", "plate-b.csv"] {
        let path = calibrated.folder.path().join(table);
        let mut text = fs::read_to_string(&path).unwrap();
        for (table_column, bag_column) in columns.iter().zip(&heading.columns[1..]) {
            text = text.replacen(table_column.as_str(), bag_column, 1);
        }
        fs::write(calibrated.folder.path().join(format!("bag-{table}")), text).unwrap();
        other = other.replace(&format!("\"{table}\""), &format!("\"bag-{table}\""));
    }
    fs::write(calibrated.folder.path().join("bag.toml"), other).unwrap();
    let given = ["apply", "results/calibration.json", "bag.mcap", "out.mcap", "--residual", "--session", "bag.toml"];
    let run = calibrated.run(&given);
    assert_eq!(run.code, 0, "{run:?}");
    let residual = calibrated.apply(&["--residual", "--load", "plate-a"]);
    assert_eq!(residual.code, 0, "{residual:?}");
    let (names, bag) = calibrated.rows("out.mcap");
    let (_, table) = calibrated.rows("out.csv");
    assert_eq!(names, heading.columns);
    for (bag, table) in bag.iter().zip(&table) {
        let same = bag[1..].iter().zip(table).all(|(bag, table)| (bag - table).abs() < 1e-9);
        assert!(same, "{bag:?} {table:?}");
    }
}

/// Ended by force midway, `apply` leaves the recording as it is and no half file under the final name; a temporary file stays until
/// the next try.
#[test]
fn apply_that_is_killed_leaves_no_half_file() {
    let calibrated = Calibrated::new();
    let folder = calibrated.folder.path();
    let small = fs::read_to_string(folder.join("plate-a.csv")).unwrap();
    let (header, rows) = small.split_once('\n').unwrap();
    let large = format!("{header}\n{}", rows.repeat(60_000));
    fs::write(folder.join("large.csv"), &large).unwrap();
    let given = ["apply", "results/calibration.json", "large.csv", "out.csv", "--session", "session.toml"];
    let mut apply = Command::new(env!("CARGO_BIN_EXE_gravcal")).args(given).current_dir(folder).spawn().unwrap();
    let begun = || {
        let temporary = |file: &PathBuf| tree::name(file).starts_with(".gravcal-");
        tree::entries(folder)
            .into_iter()
            .find(temporary)
            .is_some_and(|file| fs::metadata(file).is_ok_and(|f| f.len() > 0))
    };
    while !begun() {
        assert!(apply.try_wait().unwrap().is_none(), "it ended before it was seen to write");
        std::thread::sleep(Duration::from_millis(1));
    }
    apply.kill().unwrap();
    assert!(!apply.wait().unwrap().success());
    assert!(!folder.join("out.csv").exists());
    assert_eq!(fs::read_to_string(folder.join("large.csv")).unwrap(), large);
    // Nothing that is left stands in the way of another try.
    assert_eq!(calibrated.run(&given).code, 0);
    let left: Vec<String> = tree::entries(folder).iter().map(|file| tree::name(file)).collect();
    assert!(left.iter().all(|name| !name.starts_with(".gravcal-")), "{left:?}");
}
