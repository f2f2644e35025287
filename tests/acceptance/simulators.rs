//! What `gravcal export` writes for simulators, loaded by them: Pinocchio and MuJoCo predict the torques that gravcal's own model does.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use gravcal_dynamics::{BodyInertia, Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_recording::{EarlierEstimate, Row, open, read_earlier};
use serde_json::{Value, json};

use crate::experiments::say;
use crate::program::gravcal_in;
use crate::tree;

const TOLERANCE: f64 = 1e-9;
const JOINTS: [&str; 3] = ["j1", "j2", "j3"];

/// The middle link is two that a fixed joint holds together, and the last one is that of a tool.
const URDF: &str = r#"<robot name="arm">
  <link name="pedestal"/><link name="base"/>
  <link name="a"><inertial><origin xyz="0.1 0.05 0.12"/><mass value="2"/>
    <inertia ixx="0.03" iyy="0.025" izz="0.02" ixy="0.002" ixz="-0.001" iyz="0.003"/></inertial></link>
  <link name="b"><inertial><origin xyz="0.1 0.05 0.12" rpy="0.1 0.2 0.3"/><mass value="1.5"/>
    <inertia ixx="0.03" iyy="0.025" izz="0.02" ixy="0.002" ixz="-0.001" iyz="0.003"/></inertial><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <link name="cover"><inertial><mass value="0.5"/>
    <inertia ixx="0.003" iyy="0.0025" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="c"/>
  <link name="tool"><inertial><origin xyz="0 0.05 0.1"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.012" izz="0.008" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="stand" type="fixed"><parent link="pedestal"/><child link="base"/><origin xyz="0 0 1" rpy="0.2 0 0.4"/></joint>
  <joint name="j1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0.1 0.05 0.3" rpy="1.2 0.3 0"/>
    <axis xyz="0 0 1"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
  <joint name="j2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.1 0.05 0.3" rpy="1.2 0.3 0"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
  <joint name="lid" type="fixed"><parent link="b"/><child link="cover"/><origin xyz="0.1 0 0.1" rpy="0.5 0 0"/></joint>
  <joint name="j3" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.1 0.05 0.3" rpy="1.2 0.3 0"/>
    <axis xyz="0 0 -1"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
  <joint name="flange" type="fixed"><parent link="c"/><child link="tool"/><origin xyz="0 0.02 0.1" rpy="0 0.7 0"/></joint>
</robot>
"#;

const SIMULATION: &str = r#"
robot = { urdf = "arm.urdf", base = "base", tip = "tool" }
seed = 3
[gravity]
direction = [0.3, -0.2, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.02
[position]
unit = "rad"
[recording]
rate_hz = 200
samples = 2500
move_s = 1
motion = { harmonics = 5, period_s = 10, seed = 2 }
[[load]]
name = "plate"
mass_kg = 1.5
link = "tool"
position_m = [0.1, 0.05, 0.1]
[[joint]]
name = "j2"
torque_sensor = { gain = { value = 1.04, unit = "N·m/(N·m)" }, bias = { value = 0.3, unit = "N·m" } }
position_sensor = { gain = { value = 1.003, unit = "rad/rad" }, offset = { value = 1.5, unit = "deg" } }
sensor_models = [{ kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.4, unit = "N·m" } } }]
[[random]]
file = "bare.csv"
poses = 2
[[random]]
file = "loaded.csv"
poses = 2
load = "plate"
"#;

/// The arm in motion, calibrated: its folder holds `results/calibration.json`.
fn calibrated() -> (tempfile::TempDir, EarlierEstimate) {
    let folder = tempfile::tempdir().unwrap();
    let write = |file: &str, text: &str| fs::write(folder.path().join(file), text).unwrap();
    write("arm.urdf", URDF);
    write("simulation.toml", SIMULATION);
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml", "--output", "."]);
    let session = fs::read_to_string(folder.path().join("session.toml")).unwrap_or_else(|_| panic!("{run:?}"));
    write("session.toml", &format!("{session}\n[constraints]\ninertia = \"physical\"\n"));
    let run = gravcal_in(folder.path(), ["calibrate", "session.toml", "--full", "--output", "results"]);
    assert!(run.stdout.contains("Consistent inertias"), "{run:?}");
    let estimate = read_earlier(&folder.path().join("results/calibration.json"), "joint").unwrap();
    (folder, estimate)
}

