//! A force-torque sensor turned by hand, or by a robot whose angles nobody recorded: from its table to a verdict and to what a program
//! takes. The table is a real one, of 24 poses of an ATI Gamma, which tells what the tool exerts on the sensor.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::answer::Estimator;
use crate::experiments::say;
use crate::program::{Calibration, gravcal_in};
use crate::tree;

const SESSION: &str = r#"
[gravity]
magnitude_m_per_s2 = 9.82085
hemisphere = [0, 0, -1]

[readings]
orientation = { columns = ["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"], rotation = "base-from-body" }

[[force_torque_sensor]]
name = "wrist"
sign = "reversed"
readings = { columns = ["fx", "fy", "fz", "tx", "ty", "tz"], unit = ["N", "N", "N", "N·m", "N·m", "N·m"] }
force_gain = { fixed = 1, unit = "N/N" }
moment_gain = { fixed = 1, unit = "N·m/(N·m)" }

[[poses]]
file = "TABLE"
"#;

/// By independent least squares with gravity straight down: mass, kg; first moment, kg·m; biases, N and N·m; and how far from them
/// an estimate may be that leaves gravity's direction open, which moves the tool's centre by some tenths of a millimetre.
const EXPECTED: [(&str, f64, f64); 10] = [
    ("tool_mass", 0.932, 0.002),
    ("tool_moment_x", 0.932 * 0.28e-3, 2e-4),
    ("tool_moment_y", 0.932 * 0.05e-3, 2e-4),
    ("tool_moment_z", 0.932 * 43.9e-3, 2e-4),
    ("bias_fx", 9.08, 0.02),
    ("bias_fy", -1.02, 0.02),
    ("bias_fz", 9.98, 0.02),
    ("bias_nx", 0.433, 0.002),
    ("bias_ny", -0.692, 0.002),
    ("bias_nz", -0.157, 0.002),
];

/// Root mean square of the residuals of the same fit, N: what no reading tells its sensor.
const NOISE: [f64; 3] = [0.131, 0.047, 0.057];

fn real_table() -> Option<PathBuf> {
    let table = tree::root().join("../shared/data/kuka_med14_wrist/calibration_fts_accel.csv");
    if !table.is_file() {
        say(&format!("SKIPPED: there is no table {}", table.display()));
        return None;
    }
    Some(table)
}

/// A folder with the session of the table.
fn session_of(table: &Path) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_session(folder.path(), &SESSION.replace("TABLE", &table.display().to_string()));
    folder
}

fn write_session(folder: &Path, text: &str) {
    fs::write(folder.join("session.toml"), text).unwrap();
}

fn value(joint: &Estimator, name: &str) -> f64 {
    let name = format!("wrist.{name}");
    joint.parameters.iter().find(|parameter| parameter.name == name).unwrap().value.unwrap()
}

#[test]
fn a_real_one_is_calibrated_as_by_independent_least_squares() {
    let Some(table) = real_table() else { return };
    let folder = session_of(&table);
    let checked = gravcal_in(folder.path(), ["check", "--full", "session.toml"]);
    assert_eq!(checked.code, 0, "{checked:?}");
    // Its moments show a little of what other axes sense.
    let run = gravcal_in(folder.path(), ["calibrate", "--full", "session.toml"]);
    assert!(run.code == 3 && run.stdout.contains("goes with what other axes sense"), "{run:?}");
    let apply = ["apply", "calibration/calibration.json", &table.display().to_string(), "out.csv"];
    assert_eq!(gravcal_in(folder.path(), apply).refusal(&["the session has no joints"]), None);
    let calibration = Calibration::of(&folder.path().join("session.toml"));
    assert_eq!(calibration.run.code, 3, "{:?}", calibration.run);
    let joint = calibration.estimator("joint");
    for (name, expected, tolerance) in EXPECTED {
        let found = value(&joint, name);
        assert!((found - expected).abs() < tolerance, "{name}: {found}, not {expected}");
    }
}

#[test]
fn a_real_one_whose_sign_is_not_said_is_named() {
    let Some(table) = real_table() else { return };
    let folder = session_of(&table);
    let text = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    write_session(folder.path(), &text.replace("sign = \"reversed\"\n", ""));
    let calibration = Calibration::of(&folder.path().join("session.toml"));
    assert_ne!(calibration.run.code, 0, "{:?}", calibration.run);
    let reported = calibration.run.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(reported.contains("reversed force-torque sensor: wrist"), "{reported}");
    let joint = calibration.estimator("joint");
    assert!(joint.parameters.iter().all(|parameter| parameter.value.is_none() || parameter.held.is_some()));
}

/// Gravity the other way up and a tool of negative mass read the same: which is right nothing but an assumed mass says.
#[test]
fn without_a_hemisphere_neither_check_nor_calibrate_tells_where_gravity_points() {
    let Some(table) = real_table() else { return };
    let folder = session_of(&table);
    let text = fs::read_to_string(folder.path().join("session.toml")).unwrap();
    write_session(folder.path(), &text.replace("hemisphere = [0, 0, -1]\n", ""));
    let checked = gravcal_in(folder.path(), ["check", "--full", "session.toml"]);
    assert_eq!(checked.code, 3, "{checked:?}");
    let reported = checked.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(reported.contains("can be determined: not gravity, wrist.tool_mass,"), "{reported}");
    let calibration = Calibration::of(&folder.path().join("session.toml"));
    assert_eq!(calibration.run.code, 3, "{:?}", calibration.run);
    let joint = calibration.estimator("joint");
    assert!(joint.gravity.is_none(), "{:?}", calibration.run);
    assert!(joint.parameters.iter().all(|parameter| parameter.name != "wrist.tool_mass" || parameter.value.is_none()));
}

