//! Recordings of arms with friction whose joints bend, which their position sensors do not see.

use std::fs;
use std::io::Write;
use std::path::Path;

use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;

use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, ResidualTest, ResidualTestKind};
use crate::testing::TWO_JOINTS;
use gravcal_identification::SolveEnvironment;

/// Joints bend by COMPLIANCE: by 3 mrad where they carry 6 N·m.
const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 11
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
friction = { coulomb_newton_metre = 0.03 }
[deflection]
compliance_rad_per_newton_metre = COMPLIANCE
[[load]]
name = "plate"
mass_kg = 1
link = "forearm"
position_m = [0.1, 0, 0]
[[random]]
file = "bare.csv"
poses = 30
[[random]]
file = "loaded.csv"
poses = 30
load = "plate"
"#;

const COMPLIANCE: f64 = 5e-4;

/// `said`: what is added to the session.
fn estimated(folder: &Path, compliance: f64, said: &str, trial: u64) -> (Simulation, EstimatorResult) {
    fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
    let text = SIMULATION.replace("COMPLIANCE", &format!("{compliance:e}"));
    fs::write(folder.join("simulation.toml"), text).unwrap();
    let simulation = Simulation::read(&folder.join("simulation.toml")).unwrap();
    let files = write_session(&simulation, trial, folder, true).unwrap();
    writeln!(fs::OpenOptions::new().append(true).open(&files[0]).unwrap(), "{said}").unwrap();
    let session = read_session(&files[0]).unwrap();
    let solver = LevenbergMarquardt::default();
    let result = estimate_jointly(&session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap();
    (simulation, result)
}

/// Errors of the position gains, in standard deviations.
fn errors(simulation: &Simulation, result: &EstimatorResult) -> [f64; 2] {
    ["shoulder", "elbow"].map(|name| {
        let gain = result.parameter(&format!("{name}.position_gain")).unwrap();
        let joint = usize::from(name == "elbow");
        (gain.value.unwrap() - simulation.truth.sensors[joint][2]) / gain.std.unwrap()
    })
}

#[test]
fn what_bends_a_joint_is_distinguished_from_its_position_gain() {
    let (mut squares, mut named) = (Vec::new(), 0);
    for trial in 0..8 {
        let folder = tempfile::tempdir().unwrap();
        let (simulation, result) = estimated(folder.path(), COMPLIANCE, "", trial);
        squares.extend(errors(&simulation, &result).map(|error| error * error));
        let bends = |test: &&ResidualTest| test.kind == ResidualTestKind::Compliance && test.channel == "elbow";
        let test = result.residual_tests.iter().find(bends).unwrap();
        assert!(!test.named || (test.size / COMPLIANCE - 1.0).abs() < 0.5, "{test:?}");
        assert!(!result.residual_tests.iter().any(|test| test.spoils_intervals), "{:?}", result.notes);
        named += usize::from(test.named);
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(rms < 1.5 && named >= 6, "{rms} {named}");
}

/// Position sensors behind the gears see what bends: gains are known better where that is said.
#[test]
fn joints_that_are_said_not_to_bend_have_gains_that_are_known_better() {
    let shoulder = |said: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (_, result) = estimated(folder.path(), 0.0, said, 0);
        let tested = result.residual_tests.iter().filter(|test| test.kind == ResidualTestKind::Compliance).count();
        (result.parameter("shoulder.position_gain").unwrap().std.unwrap(), tested)
    };
    let (open, of_unknowns) = shoulder("");
    let (stiff, of_residuals) = shoulder("[deflection]\ncompliance_std_rad_per_newton_metre = 0");
    assert!(open > 1.05 * stiff && open < 2.0 * stiff, "{open} {stiff}");
    // That all joints bend alike is looked for only where it is no unknown.
    assert!(of_unknowns <= 2 && of_residuals == 3, "{of_unknowns} {of_residuals}");
}
