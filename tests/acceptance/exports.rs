//! What `gravcal export` writes, read back by who it is for and applied to the raw readings: it reproduces the residuals that the
//! calibration reports.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use gravcal_calibration::application::GravityModel;
use gravcal_recording::{EarlierEstimate, read_earlier};
use gravcal_robot_model::Session;
use gravcal_session::read_session;
use tempfile::TempDir;

use crate::program::{Run, gravcal_in};
use crate::small_session::small_session;

const TOLERANCE: f64 = 1e-9;

/// The shoulder of the small session as a URDF.
const URDF: &str = r#"<robot name="shoulder">
  <!-- axes meet in one point -->
  <link name="shoulder"/><link name="upper"/><link name="middle"/><link name="lower"/><link name="link3"/>
  <joint name="joint1" type="continuous"><parent link="shoulder"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <joint name="joint2" type="revolute">
    <origin xyz="0 0 0" rpy="1.5707963267948966 0 0"/><parent link="upper"/><child link="middle"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="4" effort="100" velocity="1"/>
  </joint>
  <joint name="joint3" type="continuous">
    <origin rpy="-1.5707963267948966 0 0"/><parent link="middle"/><child link="lower"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="tip" type="fixed">
    <origin rpy="1.5707963267948966 0 0"/><parent link="lower"/><child link="link3"/>
  </joint>
</robot>
"#;

/// What the shoulder's own file says of its sensors, for a session with the URDF.
const SENSORS: &str = r#"[[joint]]
name = "joint1"
torque_gain = { nominal = 6.69, unit = "count/(N·m)" }
torque_bias = { nominal = 2048.0, unit = "count" }

[[joint]]
name = "joint2"
torque_gain = { nominal = 6.69, unit = "count/(N·m)" }
torque_bias = { nominal = 2048.0, unit = "count" }
position_offset = { nominal = 135.0, unit = "deg" }

[[joint]]
name = "joint3"
torque_gain = { nominal = 6.69, unit = "count/(N·m)" }
torque_bias = { nominal = 2048.0, unit = "count" }
"#;

/// The small session, calibrated, and everything that a comparison needs.
struct Calibrated {
    folder: TempDir,
    session: Session,
    estimate: EarlierEstimate,
    /// Root mean square and largest residual of each joint, as reported.
    reported: Vec<[f64; 2]>,
}

/// What the readings of one pose truly say: torques and coordinates.
type Truth = (Vec<f64>, Vec<f64>);

impl Calibrated {
    fn new(prepare: impl Fn(&Path)) -> Calibrated {
        let folder = small_session();
        prepare(folder.path());
        let run = gravcal_in(folder.path(), ["calibrate", "--full", "session.toml", "--output", "results"]);
        assert!([0, 3].contains(&run.code), "{run:?}");
        let path = folder.path().join("results/calibration.json");
        let file: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        let joint =
            file["estimators"].as_array().unwrap().iter().find(|estimator| estimator["name"] == "joint").unwrap();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let joints = joint["fit"]["joints"].as_array().unwrap();
        Calibrated {
            session: read_session(&folder.path().join("session.toml")).unwrap(),
            estimate: read_earlier(&path, "joint").unwrap(),
            reported: joints.iter().map(|fit| [number(&fit["rms"]), number(&fit["largest"])]).collect(),
            folder,
        }
    }

    fn export(&self, arguments: &[&str]) -> Run {
        gravcal_in(self.folder.path(), [&["export", "results/calibration.json", "--to"], arguments].concat())
    }

    /// The exported text.
    fn text(&self, format: &str) -> String {
        let run = self.export(&[format]);
        assert_eq!(run.code, 0, "{run:?}");
        run.stdout
    }

    /// Torque and position readings of each pose.
    fn readings(&self) -> Vec<Truth> {
        let of = |pose: &gravcal_robot_model::session::Pose| {
            (pose.torque.iter().map(|reading| reading.as_ref().unwrap().value).collect(), pose.position.clone())
        };
        self.session.poses.iter().map(of).collect()
    }

