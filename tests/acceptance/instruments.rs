//! A wrist sensor and an accelerometer: simulated, calibrated beside the joints' torques and without them, and what they
//! leave open is told.

use std::fs;
use std::path::Path;

use serde::Deserialize;
use tempfile::TempDir;

use crate::answer::Estimator;
use crate::program::{Calibration, gravcal_in};
use crate::tree;

const SIMULATION: &str = r#"robot = "robot.toml"
seed = 1
gravity = { direction = [-3.43, -5.94, -7.00], magnitude_m_per_s2 = 9.8 }
torque = { unit = "count", std = 0.8 }
position = { unit = "rad" }
random = [
    { file = "bare.csv", poses = 20 },
    { file = "plate.csv", poses = 20, load = "plate" },
]
load = [{ name = "plate", mass_kg = 1.724, link = "link3", position_m = [0.3108, 0.05, 0.5706] }]

[[force_torque_sensor]]
name = "wrist"
mounting = { position_m = [0.0, 0.0, 0.1], rpy_deg = [0, 0, 30] }
readings = { columns = ["fx", "fy", "fz", "nx", "ny", "nz"], unit = ["count", "count", "count", "N·m", "N·m", "N·m"], std = [1, 1, 1, 0.01, 0.01, 0.01] }
force_gain = { nominal = 20, unit = "count/N" }

[[accelerometer]]
name = "imu"
link = "link2"
mounting = { rpy_deg = [90, 0, 0] }
mounting_std_deg = 3
readings = { columns = ["ax", "ay", "az"], unit = "g", std = 0.002 }

[instrument_truth.wrist]
gains = [20.6, 19.5, 20.2, 1.03, 0.98, 1.01]
biases = [12, -7, 30, -0.15, 0.04, 0.09]
tool_mass_kg = 1.3
tool_moment_kg_m = [0.01, -0.02, 0.06]

[instrument_truth.imu]
biases = [0.004, -0.003, 0.002]
mounting_rotation_deg = [1, -2, 1.5]
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

/// A session simulated as above.
fn simulated() -> TempDir {
    simulated_of(SIMULATION)
}

fn simulated_of(simulation: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let robot = fs::read_to_string(tree::root().join("models/sarcos-dextrous-arm/robot.toml")).unwrap();
    fs::write(folder.path().join("robot.toml"), robot).unwrap();
    fs::write(folder.path().join("simulation.toml"), simulation).unwrap();
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    folder
}

/// Replaces a text of the session that stands there once.
fn change(folder: &Path, old: &str, new: &str) {
    let path = folder.join("session.toml");
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches(old).count(), 1, "`{old}` in {text}");
    fs::write(path, text.replace(old, new)).unwrap();
}

fn calibrate(folder: &Path) -> Calibration {
    Calibration::with(&folder.join("session.toml"), &["--estimator", "joint"])
}

/// Everything determined is the truth within 4.5 standard deviations.
fn assert_true(joint: &Estimator, folder: &Path) {
    let truth: Truth = toml::from_str(&fs::read_to_string(folder.join("truth.toml")).unwrap()).unwrap();
    let gravity = joint.gravity.as_ref().unwrap();
    for (axis, truth) in truth.gravity_m_per_s2.iter().enumerate() {
        let (value, std) = (gravity.vector_m_per_s2[axis], gravity.std_m_per_s2[axis]);
        assert!((value - truth).abs() < 4.5 * std, "gravity {axis}: {value} ± {std}, not {truth}");
    }
    for parameter in joint.parameters.iter().filter(|p| p.determined && p.held.is_none()) {
        let truth = truth.parameter.iter().find(|truth| truth.name == parameter.name).unwrap().value;
        let (value, std) = (parameter.value.unwrap(), parameter.std.unwrap());
        assert!((value - truth).abs() < 4.5 * std, "{}: {value} ± {std}, not {truth}", parameter.name);
    }
}

#[test]
fn they_are_calibrated_beside_the_torques() {
    let folder = simulated();
    let calibration = calibrate(folder.path());
    assert_eq!(calibration.run.code, 0, "{:?}", calibration.run);
    let joint = calibration.estimator("joint");
    assert_eq!(joint.parameters.len(), 12 + 16 + 9);
    assert_true(&joint, folder.path());
    for reported in ["wrist.fx  count        40", "imu.z     g            40", "gain_nx          N·m/(N·m)"] {
        assert!(calibration.run.stdout.contains(reported), "{reported}: {}", calibration.run.stdout);
    }
}

