//! Every folder of `experiments` is calibrated: it must give what its `expected.toml` says, and where `truth.toml` tells
//! the true values, these must lie where the program says.
//!
//! `expected.toml`:
//!
//! ```toml
//! exit = 0                                   # exit code
//! needs_shared_data = true                   # optional: skip where the shared recordings are absent
//!
//! [estimator.joint]                          # one for each estimator that answers
//! verdict = "determined"
//! undetermined = ["joint3.position_offset"]  # names of the combinations, in the program's order
//! gravity_m_per_s2 = { value = [0, 0, -9.8], tolerance = [0.1, 0.1, 0.1] }
//!
//! [estimator.joint.parameters]               # optional
//! "joint1.torque_gain" = { value = 7.12, tolerance = 0.11 }
//! ```

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::answer::{Estimator, Parameter, combinations};
use crate::program::Calibration;
use crate::tree;

/// How many standard deviations an estimate may lie from the truth.
const FAR: f64 = 4.0;

/// `expected.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    #[serde(default)]
    needs_shared_data: bool,
    exit: i32,
    estimator: BTreeMap<String, ExpectedEstimator>,
}

/// What one estimator must answer.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExpectedEstimator {
    verdict: String,
    undetermined: Vec<String>,
    gravity_m_per_s2: Option<Near<[f64; 3]>>,
    #[serde(default)]
    parameters: BTreeMap<String, Near<f64>>,
}

/// A value and how far from it an answer may lie.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Near<T> {
    value: T,
    tolerance: T,
}

impl Near<f64> {
    fn holds(&self, found: f64) -> bool {
        (found - self.value).abs() <= self.tolerance
    }
}

/// `truth.toml`, apart from the placements of loads.
#[derive(Debug, Deserialize)]
struct Truth {
    gravity_m_per_s2: [f64; 3],
    parameter: Vec<TrueParameter>,
}

#[derive(Debug, Deserialize)]
struct TrueParameter {
    name: String,
    value: f64,
    unit: String,
}

#[test]
fn every_experiment_says_what_it_is_and_what_to_expect() {
    for experiment in tree::experiments() {
        for file in ["README.md", "expected.toml"] {
            assert!(experiment.join(file).is_file(), "{} has no {file}", experiment.display());
        }
    }
}

