//! Accuracy on the Sarcos shoulder, over many simulated sessions: joint estimation is at the Cramér-Rao bound, the bound is
//! that of an independent program, and the paper's steps are as accurate as in that program.
//!
//! The independent program is written in NumPy and SciPy; its figures are those of 400 draws, σ = 0.8 count, no converter.

use std::sync::OnceLock;

use gravcal_calibration::SolveEnvironment;
use gravcal_calibration::sequential::{Plan, run_steps};
use gravcal_session::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::measures::QuantityMeasures;

use crate::studies::{Study, Table};
use crate::tree;

/// Largest rms error of an efficient estimator over this many trials, as a multiple of the bound.
const TRIALS: u64 = 2000;
const AT_THE_BOUND: f64 = 1.08;
/// Estimators by groups of readings, over fewer trials: how far their rms errors may lie from those of the joint estimators that
/// read the same, of the same trials. The paper's steps with their covariance equal them; an information filter is linearized
/// before all is known.
const BY_GROUPS_TRIALS: u64 = 60;
const BY_STEPS_APART: f64 = 0.01;
const BY_POSES_APART: f64 = 0.08;
/// The same with the converter, over fewer trials.
const CONVERTER_TRIALS: u64 = 300;
const AT_THE_BOUND_ROUGHLY: f64 = 1.15;
/// Sessions whose sinusoids are looked at.
const SINUSOID_TRIALS: u64 = 100;

/// The Cramér-Rao bound of joint estimation from all torque readings, in the program's units.
const BOUND: [(&str, f64); 13] = [
    ("gravity.x", 0.0032),
    ("gravity.y", 0.0028),
    ("gravity.z", 0.0027),
    ("joint1.torque_gain", 0.0206),
    ("joint2.torque_gain", 0.0173),
    ("joint3.torque_gain", 0.0187),
    ("joint1.torque_bias", 0.114),
    ("joint2.torque_bias", 0.0579),
    ("joint3.torque_bias", 0.0779),
    ("joint1.position_gain", 0.00044),
    ("joint2.position_gain", 0.00043),
    ("joint3.position_gain", 0.00036),
    ("joint2.position_offset", 0.0240 * std::f64::consts::PI / 180.0),
];
/// How far our bound may lie from those figures, which have two or three digits.
const BOUND_TOLERANCE: f64 = 0.03;

/// Rms errors of the paper's steps.
const STEPS: [(&str, f64); 10] = [
    ("gravity.x", 0.109),
    ("gravity.y", 0.0148),
    ("gravity.z", 0.0567),
    ("joint1.torque_gain", 0.129),
    ("joint1.torque_bias", 0.283),
    ("joint2.torque_bias", 0.883),
    ("joint3.torque_bias", 1.50),
    ("joint1.position_gain", 0.00335),
    ("joint2.position_gain", 0.00626),
    ("joint3.position_gain", 0.0160),
];
const STEPS_TOLERANCE: f64 = 0.15;

/// Rms errors of step 3 that ours must not exceed: ours weighs the fitted coefficients by their covariance and is better.
const STEPS_AT_MOST: [(&str, f64); 2] =
    [("joint2.torque_gain", 0.156), ("joint2.position_offset", 0.793 * std::f64::consts::PI / 180.0)];

#[test]
fn joint_estimation_is_at_the_bound() {
    assert_at_the_bound(without_converter(), AT_THE_BOUND);
}

#[test]
fn joint_estimation_is_at_the_bound_with_the_converter() {
    let table = study(CONVERTER_TRIALS, &["joint-paper-signals", "joint"], "");
    assert_at_the_bound(&table, AT_THE_BOUND_ROUGHLY);
}

#[test]
fn estimation_by_groups_is_as_accurate_as_joint_estimation_from_the_same_readings() {
    let pairs =
        [("sequential-with-covariance", "joint-paper-signals", BY_STEPS_APART), ("recursive", "joint", BY_POSES_APART)];
    for (grouped, jointly, most) in pairs {
        let table = study(BY_GROUPS_TRIALS, &[grouped, jointly], WITHOUT_CONVERTER);
        for name in table.quantities() {
            let [one, other] = [grouped, jointly].map(|estimator| table.of(estimator, name));
            let name = format!("{name} of {grouped}");
            assert_eq!(one.estimates, BY_GROUPS_TRIALS, "{name}");
            assert_near(&name, one.rms.value, other.rms.value, most);
            assert!(one.rms.value != other.rms.value, "{name}: no estimate of its own");
        }
    }
}

#[test]
fn the_bound_is_that_of_an_independent_program() {
    for (name, reference) in BOUND {
        assert_near(name, column(name, "joint").bound, reference, BOUND_TOLERANCE);
    }
    assert_eq!(without_converter().quantities().count(), BOUND.len());
}

#[test]
fn the_steps_are_as_accurate_as_in_an_independent_program() {
    for (name, reference) in STEPS {
        assert_near(name, column(name, "sequential").rms.value, reference, STEPS_TOLERANCE);
    }
    for (name, most) in STEPS_AT_MOST {
        let found = column(name, "sequential").rms.value;
        assert!(found > 0.0 && found <= most, "{name}: {found}, at most {most}");
    }
    assert_eq!(column("joint3.torque_gain", "sequential").estimates, 0, "no step reaches the last joint's gain");
}

#[test]
fn sinusoids_fit_as_in_the_papers_figure_4() {
    let simulation = Simulation::read(&tree::experiment("sarcos-shoulder").join("simulation.toml")).unwrap();
    let (solver, quiet) = (LevenbergMarquardt::default(), |_: &str| {});
    let largest = |trial: u64| {
        let session = simulation.session(trial);
        let steps = run_steps(&session, &Plan::new(&session), &SolveEnvironment::new(&solver, &quiet));
        steps.largest_residuals.into_iter().flatten().fold(0.0, f64::max)
    };
    let mean = (0..SINUSOID_TRIALS).map(largest).sum::<f64>() / SINUSOID_TRIALS as f64;
    assert!((1.5..=3.0).contains(&mean), "{mean} counts");
}

const WITHOUT_CONVERTER: &str = "[[change]]\nfield = 'torque.converter'\ndrop = true\n";

fn study(trials: u64, estimators: &[&str], rest: &str) -> Table {
    let study = Study::new(&format!("trials = {trials}\nestimators = {estimators:?}\n{rest}"));
    assert_eq!(study.run("results", &[]).code, 0);
    study.table_of_measures("results")
}

/// The study without converter, run once for all tests.
fn without_converter() -> &'static Table {
    static STUDY: OnceLock<Table> = OnceLock::new();
    STUDY.get_or_init(|| study(TRIALS, &["sequential", "joint-paper-signals", "joint"], WITHOUT_CONVERTER))
}

fn column(name: &str, estimator: &str) -> &'static QuantityMeasures {
    without_converter().of(estimator, name)
}

/// Both columns of joint estimation answer in every trial, and are at the bound in everything.
fn assert_at_the_bound(table: &Table, most: f64) {
    for name in table.quantities() {
        for estimator in ["joint-paper-signals", "joint"] {
            let found = table.of(estimator, name);
            let ratio = found.ratio.value;
            assert_eq!(found.estimates, table.trials(), "{name} of {estimator}");
            assert!(ratio > 0.0 && ratio <= most, "{name} of {estimator}: {ratio} of the bound");
        }
    }
}

fn assert_near(name: &str, found: f64, reference: f64, tolerance: f64) {
    let apart = (found / reference - 1.0).abs();
    assert!(apart <= tolerance, "{name}: {found} is {:.1} % from {reference}", 100.0 * apart);
}
