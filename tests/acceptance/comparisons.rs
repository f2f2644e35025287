//! `gravcal compare`: which sensor moved between calibrations.

use std::fs;
use std::path::Path;

use crate::program::{Run, gravcal_in};
use crate::small_session::small_session;

/// The small session calibrated three times: as it is, with new noise, and with new noise and another gain of joint 2.
fn calibrated() -> tempfile::TempDir {
    let folder = small_session();
    let path = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str]| gravcal_in(folder.path(), arguments);
    assert!([0, 3].contains(&run(&["calibrate", "--full", "session.toml", "--output", "a"]).code));
    let simulation = fs::read_to_string(path("simulation.toml")).unwrap();
    let session = fs::read_to_string(path("session.toml")).unwrap();
    let sensor = "[[joint]]\nname = \"joint2\"\ntorque_sensor = { gain = { value = 7.2, unit = \"count/(N·m)\" }, \
                  bias = { value = 2048.0, unit = \"count\" } }\n";
    for (name, seed, more) in [("b", 2, ""), ("c", 3, sensor)] {
        let other = simulation.replace("seed = 1", &format!("seed = {seed}"));
        fs::create_dir(path(&format!("data-{name}"))).unwrap();
        fs::copy(path("robot.toml"), path(&format!("data-{name}/robot.toml"))).unwrap();
        fs::write(path(&format!("data-{name}/simulation.toml")), other + more).unwrap();
        let run = gravcal_in(&path(&format!("data-{name}")), ["simulate", "simulation.toml"]);
        assert_eq!(run.code, 0, "{run:?}");
        fs::write(path(&format!("data-{name}/session.toml")), &session).unwrap();
        let session = format!("data-{name}/session.toml");
        let run = gravcal_in(folder.path(), ["calibrate", "--full", &session, "--output", name]);
        assert!([0, 3].contains(&run.code), "{run:?}");
    }
    folder
}

#[test]
fn a_moved_gain_is_named_and_noise_is_not() {
    let folder = calibrated();
    let compare = |arguments: &[&str]| -> Run { gravcal_in(folder.path(), [&["compare"], arguments].concat()) };
    let [a, b, c] = ["a/calibration.json", "b/calibration.json", "c/calibration.json"];
    let same = compare(&[a, b]);
    assert_eq!(same.code, 0, "{same:?}");
    assert!(
        same.stdout.starts_with("Nothing that can be compared moved; not seen: ") && !same.stdout.contains("Warning"),
        "{same:?}"
    );
    let moved = compare(&[a, b, c]);
    assert_eq!(moved.code, 3, "{moved:?}");
    assert!(moved.stdout.starts_with("Moved: joint2 torque\n"), "{moved:?}");
    assert!(moved.stdout.contains("moved, most from 2 to 3"), "{moved:?}");
    assert!(moved.stdout.lines().all(|line| line.chars().count() <= 80), "{moved:?}");
    let json: serde_json::Value = serde_json::from_str(&compare(&[a, c, "--json"]).stdout).unwrap();
    assert_eq!(json["moved"], serde_json::json!(["joint2 torque"]));
    // Offsets that are choices of frames are not seen, whatever they do.
    let offsets = serde_json::json!(["joint1.position_offset", "joint3.position_offset"]);
    assert_eq!((&json["not_seen"], &json["gravity_stands_for"][0]), (&offsets, &offsets[0]));
    assert!(same.stdout.contains("joint3.position_offset") && same.stdout.contains("  gain only\n"), "{same:?}");
    assert_eq!(compare(&[a, c, "--quiet", "--json"]).refusal(&["--json", "--quiet"]), None);
    let quiet = compare(&[a, c, "--quiet"]);
    assert_eq!((quiet.code, quiet.stdout.as_str()), (3, ""));
    // The steps' standard deviations leave out the errors of the steps before.
    let reported = ["estimator `sequential` cannot be compared", "hint: leave --estimator away"];
    assert_eq!(compare(&[a, b, "--estimator", "sequential"]).refusal(&reported), None);
    other_robots(folder.path());
    // A calibration against itself shares its recordings.
    let itself = compare(&[a, a]);
    assert!(itself.code == 0 && itself.stdout.contains("Warning: some of these were made from the same"), "{itself:?}");
}

/// Other names, another description and other units of the same numbers.
fn other_robots(folder: &Path) {
    let text = fs::read_to_string(folder.join("b/calibration.json")).unwrap();
    let compare = |name: &str, changed: String| {
        fs::write(folder.join(name), changed).unwrap();
        gravcal_in(folder, ["compare", "a/calibration.json", name])
    };
    let other = compare("other.json", text.replace("joint", "axis").replace("\"axis\"", "\"joint\""));
    let reported = ["a/calibration.json, other.json: no sensor is in all", "hint: compare calibrations of one robot"];
    assert_eq!(other.refusal(&reported), None);
    let volts = compare("volts.json", text.replace("count/(N·m)", "V/(N·m)"));
    assert_eq!(volts.refusal(&["a/calibration.json and volts.json: joint1.torque_gain is in count/(N·m)"]), None);
    let mut changed: serde_json::Value = serde_json::from_str(&text).unwrap();
    changed["provenance"]["inputs"][1]["sha256"] = "0".into();
    let run = compare("robot.json", changed.to_string());
    assert!(run.stdout.contains("Warning: their descriptions of the robot differ: robot.toml"), "{run:?}");
    let renamed = compare("renamed.json", text.replace("joint3.", "wrist."));
    assert!(renamed.stdout.contains("Warning: not in all of these: joint3 torque"), "{renamed:?}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = small_session();
    let compare = |arguments: &[&str]| gravcal_in(folder.path(), [&["compare"], arguments].concat());
    assert_eq!(compare(&["session.toml"]).refusal(&["2"]), None);
    assert_eq!(compare(&["session.toml", "robot.toml"]).refusal(&["session.toml: not a calibration.json"]), None);
    assert_eq!(compare(&["no.json", "robot.toml"]).refusal(&["no.json: cannot be read"]), None);
}
