//! Tables of static poses of an arm with friction, from the simulation to the estimate: their rows stand as they were read.

use std::fs;
use std::path::Path;

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;
use gravcal_session::read_session;
use gravcal_session::simulation::{Simulation, write_session};
use gravcal_solvers::LevenbergMarquardt;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use crate::joint::{Signals, estimate_jointly, sides_by_order};
use crate::result::{Concern, EstimatorResult, ResidualTest, ResidualTestKind};
use crate::testing::TWO_JOINTS;

const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 17
[gravity]
direction = [0, 1, -3]
hemisphere = [0, 0, -1]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.001
[position]
unit = "rad"
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

/// So many joints move from one pose to the next.
const MOVING: &str = "poses = 30\nmoving = 1";

/// What friction leaves at rest, on the side from which a joint came, N·m; give or take a third of it.
const FRICTION: f64 = 0.01;

/// A session whose readings state no noise.
fn session(folder: &Path, (friction, compliance): (f64, f64), trial: u64) -> (Simulation, Session) {
    fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
    let text = SIMULATION.replace("COMPLIANCE", &format!("{compliance:e}"));
    fs::write(folder.join("simulation.toml"), text).unwrap();
    let simulation = Simulation::read(&folder.join("simulation.toml")).unwrap();
    let files = write_session(&simulation, trial, folder, true).unwrap();
    let mut session = read_session(&files[0]).unwrap();
    let sides = sides_by_order(&session);
    for (place, (pose, sides)) in session.poses.iter_mut().zip(&sides).enumerate() {
        for (joint, (reading, side)) in pose.torque.iter_mut().zip(sides).enumerate() {
            let reading = reading.as_mut().unwrap();
            let uneven = (12.9898 * (2 * place + joint) as f64).sin();
            reading.value += friction * side * (1.0 + 0.5 * uneven);
            reading.std = None;
        }
    }
    (simulation, session)
}

fn estimated((friction, compliance): (f64, f64), trial: u64) -> (Simulation, EstimatorResult) {
    let folder = tempfile::tempdir().unwrap();
    let (simulation, session) = session(folder.path(), (friction, compliance), trial);
    (simulation, estimate(&session))
}

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap()
}

/// Errors of all sensors' parameters in their standard deviations.
fn errors(simulation: &Simulation, result: &EstimatorResult) -> Vec<f64> {
    let quantities = ["torque_gain", "torque_bias", "position_gain", "position_offset"];
    let joints = ["shoulder", "elbow"].into_iter().enumerate();
    let names = joints.flat_map(|(joint, name)| quantities.iter().enumerate().map(move |(i, q)| (joint, i, name, q)));
    let error = |(joint, place, name, quantity): (usize, usize, &str, &&str)| {
        let found = result.parameter(&format!("{name}.{quantity}")).unwrap();
        let std = found.std.filter(|std| *std > 0.0)?;
        Some((found.value? - simulation.truth.sensors[joint][place]) / std)
    };
    names.filter_map(error).collect()
}

#[test]
fn friction_that_tables_show_is_an_unknown_and_intervals_hold() {
    for compliance in [0.0, 3e-4] {
        let (mut squares, mut named) = (Vec::new(), 0);
        for trial in 0..8 {
            let (simulation, result) = estimated((FRICTION, compliance), trial);
            assert!(!result.residual_tests.iter().any(|test| test.spoils_intervals), "{:?}", result.notes);
            let of_friction = |test: &&ResidualTest| test.kind == ResidualTestKind::Direction && test.named;
            for test in result.residual_tests.iter().filter(of_friction) {
                assert!((test.size / FRICTION - 1.0).abs() < 0.5 && !test.spoils_intervals, "{test:?}");
                named += 1;
            }
            squares.extend(errors(&simulation, &result).iter().map(|error| error * error));
        }
        let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!(named == 16 && rms > 0.6 && rms < 1.2, "{named} {rms}");
    }
}

