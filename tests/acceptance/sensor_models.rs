//! Sensors beyond gain and bias, from simulation to report, and sensors that read the other way.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::experiments::{say, shared_data};
use crate::program::{calibrate_into, gravcal_in};
use crate::tree;

/// The part of `calibration.json` about sensor models.
#[derive(Debug, Deserialize)]
struct Answer {
    estimators: Vec<Estimator>,
}

#[derive(Debug, Deserialize)]
struct Estimator {
    name: String,
    #[serde(default)]
    sensor_models: Vec<ModelTest>,
}

#[derive(Debug, Deserialize)]
struct ModelTest {
    joint: String,
    model: String,
    test: Option<Test>,
}

#[derive(Debug, Deserialize)]
struct Test {
    kind: String,
    p_value: f64,
}

fn models(results: &Path) -> Vec<ModelTest> {
    let answer: Answer = serde_json::from_slice(&fs::read(results.join("calibration.json")).unwrap()).unwrap();
    let joint = answer.estimators.into_iter().find(|estimator| estimator.name == "joint");
    joint.unwrap().sensor_models
}

const CONDITIONS: &str = "[conditions]\npose_interval_s = 10.0\ndirection = true\n";
const MODELS: &str = r#"sensor_models = [
    { kind = "torque-bias-in-time", parameters = { torque_bias_drift = { value = 0.002, unit = "count/s" } } },
    { kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.0, unit = "count" } } },
]
"#;

/// A simulated session whose second sensor drifts, and is said to have friction, too, which it has not.
fn drifting() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let simulation = fs::read_to_string(tree::experiment("sarcos-shoulder").join("simulation.toml")).unwrap();
    let robot = tree::root().join("models/sarcos-dextrous-arm/robot.toml");
    fs::copy(robot, folder.path().join("robot.toml")).unwrap();
    let simulation = simulation.replace("../../models/sarcos-dextrous-arm/robot.toml", "robot.toml");
    let second = "[[joint]]\nname = \"joint2\"\n";
    let simulation = simulation.replace(second, &format!("{CONDITIONS}\n{second}{MODELS}"));
    fs::write(folder.path().join("simulation.toml"), simulation).unwrap();
    let run = gravcal_in(folder.path(), ["simulate", "simulation.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    folder
}

#[test]
fn a_drift_is_simulated_estimated_tested_and_reported() {
    let folder = drifting();
    let session = folder.path().join("session.toml");
    let results = folder.path().join("results");
    let run = calibrate_into(&results, &session, &[]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stdout.contains("torque_bias_drift  count/s"), "{}", run.stdout);
    assert!(run.stdout.contains("Sensor models, each tested against its absence"), "{}", run.stdout);
    assert!(run.stdout.contains("The steps know only affine sensors"), "{}", run.stdout);
    let models = models(&results);
    let reported: Vec<(&str, &str)> =
        models.iter().map(|reported| (reported.joint.as_str(), reported.model.as_str())).collect();
    assert_eq!(reported, [("joint2", "torque-bias-in-time"), ("joint2", "coulomb-friction")]);
    let [drift, friction] = [0, 1].map(|place: usize| models[place].test.as_ref().unwrap());
    assert!(drift.kind == "likelihood-ratio" && drift.p_value < 1e-9, "{drift:?}");
    assert!(friction.p_value > 1e-3, "{friction:?}");
}

#[test]
fn check_tells_what_of_a_model_can_be_known() {
    let folder = drifting();
    let run = gravcal_in(folder.path(), ["check", "--full", "session.toml"]);
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stdout.contains("torque_bias_drift  count/s"), "{}", run.stdout);
}

/// All sensors of the recorded arm read the other way; nothing but the robot's masses can tell.
#[test]
fn the_real_arm_with_its_sign_not_declared_is_reported_so() {
    let experiment = tree::experiment("kuka-lbr-med7");
    let data = shared_data(&experiment);
    if !data.is_dir() {
        return say(&format!("SKIPPED: reversed sensors of a real arm: there is no folder {}", data.display()));
    }
    let folder = tempfile::tempdir().unwrap();
    let declared = fs::read_to_string(experiment.join("session.toml")).unwrap();
    let session = declared.replace("torque_sign = \"reversed\"\n", "");
    let session = session.replace("${GRAVCAL_SHARED_DATA:-../../../shared/data}", &data.to_string_lossy());
    fs::write(folder.path().join("session.toml"), session).unwrap();
    let run = calibrate_into(&folder.path().join("results"), &folder.path().join("session.toml"), &[]);
    assert_eq!(run.code, 4, "{run:?}");
    let reported = run.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(reported.contains("reversed torque sensors: A1, A2, A3, A4, A5, A6, A7"), "{reported}");
    assert!(reported.contains("Say torque_sign = \"reversed\" in the [[joint]] of each"), "{reported}");
    let results = fs::read(folder.path().join("results/calibration.json")).unwrap();
    let answer: crate::answer::Answer = serde_json::from_slice(&results).unwrap();
    for estimator in &answer.estimators {
        assert_eq!((estimator.verdict.as_str(), estimator.gravity.is_none()), ("failed", true));
        assert!(estimator.estimated().next().is_none(), "{estimator:?}");
    }
}