/// A wrist sensor that was zeroed between the tables.
#[test]
fn a_bias_of_each_table_is_found() {
    let own = "biases = [12, -7, 30, -0.15, 0.04, 0.09]";
    let each = "biases = [12, -7, 30, -0.15, 0.04, 0.09, -40, 25, 3, 0.5, -0.2, 0.1]";
    assert_eq!(SIMULATION.matches(own).count(), 1);
    let simulation =
        SIMULATION.replace(own, each).replace("name = \"wrist\"\n", "name = \"wrist\"\nbiases = \"table\"\n");
    let folder = simulated_of(&simulation);
    let joint = calibrate(folder.path()).estimator("joint");
    assert_eq!(joint.parameters.len(), 12 + 22 + 9);
    assert_true(&joint, folder.path());
    change(folder.path(), "biases = \"table\"\n", "");
    let one = calibrate(folder.path());
    assert_ne!(one.run.code, 0, "one bias for both tables: {:?}", one.run);
}

#[test]
fn an_arm_without_torque_sensors_needs_only_one_of_them() {
    let folder = simulated();
    change(
        folder.path(),
        "[\"joint1_torque_count\", \"joint2_torque_count\", \"joint3_torque_count\"]",
        "[\"\", \"\", \"\"]",
    );
    let joint = calibrate(folder.path()).estimator("joint");
    assert_true(&joint, folder.path());
    // The moments' gains share a scale with the lever of the load, which nothing else knows.
    assert!(joint.parameters.iter().any(|p| p.name == "wrist.gain_fx" && p.determined));
    assert!(joint.undetermined.iter().any(|u| u.combination.contains("wrist.gain_nx")), "{:?}", joint.undetermined);

    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    let (before, rest) = session.split_once("[[force_torque_sensor]]").unwrap();
    let (_, after) = rest.split_once("[[accelerometer]]").unwrap();
    fs::write(folder.path().join("session.toml"), format!("{before}[[accelerometer]]{after}")).unwrap();
    let joint = calibrate(folder.path()).estimator("joint");
    assert_true(&joint, folder.path());
    let of = |name: &str| joint.parameters.iter().find(|p| p.name == name).unwrap();
    // An accelerometer on the second link does not see the third joint, and two offsets and a mounting are one too many.
    assert!(of("joint1.position_gain").determined && !of("joint3.position_gain").determined);
}

#[test]
fn without_a_known_mass_gain_and_tool_share_a_scale() {
    let folder = simulated();
    change(folder.path(), "\n[[poses]]\nfile = \"plate.csv\"\nload = \"plate\"\n", "");
    let calibration = calibrate(folder.path());
    assert_eq!(calibration.run.code, 3, "{:?}", calibration.run);
    let joint = calibration.estimator("joint");
    assert_true(&joint, folder.path());
    let reported = joint.undetermined.iter().find(|u| u.combination.contains("wrist.gain_fx")).unwrap();
    assert!(reported.combination.contains("wrist.tool_mass"), "{}", reported.combination);
    assert!(reported.cure.contains("a load of known mass beyond the sensor"), "{}", reported.cure);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let cases = [
        ("name = \"imu\"", "name = \"link1\"", "accelerometer[0].name: `link1` is a joint or link of the robot"),
        ("name = \"imu\"", "name = \"wrist\"", "accelerometer[0].name: `wrist` is already force_torque_sensor[0].name"),
        ("link = \"link2\"\n", "link = \"hand\"\n", "accelerometer[0].link: there is no link `hand`"),
        (
            "unit = \"count/N\"",
            "unit = \"count/kg\"",
            "force_torque_sensor[0].force_gain.unit: the unit `count/kg` does not",
        ),
        (
            "[force_torque_sensor.force_gain]\nnominal = 20\nunit = \"count/N\"\n",
            "",
            "nothing says roughly what that is: add force_gain",
        ),
        (
            "unit = \"g\"",
            "unit = \"N\"",
            "accelerometer[0].readings.unit: the unit `N` does not fit: expected a unit of readings",
        ),
        ("[\"ax\", \"ay\", \"az\"]", "[\"ax\", \"ay\"]", "accelerometer[0].readings.columns: expected 3 entries"),
        ("[\"ax\", \"ay\", \"az\"]", "[\"ax\", \"ay\", \"fx\"]", "column `fx` is mapped to two readings"),
        (
            "mounting_std_deg = 3",
            "mounting_std_deg = 0",
            "accelerometer[0].mounting_std_deg: 0 is not a standard deviation",
        ),
    ];
    let folder = simulated();
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    for (old, new, reported) in cases {
        fs::write(folder.path().join("session.toml"), &session).unwrap();
        change(folder.path(), old, new);
        assert_eq!(calibrate(folder.path()).run.refusal(&["session.toml:", reported]), None);
    }
}
