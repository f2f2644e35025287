//! Sessions on which the program once told wrong numbers, none, or the wrong cause, with their truth: nothing that is told may be far from it.
//!
//! They lie in the shared data, and are tried where these are.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::experiments::say;
use crate::program::gravcal_in;
use crate::tree;

/// No value is farther from the truth, in its own standard deviations.
const FARTHEST: f64 = 5.0;

fn sessions() -> Option<PathBuf> {
    let folder = tree::root().join("../shared/data/damaged/sessions");
    if !folder.is_dir() {
        say(&format!("SKIPPED: there is no folder {}", folder.display()));
        return None;
    }
    Some(folder)
}

/// The joint estimate of a session, and the exit code.
fn calibrated(session: &Path) -> (Value, i32) {
    let folder = TempDir::new().unwrap();
    let (session, output) = (session.join("session.toml"), folder.path().join("out"));
    let arguments: [&OsStr; 7] = [
        "calibrate".as_ref(),
        session.as_ref(),
        "--estimator".as_ref(),
        "joint".as_ref(),
        "--quiet".as_ref(),
        "--output".as_ref(),
        output.as_ref(),
    ];
    let run = gravcal_in(folder.path(), arguments);
    let text = fs::read_to_string(output.join("calibration.json")).unwrap_or_else(|error| panic!("{error}: {run:?}"));
    let file: Value = serde_json::from_str(&text).unwrap();
    (file["estimators"][0].clone(), run.code)
}

fn truth(session: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(session.join("truth.json")).unwrap()).unwrap()
}

/// The true value of each parameter of a joint or instrument, by name.
fn true_value(truth: &Value, name: &str) -> Option<f64> {
    if let Some(all) = truth.get("truth") {
        return all.get(name)?.as_f64();
    }
    let (joint, quantity) = name.rsplit_once('.')?;
    let place = truth["joints"].as_array()?.iter().position(|other| other == joint)?;
    let key = match quantity {
        "torque_gain" => "k",
        "torque_bias" => "b",
        "position_gain" => "s",
        "position_offset" => "o",
        _ => return None,
    };
    truth[key][place].as_f64()
}

/// Holds everything that is told against the truth; gives how many numbers that were.
fn assert_true(what: &str, estimate: &Value, truth: &Value) -> usize {
    let mut reported = 0;
    for parameter in estimate["parameters"].as_array().unwrap() {
        let (Some(value), Some(std)) = (parameter["value"].as_f64(), parameter["std"].as_f64()) else { continue };
        let name = parameter["name"].as_str().unwrap();
        let Some(true_value) = true_value(truth, name).filter(|_| std > 0.0) else { continue };
        reported += 1;
        let z = (value - true_value) / std;
        assert!(z.abs() < FARTHEST, "{what}: {name} is {value} ± {std}, and truly {true_value}: {z:.1}");
    }
    let axis = |vector: &Value, i: usize| vector[i].as_f64().unwrap();
    if let Some(gravity) = estimate.get("gravity").filter(|gravity| !gravity.is_null()) {
        let along: f64 = (0..3).map(|i| axis(&gravity["vector_m_per_s2"], i) * axis(&truth["g"], i)).sum();
        assert!(along > 0.0, "{what}: gravity is upside down");
    }
    reported
}

#[test]
fn nothing_is_reported_that_is_far_from_the_truth() {
    let Some(sessions) = sessions() else { return };
    // Name, and how many numbers are told at least: what the readings determine is not withheld.
    let expected = [
        ("upside-down", 15),
        ("dropped-coefficient", 3),
        ("dropped-gravity", 5),
        ("held-nominal", 3),
        ("bare-upright-not-converged", 8),
        ("ft-matrix-two-placements", 25),
        ("ft-matrix-one-placement", 20),
        ("ft-tool-moment", 15),
        ("bare-gains-within", 15),
        ("gain-on-its-bound", 20),
        ("bare-then-bare/all", 15),
    ];
    for (name, least) in expected {
        let session = sessions.join(name);
        let (estimate, code) = calibrated(&session);
        assert!([0, 3].contains(&code), "{name}: exit code {code}, {}", estimate["termination"]);
        let reported = assert_true(name, &estimate, &truth(&session));
        assert!(reported >= least, "{name}: {reported} numbers are told, and {least} should be");
    }
}

/// Sessions whose prior is a calibration of bare poses, which says nothing of the common scale.
#[test]
fn knowledge_without_a_scale_contradicts_no_right_session() {
    let Some(sessions) = sessions() else { return };
    for name in ["prior-of-bare", "bare-then-bare"] {
        let folder = TempDir::new().unwrap();
        let place = folder.path().join("data/damaged/sessions").join(name);
        for part in ["one", "two"] {
            copy(&sessions.join(name).join(part), &place.join(part));
            let path = place.join(part).join("session.toml");
            let urdf = tree::root().join("../shared/data/urdf").canonicalize().unwrap();
            let text = fs::read_to_string(&path).unwrap().replace("../../../../urdf", &urdf.to_string_lossy());
            fs::write(&path, text).unwrap();
        }
        let run = |part: &str| {
            let run = gravcal_in(
                &place.join(part),
                ["calibrate", "--full", "session.toml", "--estimator", "joint", "--quiet"],
            );
            assert!([0, 3].contains(&run.code), "{name}/{part}: {run:?}");
            let text = fs::read_to_string(place.join(part).join("calibration/calibration.json")).unwrap();
            let file: Value = serde_json::from_str(&text).unwrap();
            assert_true(&format!("{name}/{part}"), &file["estimators"][0], &truth(&place.join(part)))
        };
        assert!(run("one") >= 15 && run("two") >= 15, "{name}");
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for file in tree::entries(from).into_iter().filter(|entry| entry.is_file()) {
        fs::write(to.join(tree::name(&file)), fs::read(&file).unwrap()).unwrap();
    }
}

#[test]
fn swapped_columns_are_named() {
    let Some(sessions) = sessions() else { return };
    let (estimate, code) = calibrated(&sessions.join("swapped-slow"));
    assert_eq!(code, 4);
    assert_eq!(estimate["termination"], "swapped torque columns: panda_joint2 and panda_joint4");
}

#[test]
fn a_first_session_of_an_upright_arm_gets_its_answer() {
    let Some(sessions) = sessions() else { return };
    let (estimate, code) = calibrated(&sessions.join("no-step-lowers-the-cost"));
    assert_eq!(code, 3, "{}", estimate["termination"]);
    let reported = |quantity: &str| {
        let named = |p: &&Value| p["name"].as_str().unwrap().ends_with(quantity) && p["value"].is_number();
        estimate["parameters"].as_array().unwrap().iter().filter(named).count()
    };
    assert!(
        reported("torque_bias") >= 6 && reported("position_gain") >= 4,
        "{} {}",
        reported("torque_bias"),
        reported("position_gain")
    );
}
