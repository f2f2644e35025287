//! The program with models of this crate: from a simulation with known truth to a calibrated recording.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const ROBOT: &str = "../../models/sarcos-dextrous-arm/robot.toml";
const SIMULATION: &str = include_str!("simulation.toml");

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gravcal-extension")).current_dir(folder).args(arguments).output().unwrap()
}

fn simulated() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(ROBOT), folder.path().join("robot.toml")).unwrap();
    std::fs::write(folder.path().join("simulation.toml"), SIMULATION).unwrap();
    let out = run(folder.path(), &["simulate", "simulation.toml"]);
    assert!(out.status.success(), "{out:?}");
    folder
}

/// True values that the simulation's models have, in the units of results.
const TRUTH: [(&str, f64); 8] = [
    ("joint2.ripple_amplitude", 5.0),
    ("joint2.ripple_order", 6.1),
    ("joint2.ripple_phase", 0.4),
    ("joint2.play", 0.02),
    ("joint3.wave", 4.0),
    ("joint3.number", 3.1),
    ("joint3.shift", -0.3),
    ("joint1.torque_bias", 2075.0),
];

#[test]
fn what_models_of_another_crate_and_formulas_say_is_found() {
    let folder = simulated();
    let session = std::fs::read_to_string(folder.path().join("session.toml")).unwrap();
    assert!(session.contains("kind = \"torque-ripple\"") && session.contains("kind = \"backlash\""), "{session}");

    let out = run(folder.path(), &["check", "session.toml"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success() && reported.contains("ripple_order"), "{out:?}");

    let out = run(folder.path(), &["calibrate", "session.toml", "-o", "results", "--full"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert_eq!(out.status.code(), Some(0), "{reported} {out:?}");
    assert!(reported.contains("reading = ... + wave * sin(number * position + shift)"), "{reported}");
    let results = std::fs::read(folder.path().join("results/calibration.json")).unwrap();
    let results: Value = serde_json::from_slice(&results).unwrap();
    let joint = results["estimators"].as_array().unwrap().iter().find(|one| one["name"] == "joint").unwrap();
    for (name, truth) in TRUTH {
        let reported =
            joint["parameters"].as_array().unwrap().iter().find(|reported| reported["name"] == name).unwrap();
        let [value, std] = ["value", "std"].map(|key| reported[key].as_f64().unwrap());
        assert!(std > 0.0 && (value - truth).abs() < 3.5 * std, "{name}: {value} ± {std}, truly {truth}");
    }
    let tested: Vec<&str> =
        joint["sensor_models"].as_array().unwrap().iter().map(|one| one["model"].as_str().unwrap()).collect();
    assert_eq!(tested, ["torque-ripple", "backlash", "formula"]);
}

/// The torque readings of a table become torques again, ripple and all.
#[test]
fn a_calibration_with_such_models_is_applied() {
    let folder = simulated();
    let out = run(folder.path(), &["calibrate", "session.toml", "-o", "results", "--quiet"]);
    assert_eq!(out.status.code(), Some(0), "{out:?}");
    let out = run(
        folder.path(),
        &["apply", "results/calibration.json", "load-1a.csv", "applied.csv", "--residual", "--load", "plate-a"],
    );
    assert!(out.status.success(), "{out:?}");
    let text = std::fs::read_to_string(folder.path().join("applied.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let column = lines.next().unwrap().split(',').position(|name| name == "joint2_torque_count").unwrap();
    let residuals: Vec<f64> = lines.map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    // Noise of 0.8 counts at 6 counts a N·m; a ripple of 5 counts left in it would be 0.8 N·m high.
    let largest = residuals.iter().fold(0.0_f64, |largest, residual| largest.max(residual.abs()));
    assert!(residuals.len() == 37 && largest < 0.6, "{residuals:?}");
}

#[test]
fn an_unknown_model_is_refused_with_the_known_ones() {
    let folder = simulated();
    let file = folder.path().join("session.toml");
    let session = std::fs::read_to_string(&file).unwrap().replace("\"torque-ripple\"", "\"torque-riple\"");
    std::fs::write(&file, session).unwrap();
    let out = run(folder.path(), &["check", "session.toml"]);
    let reported = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(2), "{reported}");
    let expected =
        "there is no sensor model `torque-riple` (did you mean `torque-ripple`?); known: torque-bias-in-time";
    assert!(reported.contains(expected) && reported.contains("backlash"), "{reported}");
}

/// The method of this crate by name: on the command line, and with an option in the session.
#[test]
fn a_method_of_this_crate_is_chosen_by_name() {
    let folder = simulated();
    let calibrate = |arguments: &[&str]| {
        let all = ["calibrate", "session.toml", "--estimator", "joint", "-o", "results", "--overwrite"];
        run(folder.path(), &[&all, arguments].concat())
    };
    let out = calibrate(&["--solver", "marquardt"]);
    assert_eq!(out.status.code(), Some(0), "{out:?}");
    let results: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("results/calibration.json")).unwrap()).unwrap();
    assert!(results.to_string().contains("\"marquardt\""), "the results say which method found them");

    let out = calibrate(&["--solver", "marquart"]);
    let reported = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(
        out.status.code() == Some(2) && reported.contains("levenberg-marquardt") && reported.contains("marquardt"),
        "{reported}"
    );

    let file = folder.path().join("session.toml");
    let session = std::fs::read_to_string(&file).unwrap();
    let refused = |solver: &str, expected: &str| {
        std::fs::write(&file, format!("solver = {solver}\n{session}")).unwrap();
        let out = calibrate(&[]);
        let reported = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && reported.contains(expected), "{expected}: {reported}");
    };
    refused(
        "{ name = \"marquardt\", iterations = 5 }",
        "solver.iterations: marquardt has no such option; it has: max_iterations",
    );
    refused(
        "{ name = \"marquardt\", max_iterations = 0 }",
        "solver.max_iterations: expected one iteration at least, found 0",
    );
    refused(
        "\"simplex\"",
        "unknown solver `simplex`; there is: levenberg-marquardt, gauss-newton, dogleg, variable-projection, clarabel, marquardt",
    );
    // Its options are heeded: one iteration is too few.
    std::fs::write(&file, format!("solver = {{ name = \"marquardt\", max_iterations = 1 }}\n{session}")).unwrap();
    let out = calibrate(&[]);
    assert_eq!(out.status.code(), Some(4), "{out:?}");
}

#[test]
fn the_help_lists_the_models_of_this_crate() {
    let out = run(Path::new("."), &["--help"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(reported.contains("torque-ripple") && reported.contains("coulomb-friction"), "{reported}");
    let out = run(Path::new("."), &["calibrate", "--help"]);
    let reported = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(reported.contains("marquardt") && reported.contains("dogleg"), "{reported}");
}
