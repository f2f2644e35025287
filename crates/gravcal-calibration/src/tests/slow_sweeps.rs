//! Slow sweeps of joints with friction, from the recording to the estimate: errors are as large as their standard deviations say.

mod standstills;

use std::fs;
use std::path::Path;

use gravcal_identification::SolveEnvironment;
use gravcal_recording::inspect;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{Session, UnexplainedError};
use gravcal_session::draft::{Draft, DraftRobot};
use gravcal_session::{read_robot, read_session};
use gravcal_solvers::LevenbergMarquardt;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use crate::joint::{Signals, State, build_problem, estimate_jointly, select};
use crate::result::EstimatorResult;
use crate::testing::TWO_JOINTS;

const GRAVITY: [f64; 3] = [1.2, -3.5, -9.077_444];
const RATE: f64 = 100.0;
/// Of a sample, N·m.
const NOISE: f64 = 0.05;

struct TrueJoint {
    gain: f64,
    bias: f64,
    position_gain: f64,
    offset: f64,
    friction: f64,
}

const TRUTH: [TrueJoint; 2] = [
    TrueJoint { gain: 1.0, bias: 0.7, position_gain: 1.01, offset: 0.0, friction: 0.5 },
    TrueJoint { gain: 1.2, bias: -0.4, position_gain: 0.98, offset: 0.1, friction: 0.2 },
];

const SESSION: &str = r#"
robot = "robot.toml"
[gravity]
magnitude_m_per_s2 = 9.80230
hemisphere = [0, 0, -1]
[readings]
position = { columns = ["shoulder.position", "elbow.position"], unit = "rad" }
torque = { columns = ["shoulder.effort", "elbow.effort"], unit = "N·m" }
sweeps = {}
[[joint]]
name = "shoulder"
torque_gain = { fixed = 1, unit = "N·m/(N·m)" }
torque_sign = "normal"
MODELS
[[joint]]
name = "elbow"
torque_sign = "normal"
MODELS
[[poses]]
file = "sweeps.csv"
"#;

struct Recorder {
    session: Session,
    text: String,
    samples: u32,
    at: [f64; 2],
    direction: [f64; 2],
    /// Of the position sensors, rad; 0 where they are exact.
    step: f64,
    random: Pcg64,
}

impl Recorder {
    fn row(&mut self) {
        let inertia: Vec<f64> = self
            .session
            .robot
            .chain
            .links()
            .iter()
            .flat_map(|link| {
                let inertia = link.inertia.unwrap();
                [&[inertia.mass][..], &inertia.first_moment].concat()
            })
            .collect();
        let mut torque = [0.0; 2];
        self.session.robot.chain.gravity_torque(&self.at, GRAVITY, &inertia, &mut torque);
        let rounded =
            |position: f64| if self.step > 0.0 { (position / self.step).round() * self.step } else { position };
        let positions: Vec<f64> =
            TRUTH.iter().zip(self.at).map(|(joint, at)| rounded((at - joint.offset) / joint.position_gain)).collect();
        let readings: Vec<f64> = (0..2)
            .map(|j| {
                let noise: f64 = self.random.sample(StandardNormal);
                TRUTH[j].gain * torque[j] + TRUTH[j].bias + TRUTH[j].friction * self.direction[j] + NOISE * noise
            })
            .collect();
        let time = f64::from(self.samples) / RATE;
        self.text += &format!("{time},{},{},{},{}\n", positions[0], positions[1], readings[0], readings[1]);
        self.samples += 1;
    }

    fn go(&mut self, joint: usize, to: f64, speed: f64) {
        let way = (to - self.at[joint]).signum();
        self.direction[joint] = way;
        while way * (to - self.at[joint]) > 0.0 {
            self.at[joint] += way * speed / RATE;
            self.row();
        }
    }

    /// A joint sweeps to and fro while the other stands at some places, to which it goes fast.
    fn sweeps(&mut self, joint: usize, places: &[f64]) {
        for place in places {
            self.go(joint, -1.2, 2.0);
            self.go(1 - joint, *place, 2.0);
            self.go(joint, 1.2, 0.1);
            self.go(joint, -1.2, 0.1);
        }
    }
}

/// A recorder at the start of its recording, and the files that a session of it needs.
fn recorder(folder: &Path, seed: u64, session: &str) -> Recorder {
    fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
    fs::write(folder.join("session.toml"), session).unwrap();
    let text = "time_s,shoulder.position,elbow.position,shoulder.effort,elbow.effort\n".to_owned();
    let robot = read_robot(&folder.join("robot.toml")).unwrap();
    let gravity = gravcal_robot_model::session::GravityPrior { magnitude: 9.8, magnitude_std: None, hemisphere: None };
    let session = Session::new(robot, gravity, Vec::new());
    let random = Pcg64::seed_from_u64(seed);
    Recorder { session, text, samples: 0, at: [0.0; 2], direction: [0.0; 2], step: 0.0, random }
}