/// Friction has the sign of the motion, which no column of the recording tells.
#[test]
fn the_recording_of_an_arm_in_motion_is_calibrated_without_columns_of_velocities() {
    let (folder, estimate) = calibrated();
    let run = gravcal_in(folder.path(), ["apply", "results/calibration.json", "bare.csv", "out.csv", "--nominal"]);
    assert!(run.code == 0 && run.stdout.contains("velocities are slopes of the positions over 0.08 s"), "{run:?}");
    let read = |file: &str| {
        let mut rows = open(&folder.path().join(file)).unwrap();
        let (mut row, mut all) = (Row::default(), Vec::new());
        while rows.read(&mut row).unwrap() {
            all.push(row.cells.clone());
        }
        let place = |name: &str| rows.columns().iter().position(|column| column == name).unwrap();
        let [time, position, torque] = ["time_s", "j2.position", "j2.effort"].map(place);
        all.iter().map(|row| [row[time], row[position], row[torque]]).collect::<Vec<_>>()
    };
    let (readings, torques) = (read("bare.csv"), read("out.csv"));
    let value = |name: &str| {
        let own = estimate.parameters.iter().find(|parameter| parameter.name == format!("j2.{name}"));
        own.and_then(|own| own.value).unwrap()
    };
    let [gain, bias, friction] = ["torque_gain", "torque_bias", "coulomb_friction"].map(value);
    let mut moving = 0;
    for row in 4..readings.len() - 4 {
        let [before, after] = [row - 4, row + 4].map(|row| readings[row]);
        let speed = (after[1] - before[1]) / (after[0] - before[0]);
        // Between two motions nothing is recorded.
        if speed.abs() > 0.05 && after[0] - before[0] < 0.05 {
            let left = readings[row][2] - bias - gain * torques[row][2];
            assert!((left - friction * speed.signum()).abs() < 1e-9, "{row}: {left}");
            moving += 1;
        }
    }
    assert!(2 * moving > readings.len(), "{moving}");
}

fn export(folder: &Path, format: &str, file: &str) -> String {
    // The last joint's offset is a choice of frame where the tool is unknown.
    let arguments = ["export", "results/calibration.json", "--to", format, "--nominal", "-o", file, "--overwrite"];
    let run = gravcal_in(folder, arguments);
    assert_eq!(run.code, 0, "{run:?}");
    fs::read_to_string(folder.join(file)).unwrap()
}

/// Positions, velocities and accelerations of some samples.
fn samples() -> Vec<[[f64; 3]; 3]> {
    let draw = |sample: i32, from: i32, size: f64| {
        [0, 1, 2].map(|joint| size * (1.7 * f64::from(sample) + 2.3 * f64::from(from + joint)).sin())
    };
    (0..50).map(|sample| [draw(sample, 0, 1.4), draw(sample, 7, 2.0), draw(sample, 19, 6.0)]).collect()
}

fn offsets(estimate: &EarlierEstimate) -> [f64; 3] {
    JOINTS.map(|joint| {
        let name = format!("{joint}.position_offset");
        let found = estimate.parameters.iter().find(|parameter| parameter.name == name).unwrap();
        found.value.unwrap_or(found.nominal)
    })
}

/// Torques by gravcal's own dynamics, of the links and gravity in `calibration.json`.
fn own(estimate: &EarlierEstimate) -> Vec<Vec<f64>> {
    let chain = Chain::from_urdf(URDF, "base", &["tool"]).unwrap();
    let bodies = estimate.inertias.iter().flatten();
    let links: Vec<f64> = bodies
        .flat_map(|own| BodyInertia::about_center(own.mass_kg, own.center_of_mass_m, own.tensor_kg_m2).parameters())
        .collect();
    let offsets = offsets(estimate);
    let torque = |[q, v, a]: [[f64; 3]; 3]| {
        let coordinates: Vec<f64> = q.iter().zip(offsets).map(|(q, offset)| q + offset).collect();
        let motion = JointMotion { coordinates: &coordinates, velocities: &v, accelerations: &a };
        let parameters = DynamicParameters { links: &links, rotor_inertia: &[0.0; 3] };
        let mut dynamics = InverseDynamics::new(&chain);
        chain.inverse_dynamics(Single, motion, estimate.gravity.unwrap(), parameters, &mut dynamics);
        dynamics.torque
    };
    samples().into_iter().map(torque).collect()
}

