//! A wrist sensor without a robot, from its recording over the session that is drawn up to the estimate.

use std::fs;

use gravcal_identification::SolveEnvironment;
use gravcal_recording::{OrientationForm, inspect};
use gravcal_robot_model::session::Session;
use gravcal_session::draft::Draft;
use gravcal_session::read_session;
use gravcal_solvers::LevenbergMarquardt;
use nalgebra::{UnitQuaternion, Vector3};

use crate::joint::{Signals, estimate_jointly};
use crate::result::Verdict;

/// What a wrist sensor reads on a body that is turned every way, with its quaternion or the inverse, times the sensor's sign.
fn turned(header: &str, [inverse, sign]: [f64; 2]) -> String {
    let row = |row: u32| {
        let row = f64::from(row);
        let turned = UnitQuaternion::from_euler_angles(1.1 * row, (2.3 * row).sin(), 3.7 * row);
        let gravity = turned.inverse() * Vector3::new(0.2, -0.1, -9.8);
        let (force, moment) = (-0.85 * gravity, gravity.cross(&Vector3::new(0.01, -0.02, 0.05)));
        let noise = |of: usize| {
            let index = 6.0 * row + of as f64 + 0.37;
            0.02 * (1..4).map(|k| (12.9898 * index * f64::from(k)).sin()).sum::<f64>()
        };
        let force = [0, 1, 2].map(|axis| sign * force[axis] + 3.0 + noise(axis));
        let moment = [0, 1, 2].map(|axis| sign * moment[axis] - 0.1 + 0.05 * noise(3 + axis));
        let q = if inverse < 0.0 { turned.inverse() } else { turned };
        let cells = force.into_iter().chain(moment).chain([q.i, q.j, q.k, q.w]).map(|cell| format!("{cell:.6}"));
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    format!("{header}\n{}", (0..30).map(row).collect::<String>())
}

/// The session drawn up from a recording without a robot, and its notes.
fn drafted_alone(recording: &str) -> (String, Vec<String>, Result<Session, String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("day.csv");
    fs::write(&path, recording).unwrap();
    let inspection = inspect(&path, &|_| {}).unwrap();
    let draft = Draft::new(&path, &inspection, None).unwrap().looked_at(&|_| {}).unwrap();
    let text = draft.text(&draft.search(&|_| {}).unwrap(), folder.path());
    let session = folder.path().join("session.toml");
    fs::write(&session, &text).unwrap();
    (text, draft.notes(), read_session(&session).map_err(|error| error.to_string()))
}

/// The same with rotation matrices in place of quaternions.
fn turned_with_matrices(signs: [f64; 2]) -> String {
    let header = "fx,fy,fz,tx,ty,tz,r11,r12,r13,r21,r22,r23,r31,r32,r33";
    let with_quaternions = turned("", signs);
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let rotation = OrientationForm::QuaternionXyzw.rotation(&cells[6..]).unwrap();
        let cells = cells[..6].iter().chain(rotation.as_flattened());
        cells.map(|cell| format!("{cell:.6}")).collect::<Vec<_>>().join(",") + "\n"
    };
    format!("{header}\n{}", with_quaternions.lines().skip(1).map(row).collect::<String>())
}

const WRIST: &str = "fx,fy,fz,tx,ty,tz,qx,qy,qz,qw";

#[test]
fn rotation_matrices_tell_as_much_as_quaternions() {
    for inverse in [1.0, -1.0] {
        let [quaternions, matrices] =
            [turned(WRIST, [inverse, -1.0]), turned_with_matrices([inverse, -1.0])].map(|recording| {
                let (text, notes, session) = drafted_alone(&recording);
                assert!(text.contains("sign = \"reversed\"") && notes.len() == 2, "{text}");
                session.unwrap()
            });
        let mapped = matrices.readings.orientation.as_ref().unwrap();
        assert_eq!((mapped.form, mapped.body_from_base), (OrientationForm::Matrix, inverse < 0.0));
        assert_eq!(matrices.poses.len(), quaternions.poses.len());
    }
}

#[test]
fn a_wrist_sensor_that_is_turned_becomes_a_session_of_its_own() {
    for (inverse, sign) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let (text, notes, session) = drafted_alone(&turned(WRIST, [inverse, sign]));
        let session = session.unwrap();
        let mapped = session.readings.orientation.as_ref().unwrap();
        assert_eq!((mapped.columns.concat(), mapped.body_from_base), ("qxqyqzqw".to_owned(), inverse < 0.0), "{text}");
        assert_eq!(text.lines().any(|line| line.starts_with("sign = \"reversed\"")), sign < 0.0, "{text}");
        assert!(notes.len() == 2 && notes[0].starts_with("gravity is taken to point down"), "{notes:?}");
        let solver = LevenbergMarquardt::default();
        let result =
            estimate_jointly(&session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap();
        assert_eq!(result.verdict, Verdict::Determined, "{:?}", result.notes);
        let mass = result.parameters.iter().find(|parameter| parameter.name == "wrist.tool_mass").unwrap();
        let (mass, std) = (mass.value.unwrap(), mass.std.unwrap());
        assert!((mass - 0.85).abs() < 5.0 * std.max(1e-4) && std < 0.01, "{mass} ± {std}");
    }
}

#[test]
fn what_a_wrist_sensor_does_not_tell_is_asked_for() {
    // The order of columns does not matter, nor do the axes' other names.
    let heads = "wrench.force.x,wrench.force.y,wrench.force.z,wrench.torque.x,wrench.torque.y,wrench.torque.z";
    let quaternion = "orientation.x,orientation.y,orientation.z,orientation.w";
    let (text, _, session) = drafted_alone(&turned(&format!("{heads},{quaternion}"), [1.0, 1.0]));
    let sensor = &session.unwrap().readings;
    assert_eq!(sensor.instruments[3].as_ref().unwrap().column, "wrench.torque.x", "{text}");
    // Counts need a gain.
    let counts = turned(WRIST, [1.0, 1.0]);
    let (head, rows) = counts.split_once('\n').unwrap();
    let counted = |cell: &str| (1000.0 * cell.parse::<f64>().unwrap()).round().to_string();
    let row = |row: &str| {
        let cells = row.split(',').enumerate();
        let cells = cells.map(|(place, cell)| if place < 6 { counted(cell) } else { cell.to_owned() });
        cells.collect::<Vec<_>>().join(",") + "\n"
    };
    let (text, _, session) = drafted_alone(&format!("{head}\n{}", rows.lines().map(row).collect::<String>()));
    assert!(text.contains("# force_gain = { nominal = …, unit = \"count/N\" }"), "{text}");
    assert!(session.unwrap_err().contains("nothing says roughly what that is: add force_gain"));
    // Forces that gravity does not make say nothing of signs; rows of a clock are asked about.
    let row = |row: u32| format!("{},{},1,2,0.1,0.2,0.3,0,0,0,1\n", f64::from(row) * 0.01, (f64::from(row)).sin());
    let standing = format!("t_s,{WRIST}\n{}", (0..50).map(row).collect::<String>());
    let (text, notes, _) = drafted_alone(&standing);
    assert!(
        text.contains("# LOOK AT THIS: Rows are 0.010 s apart") && notes[1].contains("not told"),
        "{text} {notes:?}"
    );
}