fn estimated(folder: &Path, seed: u64, models: &str) -> (Session, EstimatorResult) {
    let mut recorder = recorder(folder, seed, &SESSION.replace("MODELS", models));
    recorder.sweeps(0, &[-1.1, -0.3, 0.6, 1.3]);
    recorder.sweeps(1, &[-0.9, 0.2, 1.1]);
    result_of(folder, &recorder)
}

fn result_of(folder: &Path, recorder: &Recorder) -> (Session, EstimatorResult) {
    fs::write(folder.join("sweeps.csv"), &recorder.text).unwrap();
    let session = read_session(&folder.join("session.toml")).unwrap();
    let solver = LevenbergMarquardt::default();
    let result = estimate_jointly(&session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap();
    (session, result)
}

/// The session of slow sweeps, `unit` and what stands beside it being said of its torques.
fn recorded(folder: &Path, unit: &str) -> Session {
    let (session, _) = estimated(folder, 1, "");
    let file = folder.join("session.toml");
    let text = fs::read_to_string(&file).unwrap();
    let torque = "torque = { columns = [\"shoulder.effort\", \"elbow.effort\"], unit = \"N·m\" }";
    assert!(text.contains(torque) && !session.poses.is_empty());
    fs::write(&file, text.replace(torque, &torque.replace("unit = \"N·m\"", unit))).unwrap();
    read_session(&file).unwrap()
}

fn truth(name: &str) -> f64 {
    let (joint, quantity) = name.split_once('.').unwrap();
    let joint = &TRUTH[usize::from(joint == "elbow")];
    match quantity {
        "torque_gain" => joint.gain,
        "torque_bias" => joint.bias,
        "position_gain" => joint.position_gain,
        "position_offset" => joint.offset,
        "coulomb_friction" => joint.friction,
        other => panic!("{other}"),
    }
}

/// Errors in standard deviations of all that is determined, over some recordings, by name.
fn errors(models: &str, determined: &[&str]) -> f64 {
    let mut squares = Vec::new();
    for seed in 0..8 {
        let folder = tempfile::tempdir().unwrap();
        let (session, result) = estimated(folder.path(), seed, models);
        let notes = session.searched[0].notes(&session.readings);
        assert_eq!(session.searched[0].found(), 7, "{notes:?}");
        for name in determined {
            let found = result.parameters.iter().find(|parameter| parameter.name == *name).unwrap();
            let (Some(value), Some(std)) = (found.value, found.std) else { panic!("{name} {:?}", result.undetermined) };
            squares.push(((value - truth(name)) / std).powi(2));
        }
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

const AFFINE: [&str; 5] =
    ["shoulder.torque_bias", "shoulder.position_gain", "elbow.torque_gain", "elbow.torque_bias", "elbow.position_gain"];

#[test]
fn friction_cancels_and_errors_are_as_they_say() {
    let rms = errors("", &AFFINE);
    assert!((0.7..1.35).contains(&rms), "{rms}");
}

#[test]
fn friction_is_estimated_where_the_session_asks_for_it() {
    let all = [&AFFINE[..], &["shoulder.coulomb_friction", "elbow.coulomb_friction"]].concat();
    let rms = errors("sensor_models = [{ kind = \"coulomb-friction\" }]", &all);
    assert!((0.7..1.35).contains(&rms), "{rms}");
}

/// Of sensors with 10 bits a turn: each joint that stands is up to half a step elsewhere than it reads, all through a sweep.
#[test]
fn what_rounding_leaves_is_an_unknown_of_each_sweep() {
    let step = std::f64::consts::TAU / 1024.0;
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder { step, ..recorder(folder.path(), 0, &SESSION.replace("MODELS", "")) };
    recorder.sweeps(0, &[-1.1, -0.7, -0.3, 0.1, 0.6, 1.3]);
    recorder.sweeps(1, &[-0.9, -0.4, 0.2, 0.7, 1.1]);
    let (session, result) = result_of(folder.path(), &recorder);
    for (std, joint) in session.deflection.rounding_std.iter().zip(&session.joints) {
        let gain = joint.of(SensorParameter::PositionGain).nominal;
        // Steps are counted in classes of an eighth of a power of two.
        assert!((std / (gain * step / 12f64.sqrt()) - 1.0).abs() < 0.07, "{std}");
    }
    assert!(result.notes.iter().any(|note| note.starts_with("Position readings step by up to 0.3")));
    assert!(result.deflections.is_empty(), "nobody asked for them");
    let readings = select(&session, Signals::All);
    let built = build_problem(&session, &readings, &State::nominal(&session)).unwrap();
    let unknowns = built.problem.block_ids().filter(|id| built.problem.block(*id).name.starts_with("deflection["));
    assert_eq!(unknowns.count(), 11, "one of each sweep");
}

#[test]
fn what_is_found_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let (session, result) = estimated(folder.path(), 1, "");
    let notes = session.searched[0].notes(&session.readings);
    assert!(notes[0].starts_with("sweeps.csv: 7 slow sweeps found"), "{notes:?}");
    assert!(notes[1].contains("`shoulder.position` from -"), "{notes:?}");
    assert!(notes[1].contains("in 1 stroke up and 1 down: ") && notes[1].contains("(friction) 0.5"), "{notes:?}");
    let sticking = |note: &String| note.starts_with("Joints with friction (shoulder 0.50 N·m, elbow 0.20 N·m): ");
    assert!(result.notes.iter().any(sticking), "{:?}", result.notes);
    assert!(notes.iter().all(|note| result.notes.contains(note)), "{:?}", result.notes);
    // Both ways are poses of their own where the session asks for friction.
    let (apart, of_apart) = estimated(folder.path(), 1, "sensor_models = [{ kind = \"coulomb-friction\" }]");
    assert_eq!(apart.poses.len(), 2 * session.poses.len());
    for result in [&result, &of_apart] {
        let uneven = result.taken_as_exact.iter().find(|exact| exact.wrong.contains("friction of each joint"));
        assert!(uneven.is_some_and(|uneven| uneven.off_in_std > 2.0), "{:?}", result.taken_as_exact);
    }
}

/// Of a joint that stands while the other sweeps what is left of its friction is unknown, where each joint sweeps in a recording of its own, too,
/// in which nothing is seen of the other's.
#[test]
fn friction_that_one_recording_shows_is_an_unknown_in_all() {
    let folder = tempfile::tempdir().unwrap();
    let (together, _) = estimated(folder.path(), 1, "");
    let [shoulder, elbow] = [0, 1]
        .map(|joint| together.searched[0].sweeps.as_ref().unwrap().found.iter().filter(move |s| s.joint == joint));
    let first_of_elbow = elbow.map(|sweep| sweep.interval[0]).fold(f64::INFINITY, f64::min);
    assert!(shoulder.map(|sweep| sweep.interval[1]).all(|last| last < first_of_elbow));
    let part = |bound: &str| format!("file = \"sweeps.csv\"\n{bound} = {first_of_elbow}\n");
    let apart = format!("{}[[poses]]\n{}", part("until_s"), part("from_s"));
    let text = SESSION.replace("MODELS", "").replace("file = \"sweeps.csv\"\n", &apart);
    fs::write(folder.path().join("session.toml"), text).unwrap();
    let apart = read_session(&folder.path().join("session.toml")).unwrap();
    assert_eq!(apart.searched.len(), 2);
    for session in [together, apart] {
        assert!(session.static_friction.iter().zip(&TRUTH).all(|(found, joint)| (found - joint.friction).abs() < 0.02));
        let readings = select(&session, Signals::All);
        let built = build_problem(&session, &readings, &State::nominal(&session)).unwrap();
        let unknowns = built.variables.static_friction.unwrap();
        assert_eq!(unknowns.sweeps.len(), 7);
        assert!(unknowns.sweeps.iter().all(|(poses, unknown)| {
            let swept = usize::from(session.poses[poses[0]].sweep_label.as_ref().unwrap().starts_with("elbow"));
            unknown.joints == [1 - swept]
                && (unknown.std[0] / TRUTH[1 - swept].friction * 3f64.sqrt() - 1.0).abs() < 0.05
        }));
    }
}

/// A session that is drawn up from the recording finds the same sweeps.
#[test]
fn a_draft_has_the_sweeps_where_nothing_stands() {
    let folder = tempfile::tempdir().unwrap();
    let (session, _) = estimated(folder.path(), 2, "");
    let recording = folder.path().join("sweeps.csv");
    let inspection = inspect(&recording, &|_| {}).unwrap();
    let robot = DraftRobot::read(&folder.path().join("robot.toml"), None, &[], Default::default()).unwrap();
    let draft = Draft::new(&recording, &inspection, Some(&robot)).unwrap();
    let text = draft.text(&draft.search(&|_| {}).unwrap(), folder.path());
    assert!(text.contains("Sweeps found in the recording: 7.\n[readings.sweeps]"), "{text}");
    fs::write(folder.path().join("draft.toml"), text).unwrap();
    assert_eq!(read_session(&folder.path().join("draft.toml")).unwrap().poses, session.poses);
}

/// Means from recordings have the noise that was measured in them, and there errors beyond it are estimated by themselves.
#[test]
fn means_of_recordings_have_such_errors_unless_it_is_said_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let session = |unit: &str| recorded(folder.path(), unit).unexplained_errors();
    assert_eq!(session("unit = \"N·m\""), [UnexplainedError::Estimated; 2]);
    assert_eq!(session("unit = \"N·m\", unexplained_std = \"none\""), [UnexplainedError::Absent; 2]);
}