    /// Whether these torques and coordinates leave the residuals that are reported.
    fn assert_residuals(&self, truths: &[Truth]) {
        let parameter = |joint: usize, name: &str| {
            let name = format!("joint{}.{name}", joint + 1);
            self.estimate.parameters.iter().find(|parameter| parameter.name == name).unwrap().value.unwrap()
        };
        let mut residuals = vec![Vec::new(); self.session.joints.len()];
        for (pose, (torques, coordinates)) in self.session.poses.iter().zip(truths) {
            let load = pose.load.map(|load| self.session.loads[load].name.as_str());
            let mut model = GravityModel::new(&self.session, &self.estimate, load, false).unwrap();
            for (joint, expected) in model.torques(coordinates).iter().enumerate() {
                residuals[joint].push(parameter(joint, "torque_gain") * (expected - torques[joint]));
            }
        }
        for (residuals, [rms, largest]) in residuals.iter().zip(&self.reported) {
            let found = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
            assert!((found - rms).abs() < TOLERANCE, "rms {found} is not {rms}");
            let found = residuals.iter().fold(0.0, |most: f64, r| most.max(r.abs()));
            assert!((found - largest).abs() < TOLERANCE, "largest {found} is not {largest}");
        }
    }

    /// The same for a correction of single readings, by joint.
    fn assert_corrects(&self, torque: impl Fn(usize, f64) -> f64, coordinate: impl Fn(usize, f64) -> f64) {
        let corrected = |(torques, positions): Truth| {
            (
                torques.into_iter().enumerate().map(|(joint, reading)| torque(joint, reading)).collect(),
                positions.into_iter().enumerate().map(|(joint, reading)| coordinate(joint, reading)).collect(),
            )
        };
        self.assert_residuals(&self.readings().into_iter().map(corrected).collect::<Vec<_>>());
    }

    /// The same for a program that takes a line `joint torque-reading position-reading` and answers `torque coordinate`.
    fn assert_program_corrects(&self, mut command: Command) {
        let readings = self.readings();
        let lines: String = readings
            .iter()
            .flat_map(|(torques, positions)| torques.iter().zip(positions).enumerate())
            .map(|(joint, (torque, position))| format!("{joint} {torque:?} {position:?}\n"))
            .collect();
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success());
        let text = String::from_utf8(output.stdout).unwrap();
        let numbers: Vec<f64> = text.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let truths: Vec<Truth> = numbers
            .chunks(2 * self.session.joints.len())
            .map(|pose| pose.chunks(2).map(|pair| (pair[0], pair[1])).unzip())
            .collect();
        assert_eq!(truths.len(), readings.len());
        self.assert_residuals(&truths);
    }
}

