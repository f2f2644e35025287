//! Readings whose noise nobody states: it is found from the residuals, and must not excuse what is wrong.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;
use gravcal_session::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;

use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, Verdict};

/// An arm whose base leans by 12°, away from every direction that is tried first.
const SIMULATION: &str = r#"
robot = "ROBOT"
seed = 3
[gravity]
direction = [0, 0.208, -0.978]
magnitude_m_per_s2 = 9.80665
[torque]
unit = "N·m"
std = 0.05
[position]
unit = "rad"
[[load]]
name = "plate"
mass_kg = 5
link = "link7"
position_m = [0.05, 0.04, 0.08]
[[random]]
file = "bare.csv"
poses = 30
[[random]]
file = "loaded.csv"
poses = 30
load = "plate"
"#;

/// The arm's readings, without any std.
fn readings() -> Session {
    readings_of(30)
}

/// The same, so many poses in each table.
fn readings_of(poses: usize) -> Session {
    let folder = tempfile::tempdir().unwrap();
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/kuka-lbr-iiwa14/robot.toml");
    let path = folder.path().join("simulation.toml");
    fs::write(
        &path,
        SIMULATION.replace("ROBOT", &robot.to_string_lossy()).replace("poses = 30", &format!("poses = {poses}")),
    )
    .unwrap();
    let mut session = Simulation::read(&path).unwrap().session(0);
    let readings = session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten());
    readings.for_each(|reading| reading.std = None);
    assert!(session.noise_estimated().iter().all(|estimated| *estimated));
    session.gravity.hemisphere = None;
    session
}

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

fn says(result: &EstimatorResult, begin: &str) -> bool {
    result.notes.iter().any(|note| note.starts_with(begin))
}

const UPWARDS: &str = "Gravity comes out upwards in base coordinates.";
const LARGE: &str = "Residuals are large beside the torque of gravity: joint";

#[test]
fn right_readings_are_determined_without_a_remark() {
    let result = estimate(&readings());
    assert_eq!(result.verdict, Verdict::Determined, "{} {:?}", result.termination, result.notes);
    assert!(!says(&result, UPWARDS) && !says(&result, LARGE), "{:?}", result.notes);
}

#[test]
fn swapped_columns_of_torques_or_positions_are_named() {
    let mut torques = readings();
    torques.poses.iter_mut().for_each(|pose| pose.torque.swap(1, 3));
    assert_eq!(estimate(&torques).termination, "swapped torque columns: joint2 and joint4");
    let mut positions = readings();
    positions.poses.iter_mut().for_each(|pose| pose.position.swap(1, 3));
    assert_eq!(estimate(&positions).termination, "swapped position columns: joint2 and joint4");
    let mut both = readings();
    both.poses.iter_mut().for_each(|pose| {
        pose.torque.swap(1, 3);
        pose.position.swap(1, 3);
    });
    let named = "torque and position columns of joint2 and joint4, which are swapped";
    assert_eq!(estimate(&both).termination, named);
}

#[test]
fn a_wrong_hemisphere_and_exchanged_tables_are_named() {
    let mut session = readings();
    session.gravity.hemisphere = Some([0.0, 0.0, 1.0]);
    let reported = estimate(&session).termination;
    assert!(
        reported.contains("hemisphere") || reported.contains("reversed torque sensors: joint1, joint2"),
        "{reported}"
    );
    let mut session = readings();
    session.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
    session.poses.iter_mut().for_each(|pose| pose.load = if pose.load.is_some() { None } else { Some(0) });
    assert_eq!(estimate(&session).termination, "tables with and without load plate exchanged");
}

/// Poses that are said to carry the load, and do not: the last of the table with the load, in the order in which they were read.
#[test]
fn a_load_that_fell_off_is_named_with_the_place() {
    let mut session = readings();
    for (number, pose) in session.poses.iter_mut().filter(|pose| pose.load.is_none()).skip(18).enumerate() {
        (pose.table, pose.load, pose.line) = (1, Some(0), 100 + number as u64);
    }
    session.poses.sort_by_key(|pose| (pose.table, pose.line));
    let result = estimate(&session);
    assert_eq!(result.termination, "load plate gone from about line 100 of loaded.csv on", "{:?}", result.notes);
    assert!(result.verdict == Verdict::Failed && result.notes[0].contains("belong to a [[poses]] without load"));
}

