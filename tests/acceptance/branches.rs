//! Robots that branch, and joints that mimic others: described by URDF, simulated, checked and calibrated as a user would,
//! and what is wrong with them is told.

use std::fs;
use std::path::Path;

use serde::Deserialize;
use tempfile::TempDir;

use crate::answer::Estimator;
use crate::program::{Calibration, Run, gravcal_in};
use crate::tree;

/// A mast that leans, with a camera that tilts and an arm of two joints; of the arm's hand two fingers close together, and
/// the drive of one reads the force of both.
const URDF: &str = r#"<robot name="watcher">
  <link name="floor"/>
  <link name="mast"><inertial><origin xyz="0.05 0.1 0.4"/><mass value="4"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="camera"><inertial><origin xyz="0.2 0.05 0.03"/><mass value="1.5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0.2 0.02 0.03"/><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0.15 0.01 -0.02"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="thumb"><inertial><origin xyz="0.03 0.01 0"/><mass value="0.4"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="finger"><inertial><origin xyz="0.03 0.01 0"/><mass value="0.7"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lean" type="revolute"><parent link="floor"/><child link="mast"/><axis xyz="0 1 0"/>
    <limit lower="-0.6" upper="0.9" effort="1" velocity="1"/></joint>
  <joint name="tilt" type="revolute"><parent link="mast"/><child link="camera"/><origin xyz="0 0 0.9"/><axis xyz="0.6 0.8 0"/>
    <limit lower="-1.2" upper="1.2" effort="1" velocity="1"/></joint>
  <joint name="shoulder" type="revolute"><parent link="mast"/><child link="upper"/><origin xyz="0 0.2 0.7" rpy="0.5 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="hand"/><origin xyz="0.4 0 0" rpy="1 0 0"/><axis xyz="0 1 0"/></joint>
  <joint name="close-thumb" type="prismatic"><parent link="hand"/><child link="thumb"/><origin xyz="0.3 0.1 0"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.05" effort="1" velocity="1"/><mimic joint="close-finger" multiplier="0.5"/></joint>
  <joint name="close-finger" type="prismatic"><parent link="hand"/><child link="finger"/><origin xyz="0.3 -0.1 0"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.05" effort="1" velocity="1"/></joint>
</robot>
"#;

const TIPS: &str = r#"["camera", "thumb", "finger"]"#;

const SIMULATION: &str = r#"robot = { urdf = "watcher.urdf", base = "floor", tip = ["camera", "thumb", "finger"] }
seed = 5
gravity = { direction = [0.1, -0.2, -1], magnitude_m_per_s2 = 9.81 }
torque = { unit = ["N·m", "N·m", "N·m", "N·m", "N"], std = [0.03, 0.02, 0.02, 0.01, 0.02] }
position = { unit = ["rad", "rad", "rad", "rad", "m"] }
random = [
    { file = "bare.csv", poses = 60 },
    { file = "book.csv", poses = 60, load = "book" },
    { file = "book-again.csv", poses = 60, load = "book-again" },
]
load = [
    { name = "book", mass_kg = 1.2, link = "camera", position_m = [0.1, 0.05, 0.1] },
    { name = "book-again", mass_kg = 1.2, link = "camera", position_m = [0.2, -0.1, 0.04] },
]
load_distance = [{ between = ["book", "book-again"] }]

[[joint]]
name = "tilt"
torque_sensor = { gain = { value = 1.05, unit = "N·m/(N·m)" }, bias = { value = 0.3, unit = "N·m" } }

[[joint]]
name = "shoulder"
torque_sensor = { gain = { value = 0.94, unit = "N·m/(N·m)" }, bias = { value = -0.2, unit = "N·m" } }
position_sensor = { gain = { value = 1.004, unit = "rad/rad" }, offset = { value = 1.5, unit = "deg" } }

[[joint]]
name = "close-finger"
torque_sensor = { gain = { value = 1.1, unit = "N/N" }, bias = { value = 0.5, unit = "N" } }

[[force_torque_sensor]]
name = "pan"
link = "camera"
readings = { columns = ["fx", "fy", "fz", "nx", "ny", "nz"], unit = ["N", "N", "N", "N·m", "N·m", "N·m"], std = 0.02 }

[[accelerometer]]
name = "imu"
link = "hand"
readings = { columns = ["ax", "ay", "az"], unit = "g", std = 0.002 }

[instrument_truth.pan]
biases = [0.5, -0.3, 0.2, 0.01, 0.02, -0.03]
tool_mass_kg = 0.8

[instrument_truth.imu]
biases = [0.004, -0.003, 0.002]
"#;

#[derive(Deserialize)]
struct Truth {
    gravity_m_per_s2: [f64; 3],
    parameter: Vec<TrueParameter>,
}

#[derive(Deserialize)]
struct TrueParameter {
    name: String,
    value: f64,
}

fn simulated() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("watcher.urdf"), URDF).unwrap();
    fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    folder
}

/// Puts another text into a file of the folder.
fn change(folder: &Path, file: &str, old: &str, new: &str) {
    let path = folder.join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(old), "`{old}` does not stand in {file}");
    fs::write(path, text.replace(old, new)).unwrap();
}