#[test]
fn what_is_exported_of_a_real_one_gives_the_weight_of_its_tool() {
    const C: &str = r#"
#include <stdio.h>
#include "calibration.h"
int main(void) {
  double reading[6] = {0.0}, sensed[6];
  if (gravcal_sensed(GRAVCAL_INSTRUMENT_COUNT, reading, sensed) != 0) return 1;
  while (scanf("%lf %lf %lf %lf %lf %lf", reading, reading + 1, reading + 2, reading + 3, reading + 4, reading + 5) == 6) {
    if (gravcal_sensed(0, reading, sensed) != 6) return 2;
    for (int axis = 0; axis < 6; ++axis) printf("%.17g\n", sensed[axis]);
  }
  return 0;
}
"#;
    const PYTHON: &str = "
import sys
import calibration
for line in sys.stdin:
    for part in calibration.sensed('wrist', [float(cell) for cell in line.split()]):
        print(repr(part))
";
    let Some(table) = real_table() else { return };
    let folder = session_of(&table);
    // Its moments show a little of what other axes sense.
    let run = gravcal_in(folder.path(), ["calibrate", "--full", "session.toml"]);
    assert!(run.code == 3 && run.stdout.contains("goes with what other axes sense"), "{run:?}");
    for (format, file) in [("c", "calibration.h"), ("python", "calibration.py")] {
        let run = gravcal_in(folder.path(), ["export", "calibration/calibration.json", "--to", format, "-o", file]);
        assert_eq!(run.code, 0, "{run:?}");
    }
    let ros2 = gravcal_in(folder.path(), ["export", "calibration/calibration.json", "--to", "ros2"]).stdout;
    let document: serde_json::Value = serde_saphyr::from_str(&ros2).unwrap();
    let wrist = &document["/**"]["ros__parameters"]["gravcal"]["wrist"];
    let numbers =
        |key: &str| -> Vec<f64> { wrist[key].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect() };
    let (inverse_gain, inverse_bias) = (numbers("inverse_gain"), numbers("inverse_bias"));
    let by_ros2 = |reading: &[f64]| -> Vec<f64> {
        let along = |row: usize| {
            inverse_gain[6 * row..6 * row + 6].iter().zip(reading).map(|(gain, raw)| gain * raw).sum::<f64>()
        };
        (0..6).map(|row| along(row) + inverse_bias[row]).collect()
    };
    fs::write(folder.path().join("apply.c"), C).unwrap();
    let strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-o", "apply", "apply.c"];
    assert!(Command::new("cc").args(strict).current_dir(folder.path()).status().unwrap().success());
    let rows = rows(&table);
    let readings: String = rows
        .iter()
        .map(|row| format!("{}\n", row[..6].iter().map(f64::to_string).collect::<Vec<_>>().join(" ")))
        .collect();
    let by_ros2: Vec<f64> = rows.iter().flat_map(|row| by_ros2(&row[..6])).collect();
    assert_weight(&rows, &by_ros2);
    let by_c = answers(Command::new(folder.path().join("apply")), &readings);
    assert!(by_c.iter().zip(&by_ros2).all(|(c, ros2)| (c - ros2).abs() < 1e-9), "{by_c:?} {by_ros2:?}");
    let mut python = Command::new("python3");
    if !python.arg("--version").output().is_ok_and(|output| output.status.success()) {
        return say("skipped: there is no python3");
    }
    let mut python = Command::new("python3");
    python.args(["-B", "-c", PYTHON]).current_dir(folder.path());
    let by_python = answers(python, &readings);
    assert!(by_python.iter().zip(&by_ros2).all(|(python, ros2)| (python - ros2).abs() < 1e-9));
}

/// The numbers of the table, row by row: six readings, three accelerations, gravity in the sensor's frame, nine of its rotation.
fn rows(table: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(table).unwrap();
    let row = |line: &str| line.split(',').map(|cell| cell.trim().parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

/// Whether the forces are what carries the tool: `−m g`, within the noise of the readings.
fn assert_weight(rows: &[Vec<f64>], sensed: &[f64]) {
    let mass = EXPECTED[0].1;
    for axis in 0..3 {
        let left = |(row, sensed): (&Vec<f64>, &[f64])| sensed[axis] + mass * row[9 + axis];
        let squares: f64 = rows.iter().zip(sensed.chunks(6)).map(|pose| left(pose).powi(2)).sum();
        let rms = (squares / rows.len() as f64).sqrt();
        assert!(rms < 1.2 * NOISE[axis], "axis {axis}: {rms}");
    }
}

/// What a program answers to these lines.
fn answers(mut command: Command, lines: &str) -> Vec<f64> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().split_whitespace().map(|number| number.parse().unwrap()).collect()
}
