//! Recordings whose joints come to their standstills from one side, or from that to which they go, from the simulation to the estimate.

use std::fs;
use std::io::Write;
use std::path::Path;

use gravcal_identification::SolveEnvironment;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, ResidualTest, ResidualTestKind};
use crate::testing::TWO_JOINTS;

/// Friction of 0.005 N·m leaves 2.5 times the noise of a mean.
const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 5
[gravity]
direction = [0, 1, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.001
[position]
unit = "rad"
std = 1e-6
[recording]
rate_hz = 200
samples = 100
move_s = 0.4
settling_s = 0.2
APPROACH
[[load]]
name = "plate"
mass_kg = 1
link = "forearm"
position_m = [0.1, 0, 0]
[[joint]]
name = "elbow"
SAID
[[random]]
file = "bare.csv"
poses = 30
[[random]]
file = "loaded.csv"
poses = 30
load = "plate"
"#;

const FRICTION: &str = "friction = { coulomb_newton_metre = [0, 0.005] }";

fn estimated(folder: &Path, approach: &str, said: &str, trial: u64) -> (Simulation, EstimatorResult) {
    fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
    let text = SIMULATION.replace("APPROACH", approach).replace("SAID", said);
    fs::write(folder.join("simulation.toml"), text).unwrap();
    let simulation = Simulation::read(&folder.join("simulation.toml")).unwrap();
    let files = write_session(&simulation, trial, folder, true).unwrap();
    // Here joints do not bend, which is said: what may bend them hides what friction does to position gains (`bending.rs`).
    let mut file = fs::OpenOptions::new().append(true).open(&files[0]).unwrap();
    writeln!(file, "[deflection]\ncompliance_std_rad_per_newton_metre = 0").unwrap();
    let session = read_session(&files[0]).unwrap();
    let solver = LevenbergMarquardt::default();
    let result = estimate_jointly(&session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap();
    (simulation, result)
}

/// Root mean squares of the errors of the elbow's bias in its standard deviations, of the trials whose report says that it includes friction and
/// of the others; and how many say so.
fn errors(approach: &str) -> ([f64; 2], usize) {
    let (mut squares, mut reported) = ([0.0; 2], 0);
    for trial in 0..10 {
        let folder = tempfile::tempdir().unwrap();
        let (simulation, result) = estimated(folder.path(), approach, "", trial);
        let bias = result.parameter("elbow.torque_bias").unwrap();
        let (Some(value), Some(std)) = (bias.value, bias.std) else { panic!("{result:?}") };
        let place = result.covariance.order.iter().position(|name| *name == "elbow.torque_bias").unwrap();
        assert!((result.covariance.matrix[place][place] / (std * std) - 1.0).abs() < 1e-9);
        let says_so = result.notes.iter().any(|note| note.starts_with("elbow was approached "));
        squares[usize::from(!says_so)] += ((value - simulation.truth.sensors[1][1]) / std).powi(2);
        reported += usize::from(says_so);
        // The shoulder has no friction, which nothing tells: it may have the elbow's.
        let of_shoulder = result.notes.iter().any(|note| note.starts_with("shoulder was approached"));
        assert!(says_so || !of_shoulder, "{:?}", result.notes);
        let bias = result.parameter("shoulder.torque_bias").unwrap();
        let error = (bias.value.unwrap() - simulation.truth.sensors[0][1]) / bias.std.unwrap();
        assert!(error.abs() < 4.0, "{error}");
    }
    ([(squares[0] / reported.max(1) as f64).sqrt(), (squares[1] / (10 - reported).max(1) as f64).sqrt()], reported)
}

#[test]
fn a_bias_that_holds_friction_is_widened_by_it() {
    let ([rms, _], reported) = errors(&format!("approach = \"one-way\"\n{FRICTION}"));
    // Friction as small as the noise does not always show beside it.
    assert!(rms < 1.5 && reported >= 8, "{rms} {reported}");
}

#[test]
fn from_both_sides_and_without_friction_nothing_holds_friction() {
    let ([_, rms], reported) = errors(FRICTION);
    assert!(rms < 1.5 && reported == 0, "{rms} {reported}");
    let ([_, rms], reported) = errors("approach = \"one-way\"");
    assert!(rms < 1.8 && reported == 0, "{rms} {reported}");
}

/// A joint comes to its highest poses from below: friction that is left at rest goes with the angle as errors of a position gain do.
#[test]
fn friction_that_goes_with_the_angle_is_distinguished_from_a_position_gain() {
    let friction = "friction = { coulomb_newton_metre = 0.01, lean = 0.6, spread = 0.1 }";
    let mut squares = Vec::new();
    for trial in 0..8 {
        let folder = tempfile::tempdir().unwrap();
        let (simulation, result) = estimated(folder.path(), friction, "", trial);
        for (joint, name) in ["shoulder", "elbow"].into_iter().enumerate() {
            let gain = result.parameter(&format!("{name}.position_gain")).unwrap();
            let std = gain.std.unwrap();
            // Without telling them apart it is known to 2e-4 or 3e-4.
            assert!(std < 1.5e-4, "{trial}: {gain:?}");
            squares.push(((gain.value.unwrap() - simulation.truth.sensors[joint][2]) / std).powi(2));
            let side = |test: &&ResidualTest| test.kind == ResidualTestKind::Direction && test.channel == name;
            let side = result.residual_tests.iter().find(side).unwrap();
            assert!(side.named && !side.spoils_intervals && (side.size / 0.006 - 1.0).abs() < 0.2, "{side:?}");
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(rms < 1.5, "{rms}");
}

/// Where the session estimates friction, the standstill from nowhere does not tell it from the bias.
#[test]
fn friction_and_bias_of_a_one_sided_joint_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let said = "sensor_models = [{ kind = \"coulomb-friction\", parameters = { coulomb_friction = { value = 0, unit = \"Nm\" } } }]";
    let (_, result) = estimated(folder.path(), &format!("approach = \"one-way\"\n{FRICTION}"), said, 0);
    let reported = |name: &str| result.parameter(name).unwrap().value.is_some();
    assert!(!reported("elbow.torque_bias") && !reported("elbow.coulomb_friction"), "{result:?}");
    assert!(reported("shoulder.torque_bias"));
}
