//! `gravcal compare`: which sensor moved between calibrations.

use std::fs;

use crate::program::{Run, gravcal_in};
use crate::small_session::small_session;

/// The small session calibrated three times: as it is, with new noise, and with new noise and another gain of joint 2.
fn calibrated() -> tempfile::TempDir {
    let folder = small_session();
    let path = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str]| gravcal_in(folder.path(), arguments);
    assert!([0, 3].contains(&run(&["calibrate", "session.toml", "--output", "a"]).code));
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
        let run = gravcal_in(folder.path(), ["calibrate", &session, "--output", name]);
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
    assert!(same.stdout.starts_with("Nothing moved") && !same.stdout.contains("Warning"), "{same:?}");
    let moved = compare(&[a, b, c]);
    assert_eq!(moved.code, 3, "{moved:?}");
    assert!(moved.stdout.starts_with("Moved: joint2 torque\n"), "{moved:?}");
    assert!(moved.stdout.contains("moved, most from 2 to 3"), "{moved:?}");
    assert!(moved.stdout.lines().all(|line| line.chars().count() <= 80), "{moved:?}");
    let json: serde_json::Value = serde_json::from_str(&compare(&[a, c, "--json"]).stdout).unwrap();
    assert_eq!(json["moved"], serde_json::json!(["joint2 torque"]));
    let quiet = compare(&[a, c, "--quiet"]);
    assert_eq!((quiet.code, quiet.stdout.as_str()), (3, ""));
    // A calibration against itself shares its recordings.
    let itself = compare(&[a, a]);
    assert!(itself.code == 0 && itself.stdout.contains("Warning: some of these were made from the same"), "{itself:?}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = small_session();
    let compare = |arguments: &[&str]| gravcal_in(folder.path(), [&["compare"], arguments].concat());
    assert_eq!(compare(&["session.toml"]).refusal(&["2"]), None);
    assert_eq!(compare(&["session.toml", "robot.toml"]).refusal(&["session.toml: not a calibration.json"]), None);
    assert_eq!(compare(&["no.json", "robot.toml"]).refusal(&["no.json: cannot be read"]), None);
}
