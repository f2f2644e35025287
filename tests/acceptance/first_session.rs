//! From a recording to a first calibration: `simulate`, then `inspect --session`, then `calibrate`, and nothing written by hand but
//! what only a user knows.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;
use tempfile::TempDir;

use crate::answer::Estimator;
use crate::program::{Calibration, gravcal_in};
use crate::tree;

const SIMULATION: &str = r#"robot = "robot.toml"
seed = 5
gravity = { direction = [-3.43, -5.94, -7.00], magnitude_m_per_s2 = 9.80665 }
torque = { unit = "count", std = 0.8 }
position = { unit = "rad", std = 1e-5 }
recording = { rate_hz = 500, samples = 200, move_s = 0.5, settling_s = 0.3, vibration = 10, settling_time_constant_s = 0.04 }
random = [{ file = "bare.mcap", poses = 25 }, { file = "loaded.parquet", poses = 25, load = "plate" }]
load = [{ name = "plate", mass_kg = 1.724, link = "link3", position_m = [0.31, 0.05, 0.57] }]
"#;

/// A folder with two recordings, one with a load.
fn simulated() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let robot = tree::root().join("models/sarcos-dextrous-arm/robot.toml");
    fs::copy(robot, folder.path().join("robot.toml")).unwrap();
    fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    folder
}

#[derive(Deserialize)]
struct Truth {
    parameter: Vec<TrueParameter>,
}

#[derive(Deserialize)]
struct TrueParameter {
    name: String,
    value: f64,
}

/// Every parameter that the joint estimate determines is within five standard deviations of the truth. Gives how many these are.
fn assert_true(folder: &Path, joint: &Estimator) -> usize {
    let truth: Truth = tree::read_toml(&folder.join("truth.toml"));
    let truth: BTreeMap<String, f64> = truth.parameter.into_iter().map(|one| (one.name, one.value)).collect();
    let mut count = 0;
    for found in joint.estimated() {
        let (value, std) = (found.value.unwrap(), found.std.unwrap());
        assert!(
            (value - truth[&found.name]).abs() < 5.0 * std,
            "{}: {value} ± {std}, {}",
            found.name,
            truth[&found.name]
        );
        count += 1;
    }
    count
}