#[test]
fn parameters_for_ros_2_reproduce_the_residuals_both_ways() {
    let calibrated = Calibrated::new(|_| ());
    let document: serde_json::Value = serde_saphyr::from_str(&calibrated.text("ros2")).unwrap();
    let parameters = &document["/**"]["ros__parameters"]["gravcal"];
    let names: Vec<&str> = parameters["joints"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(names, ["joint1", "joint2", "joint3"]);
    let number = |joint: usize, what: &str, which: &str| parameters[names[joint]][what][which].as_f64().unwrap();
    let inverse =
        |joint, what: &str, raw: f64| number(joint, what, "inverse_gain") * raw + number(joint, what, "inverse_bias");
    calibrated
        .assert_corrects(|joint, raw| inverse(joint, "torque", raw), |joint, raw| inverse(joint, "position", raw));
    for (joint, what) in [(0, "torque"), (1, "position")] {
        let truth = inverse(joint, what, 123.0);
        assert!((number(joint, what, "gain") * truth + number(joint, what, "bias") - 123.0).abs() < TOLERANCE);
    }
    let gravity =
        parameters["gravity_m_per_s2"].as_array().unwrap().iter().map(|component| component.as_f64().unwrap());
    assert_eq!(gravity.collect::<Vec<_>>(), calibrated.estimate.gravity.unwrap());
}

#[test]
fn csv_reproduces_the_residuals() {
    let calibrated = Calibrated::new(|_| ());
    let text = calibrated.text("csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows = reader.records().map(Result::unwrap).filter(|row| !row[2].is_empty());
    let values: BTreeMap<String, f64> = rows.map(|row| (row[0].to_owned(), row[2].parse().unwrap())).collect();
    let value = |joint: usize, name: &str| values[&format!("joint{}.{name}", joint + 1)];
    calibrated.assert_corrects(
        |joint, raw| (raw - value(joint, "torque_bias")) / value(joint, "torque_gain"),
        |joint, raw| value(joint, "position_gain") * raw + value(joint, "position_offset"),
    );
}

#[test]
fn a_c_header_reproduces_the_residuals() {
    const PROGRAM: &str = r#"
#include <stdio.h>
#include "calibration.h"
int main(void) {
  int joint; double torque, position;
  if (gravcal_gravity()[0] == 0.0 || !isnan(gravcal_torque(GRAVCAL_JOINT_COUNT, 1.0)) || !isnan(gravcal_coordinate(-1, 1.0))) return 1;
  while (scanf("%d %lf %lf", &joint, &torque, &position) == 3)
    printf("%.17g %.17g\n", gravcal_torque(joint, torque), gravcal_coordinate(joint, position));
  return 0;
}
"#;
    let calibrated = Calibrated::new(|_| ());
    let folder = calibrated.folder.path();
    let run = calibrated.export(&["c", "-o", "calibration.h"]);
    assert_eq!((run.code, run.stdout.as_str()), (0, "calibration.h\n"), "{run:?}");
    fs::write(folder.join("apply.c"), PROGRAM).unwrap();
    let strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-o", "apply", "apply.c"];
    assert!(Command::new("cc").args(strict).current_dir(folder).status().unwrap().success());
    calibrated.assert_program_corrects(Command::new(folder.join("apply")));
}

#[test]
fn a_python_module_reproduces_the_residuals() {
    const PROGRAM: &str = "
import sys
import calibration
names = list(calibration.JOINTS)
for line in sys.stdin:
    joint, torque, position = line.split()
    name = names[int(joint)]
    print(repr(calibration.torque(name, float(torque))), repr(calibration.coordinate(name, float(position))))
";
    if !Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: there is no python3");
        return;
    }
    let calibrated = Calibrated::new(|_| ());
    assert_eq!(calibrated.export(&["python", "-o", "calibration.py"]).code, 0);
    let mut python = Command::new("python3");
    python.args(["-B", "-c", PROGRAM]).current_dir(calibrated.folder.path());
    calibrated.assert_program_corrects(python);
}

/// The new URDF takes gain · reading for a joint's value, and gravity points along −z of its root.
#[test]
fn a_corrected_urdf_reproduces_the_residuals() {
    use gravcal_dynamics::{Chain, UPRIGHT_LINK};
    let calibrated = Calibrated::new(|folder| {
        let session = fs::read_to_string(folder.join("session.toml")).unwrap();
        let (before, rest) = session.split_once("[[joint]]").unwrap();
        let (_, after) = rest.split_once("[[load]]").unwrap();
        let robot = "robot = { urdf = \"shoulder.urdf\", base = \"shoulder\", tip = \"link3\" }";
        let before = before.replace("robot = \"robot.toml\"", robot);
        fs::write(folder.join("session.toml"), format!("{before}{SENSORS}\n[[load]]{after}")).unwrap();
        fs::write(folder.join("shoulder.urdf"), URDF).unwrap();
    });
    let text = calibrated.text("urdf");
    assert!(
        text.contains("<!-- axes meet in one point -->") && text.contains("Convention: the joint's value"),
        "{text}"
    );
    let Calibrated { session, estimate, reported, folder } = &calibrated;
    let magnitude = estimate.gravity.unwrap().iter().map(|g| g * g).sum::<f64>().sqrt();
    let mut upright = session.clone();
    upright.robot.chain = Chain::from_urdf(&text, UPRIGHT_LINK, &["link3"]).unwrap();
    let estimate = EarlierEstimate { gravity: Some([0.0, 0.0, -magnitude]), ..estimate.clone() };
    let value = |joint: usize, name: &str| {
        let name = format!("joint{}.{name}", joint + 1);
        estimate.parameters.iter().find(|parameter| parameter.name == name).unwrap().value.unwrap()
    };
    let corrected = |(torques, positions): &Truth| {
        let torques = torques.iter().enumerate();
        let positions = positions.iter().enumerate();
        (
            torques.map(|(j, raw)| (raw - value(j, "torque_bias")) / value(j, "torque_gain")).collect(),
            positions.map(|(j, raw)| value(j, "position_gain") * raw).collect(),
        )
    };
    let truths: Vec<Truth> = calibrated.readings().iter().map(corrected).collect();
    let other = Calibrated {
        session: upright,
        estimate: estimate.clone(),
        reported: reported.clone(),
        folder: tempfile::tempdir_in(folder.path()).unwrap(),
    };
    other.assert_residuals(&truths);
    // A URDF that was changed since is not that of the calibration.
    fs::write(folder.path().join("shoulder.urdf"), URDF.replace("effort=\"100\"", "effort=\"90\"")).unwrap();
    let reported =
        ["shoulder.urdf: the robot has changed since the calibration", "calibrate again; --session SESSION takes"];
    assert_eq!(calibrated.export(&["urdf"]).refusal(&reported), None);
    let taken = calibrated.export(&["urdf", "--session", "session.toml"]);
    assert!(taken.code == 0 && taken.stdout.contains("effort=\"90\""), "{taken:?}");
}

#[test]
fn tables_for_people_say_what_the_calibration_says() {
    let calibrated = Calibrated::new(|_| ());
    let gain = calibrated.estimate.parameters.iter().find(|parameter| parameter.name == "joint2.torque_gain").unwrap();
    let (value, std) = (gain.value.unwrap(), gain.std.unwrap());
    let read = |text: &str, separator: char| -> Vec<f64> {
        let line = text.lines().find(|line| line.contains("joint2.torque\\_gain")).unwrap();
        line.split(separator).filter_map(|cell| cell.trim().trim_matches('$').parse().ok()).collect()
    };
    for (format, separator) in [("markdown", '|'), ("latex", '&')] {
        let numbers = read(&calibrated.text(format), separator);
        assert!((numbers[0] - value).abs() < 0.06 * std && (numbers[1] - std).abs() < 0.06 * std, "{numbers:?}");
    }
}

#[test]
fn what_cannot_be_exported_is_refused_and_loses_nothing() {
    let calibrated = Calibrated::new(|_| ());
    let refused =
        |arguments: &[&str], reported: &[&str]| assert_eq!(calibrated.export(arguments).refusal(reported), None);
    refused(&["yaml"], &["ros2, urdf, mujoco, payload, csv, c, python, markdown, latex"]);
    refused(&["urdf"], &["the session's robot is no URDF", "describe the robot by robot = { urdf"]);
    refused(&["csv", "--estimator", "recursive"], &["it has no estimator `recursive`"]);
    refused(&["c", "-o", "no-such-folder/a.h"], &["no-such-folder"]);
    // The only estimator need not be named; of several without the joint one, one must.
    let text = fs::read_to_string(calibrated.folder.path().join("results/calibration.json")).unwrap();
    let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let joint = file["estimators"].as_array().unwrap().iter().find(|e| e["name"] == "joint").unwrap().clone();
    for (names, code) in [(&["recursive"][..], 0), (&["recursive", "joint"], 0), (&["recursive", "sequential"], 2)] {
        let renamed = |name: &&str| {
            let mut estimator = joint.clone();
            estimator["name"] = (*name).into();
            estimator
        };
        file["estimators"] = names.iter().map(renamed).collect();
        fs::write(calibrated.folder.path().join("some.json"), file.to_string()).unwrap();
        let run = gravcal_in(calibrated.folder.path(), ["export", "some.json", "--to", "csv"]);
        assert_eq!(run.code, code, "{run:?}");
        let hint = "hint: --estimator NAME chooses one of: recursive, sequential";
        assert!(code == 0 || run.stderr.contains(hint), "{run:?}");
    }
    assert_eq!(calibrated.export(&["c", "-o", "a.h"]).code, 0);
    let old = fs::read(calibrated.folder.path().join("a.h")).unwrap();
    refused(&["python", "-o", "a.h"], &["there is such a file already", "--overwrite replaces it"]);
    assert_eq!(fs::read(calibrated.folder.path().join("a.h")).unwrap(), old);
    // The paper's steps leave the last joint's gain open.
    let path = calibrated.folder.path().join("results/calibration.json");
    let text = fs::read_to_string(&path).unwrap();
    let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
    for estimator in file["estimators"].as_array_mut().unwrap() {
        for parameter in estimator["parameters"].as_array_mut().unwrap() {
            if parameter["name"] == "joint3.torque_gain" {
                parameter["value"] = serde_json::Value::Null;
            }
        }
        estimator["covariance"] = serde_json::json!({ "order": ["gravity.x"], "matrix": [[1.0]] });
    }
    fs::write(&path, file.to_string()).unwrap();
    refused(&["ros2"], &["does not determine joint3.torque_gain", "--nominal takes nominal values instead"]);
    let run = calibrated.export(&["ros2", "--nominal"]);
    let mark = "joint3.torque_gain is not determined; its nominal value 6.69 stands here";
    assert!(run.code == 0 && run.stderr.contains(mark) && run.stdout.contains(mark), "{run:?}");
}
