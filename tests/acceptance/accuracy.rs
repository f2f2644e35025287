//! Accuracy on the Sarcos shoulder, over many simulated sessions: joint estimation is at the Cramér-Rao bound, the bound is
//! that of an independent program, and the paper's steps are as accurate as in that program.
//!
//! The independent program is written in NumPy and SciPy; its figures are those of 400 draws, σ = 0.8 count, no converter.

use std::sync::OnceLock;

use gravcal_calibration::Session;
use gravcal_calibration::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;
use gravcal_study::{Accuracy, Column, ColumnAccuracy, Measured, accuracy};

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

/// What most tests here look at.
const COLUMNS: [Column; 3] = [Column::Sequential, Column::JointPaperSignals, Column::Joint];

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
    let (session, table) = without_converter();
    assert_at_the_bound(session, table, AT_THE_BOUND);
}

#[test]
fn joint_estimation_is_at_the_bound_with_the_converter() {
    let simulation = simulation();
    assert!(simulation.disturbance.converter.is_some());
    let table = study(&simulation, CONVERTER_TRIALS, &COLUMNS);
    assert_at_the_bound(&simulation.session(0), &table, AT_THE_BOUND_ROUGHLY);
}

#[test]
fn estimation_by_groups_is_as_accurate_as_joint_estimation_from_the_same_readings() {
    let mut simulation = simulation();
    simulation.disturbance.converter = None;
    let session = simulation.session(0);
    let pairs = [
        (Column::SequentialWithCovariance, Column::JointPaperSignals, BY_STEPS_APART),
        (Column::Recursive, Column::Joint, BY_POSES_APART),
    ];
    for (grouped, jointly, most) in pairs {
        let table = study(&simulation, BY_GROUPS_TRIALS, &[grouped, jointly]);
        for (measured, columns) in &table.rows {
            let name = format!("{} of {}", Measured::name(*measured, &session), grouped.name());
            assert_eq!(columns[0].answers as u64, table.trials, "{name}");
            assert_near(&name, columns[0].rms_error, columns[1].rms_error, most);
            assert!(columns[0].rms_error != columns[1].rms_error, "{name}: no estimate of its own");
        }
    }
}

#[test]
fn the_bound_is_that_of_an_independent_program() {
    for (name, reference) in BOUND {
        let bound = column(name, Column::Joint).bound.unwrap();
        assert_near(name, bound, reference, BOUND_TOLERANCE);
    }
    assert_eq!(without_converter().1.rows.len(), BOUND.len());
}

#[test]
fn the_steps_are_as_accurate_as_in_an_independent_program() {
    for (name, reference) in STEPS {
        assert_near(name, column(name, Column::Sequential).rms_error, reference, STEPS_TOLERANCE);
    }
    for (name, most) in STEPS_AT_MOST {
        let found = column(name, Column::Sequential).rms_error;
        assert!(found > 0.0 && found <= most, "{name}: {found}, at most {most}");
    }
    assert_eq!(column("joint3.torque_gain", Column::Sequential).answers, 0, "no step reaches the last joint's gain");
}

#[test]
fn sinusoids_fit_as_in_the_papers_figure_4() {
    let largest = without_converter().1.largest_sinusoid_residual.unwrap();
    assert!((1.5..=3.0).contains(&largest), "{largest} counts");
}

fn simulation() -> Simulation {
    Simulation::read(&tree::experiment("sarcos-shoulder").join("simulation.toml")).unwrap()
}

fn study(simulation: &Simulation, trials: u64, columns: &[Column]) -> Accuracy {
    accuracy(simulation, trials, columns, &LevenbergMarquardt::default(), &|| {}).unwrap()
}

/// The study without converter, run once for all tests, and one of its sessions for the names.
fn without_converter() -> &'static (Session, Accuracy) {
    static STUDY: OnceLock<(Session, Accuracy)> = OnceLock::new();
    STUDY.get_or_init(|| {
        let mut simulation = simulation();
        simulation.disturbance.converter = None;
        let table = study(&simulation, TRIALS, &COLUMNS);
        (simulation.session(0), table)
    })
}

fn column(name: &str, column: Column) -> ColumnAccuracy {
    let (session, table) = without_converter();
    let (_, columns) = table.rows.iter().find(|(measured, _)| measured.name(session) == name).unwrap();
    columns[place(column)]
}

/// Where a column stands among [`COLUMNS`].
fn place(column: Column) -> usize {
    COLUMNS.iter().position(|other| *other == column).unwrap()
}

/// Both columns of joint estimation answer in every trial, and are at the bound in everything.
fn assert_at_the_bound(session: &Session, table: &Accuracy, most: f64) {
    for (measured, columns) in &table.rows {
        for column in [Column::JointPaperSignals, Column::Joint] {
            let found = columns[place(column)];
            let ratio = found.rms_error / found.bound.unwrap();
            let name = format!("{} of {}", Measured::name(*measured, session), column.name());
            assert_eq!(found.answers as u64, table.trials, "{name}");
            assert!(ratio > 0.0 && ratio <= most, "{name}: {ratio} of the bound");
        }
    }
}

fn assert_near(name: &str, found: f64, reference: f64, tolerance: f64) {
    let apart = (found / reference - 1.0).abs();
    assert!(apart <= tolerance, "{name}: {found} is {:.1} % from {reference}", 100.0 * apart);
}