/// Whether Python has these packages.
fn has_python_with(packages: &str) -> bool {
    let import = format!("import {packages}");
    Command::new("python3").args(["-c", &import]).output().is_ok_and(|output| output.status.success())
}

/// Torques by a simulator.
fn simulated(model: &Path, magnitude: f64) -> Vec<Vec<f64>> {
    let script = tree::root().join("benches/peers/simulators/torques.py");
    let mut python = Command::new("python3");
    let mut child = python
        .arg(script)
        .arg(model)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let asked = json!({ "joints": JOINTS, "samples": samples(), "gravity": [0.0, 0.0, -magnitude] });
    child.stdin.take().unwrap().write_all(asked.to_string().as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice::<Value>(&output.stdout).and_then(serde_json::from_value).unwrap()
}

fn assert_alike(found: &[Vec<f64>], expected: &[Vec<f64>]) {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().flatten().fold(0.0, |most: f64, torque| most.max(torque.abs()));
    assert!(largest > 5.0, "{largest}");
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    let off = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(off < TOLERANCE, "{off}");
}

#[test]
fn simulators_predict_the_torques_of_the_calibrated_arm() {
    let (folder, estimate) = calibrated();
    let expected = own(&estimate);
    let gravity = estimate.gravity.unwrap();
    let magnitude = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let urdf = export(folder.path(), "urdf", "calibrated.urdf");
    let mujoco = export(folder.path(), "mujoco", "calibrated.xml");
    // What has no part in it stays.
    assert!(urdf.contains("<visual>") && urdf.matches("<inertial>").count() == 3, "{urdf}");
    assert!(mujoco.contains("<option gravity=") && mujoco.matches("fullinertia").count() == 3, "{mujoco}");
    // By gravcal's own reader, which needs no package.
    let upright = Chain::from_urdf(&urdf, "gravity_aligned_world", &["tool"]).unwrap();
    let links = upright.inertial_parameters().unwrap();
    let torque = |[q, v, a]: [[f64; 3]; 3]| {
        let motion = JointMotion { coordinates: &q, velocities: &v, accelerations: &a };
        let parameters = DynamicParameters { links: &links, rotor_inertia: &[0.0; 3] };
        let mut dynamics = InverseDynamics::new(&upright);
        upright.inverse_dynamics(Single, motion, [0.0, 0.0, -magnitude], parameters, &mut dynamics);
        dynamics.torque
    };
    assert_alike(&samples().into_iter().map(torque).collect::<Vec<_>>(), &expected);
    for (package, file) in [("pinocchio", "calibrated.urdf"), ("mujoco", "calibrated.xml")] {
        match has_python_with(package) {
            true => assert_alike(&simulated(&folder.path().join(file), magnitude), &expected),
            false => say(&format!("SKIPPED: torques by {package}: python3 has no such package")),
        }
    }
}

#[test]
fn a_calibration_without_consistent_inertias_is_refused_with_what_to_do() {
    let (folder, _) = calibrated();
    let path = folder.path().join("results/calibration.json");
    let mut file: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    for estimator in file["estimators"].as_array_mut().unwrap() {
        estimator.as_object_mut().unwrap().remove("consistent_model");
    }
    fs::write(&path, file.to_string()).unwrap();
    let run = gravcal_in(folder.path(), ["export", "results/calibration.json", "--to", "mujoco", "--nominal"]);
    assert_eq!(run.refusal(&["no inertias of rigid bodies", "[constraints] inertia = \"physical\""]), None);
}