#[test]
fn every_experiment_gives_what_it_promises() {
    let wrong: Vec<String> = tree::experiments().iter().flat_map(|experiment| disappointments(experiment)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_truth_lies_within_four_standard_deviations() {
    let simulated = |experiment: &PathBuf| experiment.join("truth.toml").exists();
    let experiments: Vec<PathBuf> = tree::experiments().into_iter().filter(simulated).collect();
    assert!(!experiments.is_empty(), "no experiment knows its truth");
    let wrong: Vec<String> = experiments.iter().flat_map(|experiment| errors(experiment)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What an experiment gives that it does not promise.
fn disappointments(experiment: &Path) -> Vec<String> {
    let expected: Expected = tree::read_toml(&experiment.join("expected.toml"));
    let name = tree::name(experiment);
    if expected.needs_shared_data && !shared_data(experiment).is_dir() {
        say(&format!("SKIPPED: experiment {name}: there is no folder {}", shared_data(experiment).display()));
        return Vec::new();
    }
    let calibration = Calibration::of(&experiment.join("session.toml"));
    let mut wrong = Vec::new();
    if calibration.run.code != expected.exit {
        wrong.push(format!("exit code {} instead of {}", calibration.run.code, expected.exit));
    }
    wrong.extend(compare_all(&expected, &calibration.answer().estimators));
    wrong.into_iter().map(|wrong| format!("{name}: {wrong}")).collect()
}

/// Where an experiment's session looks for the shared recordings.
pub fn shared_data(experiment: &Path) -> PathBuf {
    let said = std::env::var("GRAVCAL_SHARED_DATA").ok().filter(|said| !said.is_empty());
    experiment.join(said.unwrap_or_else(|| "../../../shared/data".to_owned()))
}

/// Prints past the test harness, which keeps what a passing test prints with `println!`.
pub fn say(text: &str) {
    let mut stderr = std::io::stderr();
    writeln!(stderr, "{text}").unwrap();
}

fn compare_all(expected: &Expected, found: &[Estimator]) -> Vec<String> {
    let names: Vec<&String> = found.iter().map(|estimator| &estimator.name).collect();
    let missing = expected.estimator.keys().filter(|name| !names.contains(name));
    let mut wrong: Vec<String> = missing.map(|name| format!("no answer of {name}")).collect();
    for estimator in found {
        let differences = match expected.estimator.get(&estimator.name) {
            Some(expected) => compare(expected, estimator),
            None => vec!["not expected to answer".to_owned()],
        };
        let inconsistent = estimator.parameters.iter().filter_map(inconsistency);
        let all = differences.into_iter().chain(inconsistent);
        wrong.extend(all.map(|difference| format!("{}: {difference}", estimator.name)));
    }
    wrong
}

fn compare(expected: &ExpectedEstimator, found: &Estimator) -> Vec<String> {
    let mut wrong = Vec::new();
    if found.verdict != expected.verdict {
        wrong.push(format!("{} instead of {}", found.verdict, expected.verdict));
    }
    let undetermined = combinations(&found.undetermined);
    if undetermined != expected.undetermined {
        wrong.push(format!("undetermined are {undetermined:?} instead of {:?}", expected.undetermined));
    }
    wrong.extend(compare_gravity(expected.gravity_m_per_s2.as_ref(), found));
    wrong.extend(expected.parameters.iter().filter_map(|(name, near)| compare_parameter(name, near, found)));
    wrong
}

fn compare_gravity(expected: Option<&Near<[f64; 3]>>, found: &Estimator) -> Option<String> {
    let found = found.gravity.as_ref().map(|gravity| gravity.vector_m_per_s2);
    let agree = match (expected, found) {
        (Some(near), Some(found)) => axes(near).zip(found).all(|(near, found)| near.holds(found)),
        (expected, found) => expected.is_none() && found.is_none(),
    };
    (!agree).then(|| format!("gravity is {found:?}, expected {expected:?}"))
}

fn axes(near: &Near<[f64; 3]>) -> impl Iterator<Item = Near<f64>> {
    near.value.into_iter().zip(near.tolerance).map(|(value, tolerance)| Near { value, tolerance })
}

fn compare_parameter(name: &str, near: &Near<f64>, found: &Estimator) -> Option<String> {
    let value = found.parameter(name).and_then(|parameter| parameter.value);
    let agree = value.is_some_and(|value| near.holds(value));
    (!agree).then(|| format!("{name} is {value:?}, expected {near:?}"))
}

/// What is undetermined has no value, and what is determined has one with its uncertainty.
fn inconsistency(parameter: &Parameter) -> Option<String> {
    let given = [parameter.value.is_some(), parameter.std.is_some(), parameter.ci95.is_some()];
    let sound = given == [parameter.determined; 3];
    (!sound).then(|| format!("value, std and interval do not agree with `determined` in {parameter:?}"))
}

/// Where the joint estimator's answer lies too far from the truth for the uncertainty it states.
fn errors(experiment: &Path) -> Vec<String> {
    let truth: Truth = tree::read_toml(&experiment.join("truth.toml"));
    let joint = Calibration::of(&experiment.join("session.toml")).estimator("joint");
    let mut wrong: Vec<String> = joint.estimated().filter_map(|parameter| parameter_error(parameter, &truth)).collect();
    wrong.extend(gravity_errors(&joint, &truth));
    let name = tree::name(experiment);
    assert!(joint.estimated().count() > 0, "{name}: nothing was estimated");
    wrong.into_iter().map(|wrong| format!("{name}: {wrong}")).collect()
}

fn parameter_error(parameter: &Parameter, truth: &Truth) -> Option<String> {
    let name = &parameter.name;
    let Some(truth) = truth.parameter.iter().find(|truth| truth.name == *name) else {
        return Some(format!("truth.toml does not tell {name}"));
    };
    if parameter.unit != truth.unit {
        return Some(format!("{name} is in {}, its truth in {}", parameter.unit, truth.unit));
    }
    error(name, parameter.value?, parameter.std?, truth.value)
}

fn gravity_errors(joint: &Estimator, truth: &Truth) -> Vec<String> {
    let Some(gravity) = &joint.gravity else { return vec!["gravity is undetermined".to_owned()] };
    let axes = ["gravity.x", "gravity.y", "gravity.z"].into_iter().enumerate();
    let one = |(axis, name): (usize, &str)| {
        error(name, gravity.vector_m_per_s2[axis], gravity.std_m_per_s2[axis], truth.gravity_m_per_s2[axis])
    };
    axes.filter_map(one).collect()
}

fn error(name: &str, value: f64, std: f64, truth: f64) -> Option<String> {
    let near = std > 0.0 && (value - truth).abs() <= FAR * std;
    (!near).then(|| format!("{name} is {value} ± {std}, its truth {truth}"))
}