/// Without friction no order of rows tells anything, and nothing costs precision.
#[test]
fn tables_without_friction_have_no_such_unknown() {
    let (_, without) = estimated((0.0, 0.0), 0);
    let (_, with) = estimated((FRICTION, 0.0), 0);
    let std = |result: &EstimatorResult| result.parameter("shoulder.position_gain").unwrap().std.unwrap();
    assert!(without.notes.iter().all(|note| !note.contains("may bend")), "{:?}", without.notes);
    assert!(with.notes.iter().any(|note| note.contains("as the order of the rows tells it")), "{:?}", with.notes);
    assert!(std(&with) > 2.0 * std(&without));
}

/// Tables of the shoulder rising to each of its poses, with and without friction: nothing but its bias differs, and no residual shows it.
#[test]
fn biases_allow_for_friction_that_no_residual_shows() {
    let bias = |friction: f64| {
        let folder = tempfile::tempdir().unwrap();
        let (simulation, mut sorted) = session(folder.path(), (0.0, 0.0), 0);
        sorted.poses.sort_by(|a, b| a.table.cmp(&b.table).then(a.position[0].total_cmp(&b.position[0])));
        sorted.poses.iter_mut().for_each(|pose| pose.torque[0].as_mut().unwrap().value += friction);
        let result = estimate(&sorted);
        assert_eq!(result.concerns, [Concern::OneSidedApproach { joints: vec!["shoulder".into()] }]);
        let told: Vec<&String> = result.notes.iter().filter(|note| note.contains("from the same side")).collect();
        assert!(told.len() == 1 && told[0].contains("tells: shoulder (±"), "{:?}", result.notes);
        let found = result.parameter("shoulder.torque_bias").unwrap();
        (found.value.unwrap() - simulation.truth.sensors[0][1], found.std.unwrap())
    };
    let [(off, std), (off_with, std_with)] = [0.0, 0.0015].map(bias);
    assert!((off_with - off - 0.0015).abs() < 1e-6 && (std_with / std - 1.0).abs() < 1e-6);
    // Twice the noise of a reading, of 0.001.
    assert!((std / 0.002 - 1.0).abs() < 0.3 && off.abs() < std, "{off} {std}");
}

/// One joint moves at a time: friction that stays in the other is one error, in however many rows.
#[test]
fn friction_that_stays_while_a_joint_stands_is_one_error() {
    let (mut squares, mut sizes) = (Vec::new(), Vec::new());
    for trial in 0..8 {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
        let text = SIMULATION.replace("COMPLIANCE", "0").replace("poses = 30", MOVING);
        fs::write(folder.path().join("simulation.toml"), text).unwrap();
        let simulation = Simulation::read(&folder.path().join("simulation.toml")).unwrap();
        let files = write_session(&simulation, trial, folder.path(), true).unwrap();
        let mut session = read_session(&files[0]).unwrap();
        let mut random = Pcg64::seed_from_u64(trial);
        let mut left = [0.0; 2];
        for place in 0..session.poses.len() {
            for (joint, left) in left.iter_mut().enumerate() {
                let here = &session.poses[place];
                let before = place.checked_sub(1).map(|before| &session.poses[before]);
                let stands = before.is_some_and(|before| before.position[joint] == here.position[joint]);
                if !stands || before.is_some_and(|before| before.table != here.table) {
                    *left = FRICTION * random.sample::<f64, _>(StandardNormal);
                }
                let reading = session.poses[place].torque[joint].as_mut().unwrap();
                reading.value += *left;
                reading.std = None;
            }
        }
        let result = estimate(&session);
        assert!(!result.residual_tests.iter().any(|test| test.spoils_intervals), "{:?}", result.notes);
        assert!(result.notes.iter().any(|note| note.starts_with("Errors stay the same from row to row")));
        sizes.extend(result.fit.as_ref().unwrap().joints.iter().map(|joint| joint.lasting_std.unwrap()));
        squares.extend(errors(&simulation, &result).iter().map(|error| error * error));
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(rms > 0.7 && rms < 1.2, "{rms}");
    // Some 15 stays a table of each joint tell it: to 13 %.
    assert!(sizes.iter().all(|size| (size / FRICTION - 1.0).abs() < 0.5), "{sizes:?}");
}