/// Poses that are said to be bare, and carry the load: the first of the table without.
#[test]
fn a_load_that_is_still_there_is_named_with_the_place() {
    let mut session = readings();
    session.poses.iter_mut().filter(|pose| pose.load.is_none()).for_each(|pose| pose.line += 100);
    for (number, pose) in session.poses.iter_mut().filter(|pose| pose.load.is_some()).take(12).enumerate() {
        (pose.table, pose.load, pose.line) = (0, None, 1 + number as u64);
    }
    session.poses.sort_by_key(|pose| (pose.table, pose.line));
    let result = estimate(&session);
    let first = session.poses.iter().map(|pose| pose.line).find(|line| *line > 100).unwrap();
    let named = format!("load plate still there before about line {first} of bare.csv");
    assert_eq!((result.termination, result.verdict), (named, Verdict::Failed), "{:?}", result.notes);
}

/// From some pose on, or always.
#[test]
fn a_position_sensor_that_is_stuck_is_the_first_thing_to_look_at() {
    let first = "Look at this first: position readings that do not change while other joints move: joint4 ";
    let mut stuck = readings();
    let last = stuck.poses[11].position[3];
    stuck.poses[12..30].iter_mut().for_each(|pose| pose.position[3] = last);
    let result = estimate(&stuck);
    assert!(result.notes[0].starts_with(first) && result.notes[0].contains("in 19 poses"), "{:?}", result.notes);
    stuck.poses.iter_mut().for_each(|pose| pose.position[3] = last);
    assert!(says(&estimate(&stuck), first));
}

/// Torques of the other sign: an arm that hangs reads the same.
#[test]
fn gravity_that_comes_out_upwards_is_asked_about() {
    let mut session = readings();
    for reading in session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()) {
        reading.value = -reading.value;
    }
    let result = estimate(&session);
    assert!(result.gravity.as_ref().unwrap().vector_m_per_s2[2] > 9.0);
    assert!(says(&result, UPWARDS) && result.verdict == Verdict::PartlyDetermined, "{:?}", result.notes);
    // Who says that the base hangs is believed.
    session.gravity.hemisphere = Some([0.0, 0.0, 1.0]);
    assert!(!says(&estimate(&session), UPWARDS));
}

/// Three of five columns shifted: no swap of two mends it.
#[test]
fn what_nothing_explains_is_no_noise() {
    let mut session = readings();
    session.poses.iter_mut().for_each(|pose| pose.torque[1..5].rotate_left(1));
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
    assert!(result.termination.starts_with("the torques of gravity are smaller than what they leave unexplained"));
}

/// Two columns exchanged in every third pose.
#[test]
fn large_residuals_are_no_noise_without_a_remark() {
    let mut session = readings();
    session.poses.iter_mut().step_by(3).for_each(|pose| pose.torque[3..5].rotate_left(1));
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::PartlyDetermined, "{}", result.termination);
    assert!(says(&result, LARGE), "{:?}", result.notes);
}

/// Of so many poses other starts are followed with a part.
#[test]
fn many_poses_tell_what_few_do() {
    let result = estimate(&readings_of(1100));
    assert_eq!(result.verdict, Verdict::Determined, "{} {:?}", result.termination, result.notes);
    let gravity = result.gravity.unwrap();
    let length = f64::hypot(0.208, 0.978);
    for (found, (std, truth)) in
        gravity.vector_m_per_s2.iter().zip(gravity.std_m_per_s2.iter().zip([0.0, 0.208, -0.978]))
    {
        assert!((found - 9.80665 * truth / length).abs() < 5.0 * std, "{gravity:?}");
    }
}

/// What was not tried may be likelier.
#[test]
fn stopped_while_other_starts_are_tried_nothing_is_called_determined() {
    let (solver, stop) = (LevenbergMarquardt::default(), AtomicBool::new(false));
    let report = |stage: &str| stop.fetch_or(stage == "other starting values", Ordering::Relaxed);
    let report = |stage: &str| _ = report(stage);
    let environment = SolveEnvironment::new(&solver, &report).stopped_by(&stop);
    let result = estimate_jointly(&readings(), Signals::All, None, &environment).unwrap();
    assert_eq!(result.verdict, Verdict::PartlyDetermined, "{} {:?}", result.termination, result.notes);
    assert!(result.notes[0].starts_with("Stopped before all was looked over") && result.reasons > 0);
}