#[test]
fn a_recording_becomes_a_session_and_that_a_calibration() {
    let folder = simulated();
    let inspect = |file: &str, more: &[&str]| {
        gravcal_in(folder.path(), [&["inspect", file, "--robot", "robot.toml"], more].concat())
    };
    let drafted = ["--session", "first.toml"];
    let run = inspect("bare.mcap", &drafted);
    assert_eq!(run.code, 0, "{run:?}");
    for reported in
        ["bare.mcap: 25 standstills found", "It can be read, and has 25 poses. Next: gravcal check first.toml"]
    {
        assert!(run.stdout.contains(reported), "{}", run.stdout);
    }
    // Never over a session that is there, unless told.
    let again = inspect("bare.mcap", &drafted);
    assert_eq!(again.refusal(&["first.toml: there is such a file already", "--overwrite replaces it"]), None);
    assert_eq!(inspect("bare.mcap", &[&drafted[..], &["--overwrite"]].concat()).code, 0);

    let check = gravcal_in(folder.path(), ["check", "--full", "first.toml"]);
    assert_eq!(check.code, 3, "{check:?}");
    assert!(check.stdout.contains("common scale of all torque gains"), "{}", check.stdout);

    let calibration = Calibration::of(&folder.path().join("first.toml"));
    assert_eq!(calibration.run.code, 3, "{:?}", calibration.run);
    assert_true(folder.path(), &calibration.estimator("joint"));

    // What the recording says of itself is asked for: the mass of its load. With that, its place and the
    // bare poses everything is determined.
    let run = inspect("loaded.parquet", &["--session", "loaded.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(
        run.stdout.contains("note: the mass of the load that the recording names is to be filled in"),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("It cannot be read as it is: "), "{}", run.stdout);
    let session = folder.path().join("loaded.toml");
    let text = fs::read_to_string(&session).unwrap();
    assert!(text.contains("# mass_kg = …\nlink = \"link3\""), "{text}");
    let known = [
        ("# mass_kg = …", "mass_kg = 1.724"),
        ("# position_m = [0, 0, 0.1]", "position_m = [0.31, 0.05, 0.57]"),
        ("# hemisphere = [0, 0, -1]", "hemisphere = [0, 0, -1]"),
    ];
    let text = known.iter().fold(text, |text, (comment, known)| text.replace(comment, known));
    fs::write(&session, format!("{text}\n[[poses]]\nfile = \"bare.mcap\"\n")).unwrap();
    let calibration = Calibration::of(&session);
    let joint = calibration.estimator("joint");
    assert!(
        joint.undetermined.iter().all(|what| !format!("{what:?}").contains("torque_gain")),
        "{:?}",
        joint.undetermined
    );
    assert!(assert_true(folder.path(), &joint) >= 10);
}

/// A seven-joint arm on an upright base, few poses, and all cures followed but the tilt: what the first joint's readings show is noise,
/// which a gain of about zero explains. That is no sign of a sensor, and nothing to calibrate with.
#[test]
fn a_joint_that_carries_no_gravity_is_not_reported_to_be_reversed() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    fs::copy(tree::root().join("models/kuka-lbr-iiwa14/robot.toml"), file("robot.toml")).unwrap();
    let load = "name = \"plate\", mass_kg = 1.5, link = \"link7\", position_m = [0.05, 0, 0.1]";
    let simulation = format!(
        "robot = \"robot.toml\"\nseed = 3\ngravity = {{ direction = [0, 0, -1], magnitude_m_per_s2 = 9.80665 }}\n\
         torque = {{ unit = \"N·m\", std = 0.05 }}\nposition = {{ unit = \"rad\" }}\n\
         recording = {{ rate_hz = 200, samples = 100, move_s = 0.5, settling_s = 0.2 }}\n\
         random = [{{ file = \"bare.mcap\", poses = 15 }}, {{ file = \"loaded.mcap\", poses = 8, load = \"plate\" }}]\n\
         load = [{{ {load} }}]\n"
    );
    fs::write(file("simulation.toml"), simulation).unwrap();
    let simulated = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
    assert_eq!(simulated.code, 0, "{simulated:?}");
    let drafted = gravcal_in(
        folder.path(),
        ["inspect", "bare.mcap", "--robot", "robot.toml", "--session", "first.toml", "--quiet"],
    );
    assert_eq!(drafted.code, 0, "{drafted:?}");
    let text = fs::read_to_string(file("first.toml")).unwrap();
    let followed = text
        .replace("# hemisphere", "hemisphere")
        .replace("links = \"unknown\"", "links = \"model\"\nrelative_std = 0.1");
    let loads = load.replace(", ", "\n").replace("[0.05\n0\n0.1]", "[0.05, 0, 0.1]");
    let followed = format!("{followed}\n[[load]]\n{loads}\n\n[[poses]]\nfile = \"loaded.mcap\"\nload = \"plate\"\n");
    fs::write(file("first.toml"), followed).unwrap();

    let calibration = Calibration::of(&file("first.toml"));
    assert_eq!(calibration.run.code, 3, "{:?}", calibration.run);
    assert!(!calibration.run.stdout.contains("of the other sign"), "{}", calibration.run.stdout);
    let joint = calibration.estimator("joint");
    let open: Vec<&str> = joint.parameters.iter().filter(|p| p.value.is_none()).map(|p| p.name.as_str()).collect();
    assert_eq!(open, ["joint1.torque_gain", "joint1.position_gain"]);
    assert_eq!(assert_true(folder.path(), &joint), 25);
}

/// A joint that is always in motion, and no standstill to be found: what to do is told, unless a session tells it.
#[test]
fn a_recording_without_poses_leads_on() {
    let folder = tempfile::tempdir().unwrap();
    let row = |k: u32| {
        let t = 0.01 * f64::from(k);
        format!("{t:.2},{:.6},{:.4}\n", (3.0 * t).sin(), 5.0 * (3.0 * t).cos())
    };
    let rows: String = (0..2000).map(row).collect();
    fs::write(folder.path().join("moving.csv"), format!("time_s,a.position,a.effort\n{rows}")).unwrap();
    let run = gravcal_in(folder.path(), ["inspect", "moving.csv"]);
    assert_eq!(run.code, 0, "{run:?}");
    for reported in
        ["No pose was found.", "[readings.still]", "[readings.sweeps]", "[readings.motion]", "--session OUT.toml"]
    {
        assert!(run.stdout.contains(reported), "{reported}: {}", run.stdout);
    }
    let drafted = gravcal_in(folder.path(), ["inspect", "moving.csv", "--session", "session.toml"]);
    assert!(drafted.code == 0 && !drafted.stdout.contains("No pose was found."), "{drafted:?}");
    assert!(fs::read_to_string(folder.path().join("session.toml")).unwrap().contains("[readings.motion]"));
}

#[test]
fn what_is_found_is_reported_to_programs_and_a_wrong_robot_is_refused() {
    let folder = simulated();
    let run = gravcal_in(folder.path(), ["inspect", "bare.mcap", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((&json["poses_found"], json["columns"].as_array().unwrap().len()), (&25.into(), 6));
    let iiwa = tree::root().join("models/kuka-lbr-iiwa14/robot.toml");
    let other =
        gravcal_in(folder.path(), ["inspect", "bare.mcap", "--robot", &iiwa.to_string_lossy(), "--session", "a.toml"]);
    assert_eq!(other.refusal(&["the joints whose positions are recorded are joint1, joint2, joint3"]), None);
    assert!(!folder.path().join("a.toml").exists());
}
