//! What an arm of seven joints tells: on a tilted base with a load everything, without the load all but the scale of
//! torque, and on an upright base nothing of the first joint's gains. `check` must know it beforehand.

use std::fs;
use std::path::Path;

use serde::Deserialize;
use tempfile::TempDir;

use crate::answer::{Estimator, Undetermined, combinations};
use crate::program::{Calibration, Run, gravcal};
use crate::tree;

/// Solved, but something that is asked for is undetermined.
const PARTLY: i32 = 3;
/// The choice of the last link's frame, which is never asked for.
const LAST_OFFSET: &str = "joint7.position_offset";

/// The part of `check --json` that the tests look at.
#[derive(Debug, Deserialize)]
struct CheckAnswer {
    complete: bool,
    undetermined: Vec<Undetermined>,
}

#[test]
fn a_load_on_a_tilted_base_gives_every_gain_even_the_last() {
    let calibration = Calibration::of(&tree::experiment("seven-joints-tilted").join("session.toml"));
    assert_eq!(calibration.run.code, 0, "{:?}", calibration.run);
    let joint = calibration.estimator("joint");
    assert_eq!(joint.without_value(), [LAST_OFFSET]);
    assert_eq!(torque_gains(&joint), 7);
}

#[test]
fn bare_poses_leave_the_common_scale_of_torque_gains_open() {
    let session = bare_session();
    let (run, joint) = calibrated(&session.path().join("session.toml"));
    assert_eq!(run.code, PARTLY, "{run:?}");
    assert_eq!(combinations(&joint.undetermined), ["common scale of all torque gains", LAST_OFFSET]);
    let open = joint.without_value();
    assert_eq!(open.iter().filter(|name| name.ends_with(".torque_gain")).count(), 7, "{open:?}");
    assert_eq!(open.len(), 8, "{open:?}");
}

#[test]
fn an_upright_base_hides_the_gains_of_the_first_joint() {
    let (run, joint) = calibrated(&tree::experiment("seven-joints-upright").join("session.toml"));
    assert_eq!(run.code, PARTLY, "{run:?}");
    let mut open = combinations(&joint.undetermined);
    open.sort_unstable();
    assert_eq!(open, ["joint1.position_gain", "joint1.torque_gain", LAST_OFFSET]);
    assert_eq!(joint.without_value(), ["joint1.torque_gain", "joint1.position_gain", LAST_OFFSET]);
    assert_tilt_cures_the_first_joint(&joint.undetermined);
}

#[test]
fn check_foresees_what_bare_poses_leave_open() {
    let session = bare_session();
    assert_foreseen(&session.path().join("session.toml"));
}

#[test]
fn check_foresees_what_an_upright_base_hides() {
    let foreseen = assert_foreseen(&tree::experiment("seven-joints-upright").join("session.toml"));
    assert_tilt_cures_the_first_joint(&foreseen);
}

#[test]
fn check_foresees_that_nothing_is_missing() {
    let (run, check) = checked(&tree::experiment("seven-joints-tilted").join("session.toml"));
    assert_eq!((run.code, check.complete), (0, true), "{run:?}");
    assert_eq!(combinations(&check.undetermined), [LAST_OFFSET]);
}

/// That both sensors of one read the other way is the same to the readings as that its axis does.
#[test]
fn a_joint_that_turns_the_other_way_than_the_robot_says_is_named() {
    let session = tilted_session(|session| {
        let signs = r#"
            [joints]
            torque_sign = "normal"
            [[joint]]
            name = "joint3"
            position_sign = "reversed"
            torque_sign = "reversed"
        "#;
        session.extend(signs.parse::<toml::Table>().unwrap());
    });
    let (run, joint) = calibrated(&session.path().join("session.toml"));
    assert_eq!(run.code, 4, "{run:?}");
    assert_eq!(joint.termination, "joint that turns the other way than the robot's description says: joint3");
}