fn check(folder: &Path) -> Run {
    gravcal_in(folder, ["check", "--full", "session.toml"])
}

/// Every parameter with a value is within four standard deviations of the truth.
fn assert_near_the_truth(joint: &Estimator, truth: &Truth) {
    let gravity = joint.gravity.as_ref().unwrap();
    for axis in 0..3 {
        assert!(
            (gravity.vector_m_per_s2[axis] - truth.gravity_m_per_s2[axis]).abs() <= 4.0 * gravity.std_m_per_s2[axis]
        );
    }
    for parameter in &truth.parameter {
        let found = joint.parameters.iter().find(|found| found.name == parameter.name).unwrap();
        if let (Some(value), Some(std)) = (found.value, found.std) {
            assert!((value - parameter.value).abs() <= 4.0 * std + 1e-12, "{}: {value} ± {std}", found.name);
        }
    }
}

#[test]
fn a_robot_with_branches_coupled_fingers_and_instruments_is_calibrated() {
    let folder = simulated();
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    assert!(session.contains(&format!("tip = {TIPS}")), "{session}");
    // Fingers move by some centimetres only: of what they weigh and how far they go, one must be known.
    let known = "[[joint]]\nname = \"close-finger\"\nposition_gain = { fixed = 1.0, unit = \"m/m\" }\n\n[gravity]";
    change(folder.path(), "session.toml", "[gravity]", known);
    let checked = check(folder.path());
    assert_eq!(checked.code, 0, "{checked:?}");
    assert!(checked.stdout.contains("its steps go along one serial chain, and this robot branches"), "{checked:?}");

    let calibration = Calibration::of(&folder.path().join("session.toml"));
    assert_eq!(calibration.run.code, 0, "{}", calibration.run.stdout);
    let answer = calibration.answer();
    let joint = answer.estimators.iter().find(|estimator| estimator.name == "joint").unwrap();
    assert_near_the_truth(joint, &tree::read_toml(&folder.path().join("truth.toml")));
    let of = |name: &str| joint.parameters.iter().find(|found| found.name == name).unwrap();
    // The weight in the hand is that of the camera's branch, by way of the mast that carries both.
    for name in ["shoulder.torque_gain", "elbow.torque_gain", "close-finger.torque_gain", "pan.gain_fx"] {
        assert!(of(name).value.is_some(), "{name}: {}", calibration.run.stdout);
    }
    let note = "The torque of close-finger is also that of close-thumb, which mimics it";
    assert!(calibration.run.stdout.replace("\n    ", " ").contains(note), "{}", calibration.run.stdout);
}

#[test]
fn a_tip_for_each_branch_is_asked_for() {
    let folder = simulated();
    for (tips, message) in [
        (r#""finger""#, "watcher.urdf: joint `tilt` hangs on link `mast`, is not on the way from `floor` to `finger`"),
        (r#"["camera", "finger"]"#, "watcher.urdf: joint `close-thumb` hangs on link `hand`"),
        (r#"["camera", "hand", "finger"]"#, "watcher.urdf: tip `hand` is on the way to tip `finger`"),
        (r#"["camera", "thumb", "fingr"]"#, "tip link `fingr` is not in the URDF (did you mean `finger`?)"),
    ] {
        change(folder.path(), "session.toml", &format!("tip = {TIPS}"), &format!("tip = {tips}"));
        let run = check(folder.path());
        assert_eq!(run.code, 2, "{run:?}");
        assert!(run.stderr.replace("\n  ", " ").contains(message), "{message}: {run:?}");
        change(folder.path(), "session.toml", &format!("tip = {tips}"), &format!("tip = {TIPS}"));
    }
}

#[test]
fn what_branches_cannot_have_is_refused_with_a_cure() {
    let folder = simulated();
    let steps = gravcal_in(folder.path(), ["calibrate", "--full", "session.toml", "--estimator", "sequential"]);
    assert_eq!(steps.code, 2, "{steps:?}");
    assert!(steps.stderr.contains("choose `joint` (--estimator joint, or estimators = [\"joint\"])"), "{steps:?}");

    let refused = |old: &str, new: &str| {
        change(folder.path(), "session.toml", old, new);
        let run = check(folder.path());
        assert_eq!(run.code, 2, "{run:?}");
        change(folder.path(), "session.toml", new, old);
        run.stderr
    };
    let sweep = refused("[gravity]", "[inertia]\ndescription = \"sweep\"\n[gravity]");
    assert!(sweep.contains("some joints mimic others"), "{sweep}");
    let wrist = refused("link = \"camera\"\nname = \"pan\"\n", "name = \"pan\"\n");
    assert!(wrist.contains("on which link is it? add link = \"…\", one of camera, thumb, finger"), "{wrist}");
    let inner = refused("link = \"camera\"\nname = \"pan\"\n", "link = \"hand\"\nname = \"pan\"\n");
    assert!(inner.contains("there is no last link `hand`"), "{inner}");
    let both = refused("load = \"book-again\"", "load = [\"book\", \"book-again\"]");
    assert!(both.contains("a pose carries one load") && both.contains("one after the other"), "{both}");
}