#[test]
fn loads_on_another_link_than_stated_are_named() {
    let session = tilted_session(|session| {
        for load in session["load"].as_array_mut().unwrap() {
            assert_eq!(load["link"].as_str(), Some("link7"));
            load.as_table_mut().unwrap().insert("link".into(), "link6".into());
        }
    });
    let (run, joint) = calibrated(&session.path().join("session.toml"));
    assert_eq!(run.code, 4, "{run:?}");
    assert!(joint.termination.ends_with("on another link than link6, which is stated: link7"), "{}", joint.termination);
    let words: Vec<&str> = run.stdout.split_whitespace().collect();
    assert!(words.join(" ").contains("Say link = \"link7\""), "{run:?}");
}

/// And not the position sensor beside it, which would have to be off by many radians.
#[test]
fn a_distance_of_two_loads_that_is_wrong_is_named() {
    let session = tilted_session(|session| {
        let distance = session["load_distance"].as_array_mut().unwrap()[0].as_table_mut().unwrap();
        let truth = distance["distance_m"].as_float().unwrap();
        distance.insert("distance_m".into(), (1.05 * truth).into());
    });
    let (run, _) = calibrated(&session.path().join("session.toml"));
    assert_eq!(run.code, PARTLY, "{run:?}");
    let words: Vec<&str> = run.stdout.split_whitespace().collect();
    assert!(words.join(" ").contains("closer together than distance_m says"), "{run:?}");
}

/// The session on the tilted base with nothing but its bare poses, in a folder of its own.
fn bare_session() -> TempDir {
    tilted_session(|session| {
        for loaded in ["load", "load_distance"] {
            session.remove(loaded).unwrap();
        }
        let tables = session["poses"].as_array_mut().unwrap();
        tables.retain(|table| table["file"].as_str() == Some("bare.csv"));
        assert_eq!(tables.len(), 1);
    })
}

/// The session on the tilted base, changed, in a folder of its own.
fn tilted_session(change: impl FnOnce(&mut toml::Table)) -> TempDir {
    let experiment = tree::experiment("seven-joints-tilted");
    let mut session: toml::Table = tree::read_toml(&experiment.join("session.toml"));
    let robot = experiment.join(session["robot"].as_str().unwrap());
    session.insert("robot".into(), robot.to_str().unwrap().into());
    change(&mut session);
    let folder = tempfile::tempdir().unwrap();
    for table in session["poses"].as_array().unwrap() {
        let file = table["file"].as_str().unwrap();
        fs::copy(experiment.join(file), folder.path().join(file)).unwrap();
    }
    fs::write(folder.path().join("session.toml"), toml::to_string(&session).unwrap()).unwrap();
    folder
}

/// What the joint estimator makes of a session.
fn calibrated(session: &Path) -> (Run, Estimator) {
    let calibration = Calibration::with(session, &["--estimator", "joint"]);
    let joint = calibration.estimator("joint");
    (calibration.run, joint)
}

fn checked(session: &Path) -> (Run, CheckAnswer) {
    let run = gravcal(["check".as_ref(), session.as_os_str(), "--json".as_ref()]);
    let answer = serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}\n{run:?}"));
    (run, answer)
}

/// `check` must find the same combinations undetermined as the calibration; gives them as `check` tells them.
fn assert_foreseen(session: &Path) -> Vec<Undetermined> {
    let (run, check) = checked(session);
    assert_eq!((run.code, check.complete), (PARTLY, false), "{run:?}");
    let (_, joint) = calibrated(session);
    assert_eq!(combinations(&check.undetermined), combinations(&joint.undetermined));
    check.undetermined
}

fn assert_tilt_cures_the_first_joint(undetermined: &[Undetermined]) {
    let first: Vec<&Undetermined> = undetermined.iter().filter(|u| u.combination.starts_with("joint1.")).collect();
    assert!(!first.is_empty());
    for open in first {
        assert!(open.cure.contains("tilt"), "{open:?}");
    }
}

fn torque_gains(estimator: &Estimator) -> usize {
    estimator.estimated().filter(|parameter| parameter.name.ends_with(".torque_gain")).count()
}
