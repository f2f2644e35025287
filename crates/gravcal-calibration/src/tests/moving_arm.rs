//! An arm in motion of which the truth is known, from the recording to the estimate: errors are as large as their standard deviations say.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use gravcal_dynamics::{BodyInertia, Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_identification::SolveEnvironment;
use gravcal_recording::MotionWindow;
use gravcal_robot_model::session::{Pose, Session};
use gravcal_robot_model::sweeps::find_sweeps;
use gravcal_session::{read_robot, read_session};
use gravcal_solvers::LevenbergMarquardt;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use crate::check::check;
use crate::joint::{Signals, estimate_jointly};
use crate::result::{EstimatorResult, HeldOut, ParameterResult, ResidualTest, ResidualTestKind, SmallerModelKind};

const GRAVITY: [f64; 3] = [0.6, -1.1, -9.73];
const RATE: f64 = 200.0;
const DURATION: f64 = 18.0;
/// Of an arm that stops on its way: how long it moves, and then stands, s.
const MOVES: f64 = 3.5;
const STANDS: f64 = 1.5;
/// Of a sample, N·m and rad.
const NOISE: f64 = 0.03;
const POSITION_NOISE: f64 = 1e-5;
/// Mass of the load, kg, where it hangs, m, and its tensor about its centre, kg·m².
const LOAD: f64 = 1.5;
const PLACE: [f64; 3] = [0.12, -0.05, 0.09];
const LOAD_TENSOR: [f64; 6] = [0.004, 0.0, 0.005, 0.0, 0.0, 0.003];

pub(super) const ROBOT: &str = r#"
name = "three-joints"
convention = "standard-dh"
[[joint]]
name = "turn"
a_m = 0.05
alpha_deg = 90
d_m = 0.3
link = "trunk"
mass_kg = 3
center_of_mass_m = [0.02, -0.1, 0.03]
[[joint]]
name = "shoulder"
a_m = 0.35
alpha_deg = 20
d_m = 0.1
link = "upper-arm"
mass_kg = 2.5
center_of_mass_m = [-0.15, 0.02, 0.04]
[[joint]]
name = "elbow"
a_m = 0.1
alpha_deg = 90
d_m = 0.05
link = "forearm"
mass_kg = 1.2
center_of_mass_m = [0.05, 0.03, 0.12]
"#;

const SESSION: &str = r#"
robot = "robot.toml"
[gravity]
magnitude_m_per_s2 = 9.810351
hemisphere = [0, 0, -1]
[inertia]
links = "unknown"
[readings]
time = { column = "time_s", unit = "s" }
position = { columns = ["q1", "q2", "q3"], unit = "rad" }
torque = { columns = ["tau1", "tau2", "tau3"], unit = "N·m" }
motion = {}
[joints]
torque_sign = "normal"
sensor_models = [{ kind = "coulomb-friction" }, { kind = "viscous-friction" }]
[[load]]
name = "plate"
mass_kg = 1.5
link = "forearm"
[[poses]]
file = "bare.csv"
[[poses]]
file = "loaded.csv"
load = "plate"
"#;

/// Torque gain, bias, position gain and offset, Coulomb and viscous friction of each joint.
const TRUTH: [[f64; 6]; 3] =
    [[0.97, 0.4, 1.004, 0.0, 0.6, 0.3], [1.05, -0.7, 0.995, 0.03, 0.5, 0.4], [1.02, 0.2, 1.006, -0.02, 0.25, 0.1]];

/// Rotor inertia of each joint where motors are felt, kg·m².
const ROTORS: [f64; 3] = [0.5, 0.4, 0.15];

/// Ten numbers of each link, the load's added.
fn bodies(chain: &Chain, loaded: bool) -> Vec<f64> {
    let tensors = [
        [0.03, 0.002, 0.02, -0.001, 0.003, 0.035],
        [0.02, 0.001, 0.06, 0.002, 0.0, 0.07],
        [0.012, 0.0, 0.014, 0.001, 0.0, 0.006],
    ];
    let link = |(link, tensor): (&gravcal_dynamics::Link, [f64; 6])| {
        let own = link.inertia.unwrap();
        let center = own.first_moment.map(|h| h / own.mass);
        BodyInertia::about_center(own.mass, center, tensor).parameters()
    };
    let mut all: Vec<f64> = chain.links().iter().zip(tensors).flat_map(link).collect();
    if loaded {
        let load = BodyInertia::about_center(LOAD, PLACE, LOAD_TENSOR).parameters();
        all[20..].iter_mut().zip(load).for_each(|(sum, of_load)| *sum += of_load);
    }
    all
}

/// Coordinate, velocity and acceleration of a joint.
fn motion(joint: usize, t: f64, seed: u64) -> [f64; 3] {
    let mut random = Pcg64::seed_from_u64(seed * 10 + joint as u64);
    let mut sum = [0.0, 0.0, 0.0];
    for harmonic in 1..=5 {
        let (w, phase): (f64, f64) = (TAU * f64::from(harmonic) / 12.0, random.random_range(0.0..TAU));
        let size: f64 = random.random_range(0.3..0.9) / f64::from(harmonic).sqrt();
        let angle = w * t + phase;
        sum[0] += size * angle.sin();
        sum[1] += size * w * angle.cos();
        sum[2] -= size * w * w * angle.sin();
    }
    sum
}

/// How an arm is recorded.
#[derive(Clone, Copy, Debug, Default)]
struct Recording {
    seed: u64,
    /// Whether the arm stops on its way.
    stops: bool,
    /// By how much torques are recorded late, s.
    lag: f64,
    /// Cut-off of a filter that torques pass, Hz.
    filter: Option<f64>,
    /// Rotor inertia of each joint, kg·m².
    rotors: [f64; 3],
    /// Share of its torque by which the friction of the shoulder grows.
    load_friction: f64,
    /// By how much the friction of the elbow is more where it hardly moves, N·m, and over which speed that falls to a third, rad/s.
    more_at_first: Option<[f64; 2]>,
    /// Share by which friction of the shoulder falls over each recording.
    warms: f64,
    /// Whether nothing is rounded by noise.
    exact: bool,
    /// By which share the clock runs fast.
    fast: f64,
}

/// How far along its way an arm is that stops, the speed along it and the acceleration, s, 1, 1/s.
fn stopping(t: f64) -> [f64; 3] {
    let (number, since) = ((t / (MOVES + STANDS)).floor(), t.rem_euclid(MOVES + STANDS));
    let u = f64::min(since / MOVES, 1.0);
    let moved = u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
    let (speed, rate) = (30.0 * (u * (1.0 - u)).powi(2), 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u));
    [MOVES * (number + moved), speed, rate / MOVES]
}

impl Recording {
    /// Coordinate, velocity and acceleration of a joint, and the sign of its friction.
    fn at(&self, joint: usize, t: f64, seed: u64) -> [f64; 4] {
        let [way, speed, rate] = if self.stops { stopping(t) } else { [t, 1.0, 0.0] };
        let [q, v, a] = motion(joint, way, seed);
        [q, v * speed, a * speed * speed + v * rate, v.signum()]
    }
}

fn record(path: &Path, chain: &Chain, loaded: bool, recording: Recording) {
    let Recording { seed, stops, lag, filter, rotors, load_friction, more_at_first, warms, exact, fast } = recording;
    let mut random = Pcg64::seed_from_u64(1000 * seed + u64::from(loaded));
    let mut rows: Vec<[f64; 7]> = Vec::new();
    let (parameters, mut dynamics) = (bodies(chain, loaded), InverseDynamics::new(chain));
    let duration = if stops { 2.5 * DURATION } else { DURATION };
    for sample in 0..(RATE * duration) as usize {
        let t = sample as f64 / RATE;
        let at = |t: f64| [0, 1, 2].map(|joint| recording.at(joint, t, seed + 100 * u64::from(loaded)));
        let read = at(t).map(|[q, ..]| q);
        let states = at(t - lag);
        let part = |part: usize| states.map(|state| state[part]);
        let [coordinates, velocities, accelerations] = [part(0), part(1), part(2)];
        let arm = JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
        let inertia = DynamicParameters { links: &parameters, rotor_inertia: &rotors };
        chain.inverse_dynamics(Single, arm, GRAVITY, inertia, &mut dynamics);
        let share = if exact { 0.0 } else { 1.0 };
        let mut noise = |std: f64| -> f64 { share * std * random.sample::<f64, _>(StandardNormal) };
        let positions = [0, 1, 2].map(|j| (read[j] - TRUTH[j][3]) / TRUTH[j][2] + noise(POSITION_NOISE));
        let torques = [0, 1, 2].map(|j| {
            let [gain, bias, position_gain, _, coulomb, viscous] = TRUTH[j];
            let speed = velocities[j] / position_gain;
            let of_load = if j == 1 { load_friction * dynamics.torque[j].abs() } else { 0.0 };
            let at_first =
                more_at_first.filter(|_| j == 2).map_or(0.0, |[more, over]| more * (-speed.abs() / over).exp());
            let left = if j == 1 { 1.0 - warms * t / duration } else { 1.0 };
            let [coulomb, viscous] = [left * coulomb, left * viscous];
            gain * dynamics.torque[j]
                + bias
                + (coulomb + of_load + at_first) * states[j][3]
                + viscous * speed
                + noise(NOISE)
        });
        let ([q1, q2, q3], [tau1, tau2, tau3]) = (positions, torques);
        rows.push([(1.0 + fast) * t, q1, q2, q3, tau1, tau2, tau3]);
    }
    if let Some(cut_off) = filter {
        (4..7).for_each(|column| smooth(&mut rows, column, cut_off));
    }
    let line = |row: &[f64; 7]| row.map(|cell| format!("{cell:.9}")).join(",") + "\n";
    fs::write(path, "time_s,q1,q2,q3,tau1,tau2,tau3\n".to_owned() + &rows.iter().map(line).collect::<String>())
        .unwrap();
}

/// A filter of first order twice forward and twice backward, which passes half of the power at its cut-off: `(1 + (f/f₀)²)⁴ = 2`.
fn smooth(rows: &mut [[f64; 7]], column: usize, cut_off: f64) {
    let corner = cut_off / (2f64.powf(0.25) - 1.0).sqrt();
    let keeps = (-TAU * corner / RATE).exp();
    for _ in 0..4 {
        let mut last = rows[0][column];
        for row in rows.iter_mut() {
            last = keeps * last + (1.0 - keeps) * row[column];
            row[column] = last;
        }
        rows.reverse();
    }
}

fn session(folder: &Path, seed: u64, text: &str) -> Session {
    recorded(folder, Recording { seed, ..Recording::default() }, text)
}

fn recorded(folder: &Path, recording: Recording, text: &str) -> Session {
    fs::write(folder.join("robot.toml"), ROBOT).unwrap();
    fs::write(folder.join("session.toml"), text).unwrap();
    let chain = read_robot(&folder.join("robot.toml")).unwrap().chain;
    record(&folder.join("bare.csv"), &chain, false, recording);
    record(&folder.join("loaded.csv"), &chain, true, recording);
    read_session(&folder.join("session.toml")).unwrap()
}

fn estimated(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_| {})).unwrap()
}

fn truth(name: &str) -> f64 {
    let (joint, quantity) = name.split_once('.').unwrap();
    let joint = ["turn", "shoulder", "elbow"].iter().position(|own| *own == joint).unwrap();
    let quantities =
        ["torque_gain", "torque_bias", "position_gain", "position_offset", "coulomb_friction", "viscous_friction"];
    if quantity == "rotor_inertia" {
        return ROTORS[joint];
    }
    TRUTH[joint][quantities.iter().position(|own| *own == quantity).unwrap()]
}

/// What is estimated, in its standard deviations from the truth: gains with scale (the load's mass is known), biases, position gains, offsets
/// between the first joint and the last, friction, gravity.
fn errors(result: &EstimatorResult) -> Vec<f64> {
    let of_parameter = |parameter: &ParameterResult| match (parameter.name.as_str(), parameter.value, parameter.std) {
        ("turn.position_offset" | "elbow.position_offset", ..) => None,
        _ if parameter.held.is_some() => None,
        (name, Some(value), Some(std)) => Some((value - truth(name)) / std),
        _ => panic!("{parameter:?}"),
    };
    let gravity = result.gravity.as_ref().unwrap();
    let axes = [0, 1].map(|axis| (gravity.vector_m_per_s2[axis] - GRAVITY[axis]) / gravity.std_m_per_s2[axis]);
    result.parameters.iter().filter_map(of_parameter).chain(axes).collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn all_parameters_are_found_within_their_intervals() {
    let mut all = Vec::new();
    for seed in 1..=3 {
        let folder = tempfile::tempdir().unwrap();
        all.extend(errors(&estimated(&session(folder.path(), seed, SESSION))));
    }
    assert!((0.6..1.5).contains(&rms(&all)), "{} {all:?}", rms(&all));
}

/// What gravity, inertia and friction make the sensors read is told apart.
#[test]
fn predictions_are_made_of_gravity_inertia_and_friction() {
    let folder = tempfile::tempdir().unwrap();
    let session = session(folder.path(), 1, SESSION);
    let (result, chain) = (estimated(&session), &session.robot.chain);
    let mut largest = [[0.0_f64; 2]; 3];
    for reported in &result.fit.as_ref().unwrap().residuals {
        let (pose, joint) = (&session.poses[reported.id.pose], reported.id.channel);
        let [gain, bias, position_gain, _, coulomb, viscous] = TRUTH[joint];
        let parts = reported.torque.unwrap();
        // Gravity by the true arm where the window stands in the mean: half a per cent is the curvature within it.
        let coordinates: Vec<f64> = (0..3).map(|j| TRUTH[j][2] * pose.position[j] + TRUTH[j][3]).collect();
        let moments: Vec<f64> =
            bodies(chain, pose.load.is_some()).chunks(10).flat_map(|body| body[..4].to_vec()).collect();
        let mut torque = vec![0.0; 3];
        chain.gravity_torque(&coordinates, GRAVITY, &moments, &mut torque);
        let reading = session.reading(reported.id).unwrap().value;
        let friction = reading + reported.residual - parts.gravity - parts.inertia - parts.bias;
        let (speed, direction) = (pose.conditions.velocity[joint], pose.conditions.direction[joint]);
        let expected = coulomb * direction + viscous * speed;
        assert!((parts.bias - bias).abs() < 0.05, "{} {bias} {position_gain}", parts.bias);
        largest[joint][0] = largest[joint][0].max((parts.gravity - gain * torque[joint]).abs());
        largest[joint][1] = largest[joint][1].max((friction - expected).abs());
    }
    for (joint, [of_gravity, of_friction]) in largest.into_iter().enumerate() {
        assert!(of_gravity < 0.5 && of_friction < 0.05, "{joint}: {of_gravity} {of_friction}");
    }
}

/// An arm that stops on its way, by its standstills and by windows of what is between them: no row is in both, and the truth is found.
#[test]
fn standstills_and_windows_of_one_recording_go_together() {
    let mut all = Vec::new();
    for seed in 1..=2 {
        let folder = tempfile::tempdir().unwrap();
        let recording = Recording { seed, stops: true, ..Recording::default() };
        let session = recorded(folder.path(), recording, &SESSION.replace("motion = {}", "motion = {}\nstill = {}"));
        for searched in &session.searched {
            let (stood, windows) = (searched.standstills.as_ref().unwrap(), searched.windows.as_ref().unwrap());
            assert!((7..=9).contains(&stood.found.len()), "{}", stood.found.len());
            let beside = |window: &&MotionWindow| {
                stood.found.iter().all(|s| window.interval[1] <= s.interval[0] || s.interval[1] <= window.interval[0])
            };
            let counted = windows.found.iter().filter(beside).count();
            let poses: Vec<&Pose> = session.poses.iter().filter(|pose| pose.table == searched.table).collect();
            assert_eq!(poses.len(), stood.found.len() + counted);
            assert_eq!(poses.iter().filter(|pose| pose.course.is_none()).count(), stood.found.len());
            assert!(counted > 500 && windows.found.len() > counted + 100, "{counted} of {}", windows.found.len());
            assert!(poses.is_sorted_by_key(|pose| (pose.conditions.time.unwrap() * 1e6) as i64), "in order of time");
        }
        all.extend(errors(&estimated(&session)));
    }
    assert!((0.6..1.6).contains(&rms(&all)), "{} {all:?}", rms(&all));
}

/// Where joints rest their torques do not count, so that of two columns that were exchanged one counts where the other does not.
#[test]
fn exchanged_torque_columns_of_an_arm_that_stops_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording { seed: 1, stops: true, ..Recording::default() };
    let text = SESSION.replace(r#"["tau1", "tau2", "tau3"]"#, r#"["tau1", "tau3", "tau2"]"#);
    let session = recorded(folder.path(), recording, &text);
    assert!(session.poses.iter().any(|pose| pose.torque[1].is_some() != pose.torque[2].is_some()));
    let result = estimated(&session);
    assert_eq!(result.termination, "swapped torque columns: shoulder and elbow", "{:?}", result.notes);
}

#[test]
fn slow_sweeps_beside_windows_are_refused_as_they_would_count_twice() {
    let folder = tempfile::tempdir().unwrap();
    session(folder.path(), 1, SESSION);
    fs::write(folder.path().join("session.toml"), SESSION.replace("motion = {}", "motion = {}\nsweeps = {}")).unwrap();
    let error = read_session(&folder.path().join("session.toml")).unwrap_err().to_string();
    assert!(
        error.contains("readings.motion: with readings.sweeps every row of a slow sweep would count twice"),
        "{error}"
    );
    for (key, expected) in [
        ("torque_lag_s = 3", "readings.motion.torque_lag_s: 3 s is no lag of a recorder"),
        ("recorded_filter_hz = 0", "readings.motion.recorded_filter_hz: "),
    ] {
        let text = SESSION.replace("motion = {}", &format!("motion = {{ {key} }}"));
        fs::write(folder.path().join("session.toml"), text).unwrap();
        let error = read_session(&folder.path().join("session.toml")).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Torques that are recorded 50 ms late: told with the size and what to say; said, the truth is found.
#[test]
fn torques_that_come_late_are_reported_and_allowed_for_where_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let late = Recording { seed: 1, lag: 0.05, ..Recording::default() };
    let result = estimated(&recorded(folder.path(), late, SESSION));
    let lags = result.residual_tests.iter().filter(|test| test.named && test.kind == ResidualTestKind::TorqueLag);
    let lags: Vec<f64> = lags.map(|test| test.size).collect();
    assert!(!lags.is_empty() && lags.iter().all(|lag| (0.03..0.07).contains(lag)), "{lags:?} {:?}", result.notes);
    let reported = result
        .notes
        .iter()
        .any(|remark| remark.contains("s later than the positions") && remark.contains("torque_lag_s = 0.0"));
    assert!(reported, "{:?}", result.notes);
    let said = SESSION.replace("motion = {}", "motion = { torque_lag_s = 0.05 }");
    let result = estimated(&recorded(folder.path(), late, &said));
    assert!(result.residual_tests.iter().all(|test| !test.named || test.kind != ResidualTestKind::TorqueLag));
    let all = errors(&result);
    assert!(rms(&all) < 1.8, "{} {all:?}", rms(&all));
}

/// A recorder that filters all torques alike is found by what all joints show together, by its cut-off; said, nothing of it is left.
#[test]
fn a_filter_of_all_torques_is_found_by_its_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    let filtered = Recording { seed: 1, filter: Some(2.0), ..Recording::default() };
    let result = estimated(&recorded(folder.path(), filtered, SESSION));
    let of_filter = |test: &&ResidualTest| test.named && test.kind == ResidualTestKind::TorqueFilter;
    let first = result.residual_tests.iter().find(of_filter).unwrap();
    assert!(first.channel == "all joints" && first.spoils_intervals, "{:?}", result.residual_tests);
    let note = result.notes.iter().find(|note| note.contains("The torques of all joints are smoother")).unwrap();
    let said = note.split("say recorded_filter_hz = ").nth(1).unwrap().split(' ').next().unwrap();
    assert!((1.7..2.3).contains(&said.parse::<f64>().unwrap()), "{note}");
    // A filter that keeps less is told with that which is said already.
    let saying = |cut_off: &str| {
        let text = SESSION.replace("motion = {}", &format!("motion = {{ recorded_filter_hz = {cut_off} }}"));
        estimated(&recorded(folder.path(), filtered, &text))
    };
    let again = saying("3.0").notes.into_iter().find(|note| note.contains("all joints are smoother still")).unwrap();
    let said = again.split("say recorded_filter_hz = ").nth(1).unwrap().split(' ').next().unwrap();
    assert!((1.7..2.1).contains(&said.parse::<f64>().unwrap()), "{again}");
    let result = saying("2.0");
    assert!(!result.residual_tests.iter().any(|test| of_filter(&test)), "{:?}", result.notes);
}

#[test]
fn friction_that_grows_with_the_torque_is_named_with_its_share() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording { seed: 1, load_friction: 0.04, ..Recording::default() };
    let result = estimated(&recorded(folder.path(), recording, SESSION));
    let named = |test: &&ResidualTest| test.named && test.kind == ResidualTestKind::LoadFriction;
    let first = result.residual_tests.iter().find(named).unwrap_or_else(|| panic!("{:?}", result.notes));
    // Of the reading, whose gain is 1.05.
    assert!(first.channel == "shoulder" && (first.size / (4.0 / 1.05) - 1.0).abs() < 0.3, "{first:?}");
    assert!(first.spoils_intervals && first.unit == "%", "{first:?}");
}

#[test]
fn friction_that_falls_as_a_joint_warms_up_is_named_with_its_size() {
    let folder = tempfile::tempdir().unwrap();
    let result =
        estimated(&recorded(folder.path(), Recording { seed: 1, warms: 0.2, ..Recording::default() }, SESSION));
    let named = |test: &&ResidualTest| test.named && test.kind == ResidualTestKind::FrictionTrend;
    let first = result.residual_tests.iter().find(named).unwrap_or_else(|| panic!("{:?}", result.notes));
    let expected = -20.0 / 0.9 / DURATION;
    assert!(first.channel == "shoulder" && (first.size / expected - 1.0).abs() < 0.3, "{first:?} {expected}");
    assert!(first.spoils_intervals && first.unit == "%/s", "{first:?}");
    assert!(
        result.notes.iter().any(|note| note.contains("friction of shoulder changes with time")),
        "{:?}",
        result.notes
    );
    assert!(errors(&result).iter().all(|error| error.abs() < 4.0), "{:?}", errors(&result));
}

#[test]
fn a_clock_that_runs_fast_or_slow_is_named_with_its_rate() {
    for fast in [0.02, -0.02] {
        let folder = tempfile::tempdir().unwrap();
        let recording = Recording { seed: 1, fast, ..Recording::default() };
        let result = estimated(&recorded(folder.path(), recording, SESSION));
        let named = |test: &&ResidualTest| test.named && test.kind == ResidualTestKind::ClockRate;
        let first = result.residual_tests.iter().find(named).unwrap_or_else(|| panic!("{:?}", result.notes));
        assert!((first.size / (100.0 * fast) - 1.0).abs() < 0.3 && first.unit == "%", "{first:?}");
        assert!(first.spoils_intervals, "{first:?}");
        let word = if fast > 0.0 { "ran fast" } else { "ran slow" };
        assert!(result.notes.iter().any(|note| note.contains(word)), "{:?}", result.notes);
    }
}

/// What curves through positions leave is no error of a model.
#[test]
fn a_simulation_without_noise_is_doubted_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let result =
        estimated(&recorded(folder.path(), Recording { seed: 1, exact: true, ..Recording::default() }, SESSION));
    assert!(!result.residual_tests.iter().any(|test| test.named), "{:?}", result.notes);
    for own in result.parameters.iter().filter(|own| own.name.ends_with("torque_gain")) {
        assert!((own.value.unwrap() / truth(&own.name) - 1.0).abs() < 1e-3, "{own:?}");
    }
    assert!(errors(&result).iter().all(|error| error.abs() < 4.0), "{:?}", errors(&result));
}

/// Stribeck's friction: named, and found where what the note says is typed.
#[test]
fn friction_that_is_no_line_over_the_speed_is_named_with_its_cure() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording { seed: 1, more_at_first: Some([0.15, 0.1]), ..Recording::default() };
    let named = |result: &EstimatorResult| {
        let mut tests = result.residual_tests.iter();
        tests.find(|test| test.named && matches!(test.kind, ResidualTestKind::FrictionCurve { .. })).cloned()
    };
    let result = estimated(&recorded(folder.path(), recording, SESSION));
    let first = named(&result).unwrap_or_else(|| panic!("{:?}", result.notes));
    assert!(first.channel == "elbow" && (first.size / 0.15 - 1.0).abs() < 0.5 && first.unit == "N·m", "{first:?}");
    let note =
        result.notes.iter().find(|note| note.contains("The friction of elbow is no line over its speed")).unwrap();
    let cure = note.split("sensor_models = [").nth(1).unwrap().split("] in its [[joint]]").next().unwrap();
    let own = format!("sensor_models = [{{ kind = \"coulomb-friction\" }}, {{ kind = \"viscous-friction\" }}, {cure}]");
    let text = SESSION.replace("[[load]]", &format!("[[joint]]\nname = \"elbow\"\n{own}\n[[load]]"));
    let mut result = estimated(&recorded(folder.path(), recording, &text));
    assert_eq!(named(&result), None);
    for (name, truth) in [("elbow.extra", 0.15), ("elbow.speed", 0.1)] {
        let place = result.parameters.iter().position(|own| own.name == name).unwrap();
        let found = result.parameters.remove(place);
        let [value, std] = [found.value, found.std].map(Option::unwrap);
        assert!((value - truth).abs() < 3.0 * std && std < 0.2 * truth, "{found:?}");
    }
    let all = errors(&result);
    assert!(rms(&all) < 1.8, "{} {all:?}", rms(&all));
}

/// A description whose joints sit or are tilted otherwise than those of the arm that was recorded: one is named, and intervals hold; so they do where the
/// session says how well lengths or axes are known, and then nothing is in doubt.
#[test]
fn a_joint_in_motion_that_is_not_as_described_is_named_or_an_unknown() {
    let folder = tempfile::tempdir().unwrap();
    let right = session(folder.path(), 1, SESSION);
    let described = |changed: Chain| {
        let mut session = right.clone();
        session.robot.chain = changed;
        session
    };
    let chain = &right.robot.chain;
    let joint = || chain.movers()[2].name.clone();
    let wrong = [
        (
            described(chain.with_joint_aside(2, [0.004, 0.003, -0.004])),
            ResidualTestKind::JointPlacement { joint: joint() },
            [Some(0.004), None],
        ),
        (
            described(chain.with_joint_turned(2, [0.01, 0.0, 0.0])),
            ResidualTestKind::JointTilt { joint: joint() },
            [None, Some(0.005)],
        ),
    ];
    for (session, kind, [length_std, axis_std]) in wrong {
        let result = estimated(&session);
        let named = result.residual_tests.iter().any(|test| test.named && test.kind == kind && test.spoils_intervals);
        assert!(named, "{kind:?}: {:?}", result.notes);
        let unknown = estimated(&Session { length_std, axis_std, ..session });
        let spoilt =
            unknown.residual_tests.iter().filter(|test| test.named && test.spoils_intervals).collect::<Vec<_>>();
        assert!(spoilt.is_empty(), "{kind:?}: {spoilt:?}");
        assert!(unknown.notes.iter().any(|note| note.starts_with("The readings tell how far")), "{:?}", unknown.notes);
        for result in [&result, &unknown] {
            let all = errors(result);
            assert!(all.iter().all(|error| error.abs() < 4.0), "{kind:?}: {all:?}");
        }
    }
    let exact = estimated(&right);
    let spoilt = exact.residual_tests.iter().filter(|test| test.named && test.spoils_intervals).collect::<Vec<_>>();
    assert!(spoilt.is_empty(), "{spoilt:?}");
    assert!(exact.notes.iter().any(|note| note.contains("each joint were 1 mm")), "{:?}", exact.notes);
}

/// Of an arm in motion neither gravity alone nor gravity with friction predicts what the whole dynamics predict.
#[test]
fn smaller_models_predict_worse_what_no_fit_saw() {
    let folder = tempfile::tempdir().unwrap();
    let fit = estimated(&session(folder.path(), 1, SESSION)).fit.unwrap();
    let [gravity, with_friction] = &fit.smaller_models[..] else { panic!("{:?}", fit.smaller_models) };
    assert_eq!([gravity.kind, with_friction.kind], [SmallerModelKind::Gravity, SmallerModelKind::GravityAndFriction]);
    let whole = fit.held_out.as_ref().unwrap();
    assert_eq!((gravity.held_out.poses, with_friction.held_out.readings), (whole.poses, whole.readings));
    let mean = |held_out: &HeldOut| held_out.joints.iter().map(|joint| joint.rms).sum::<f64>() / 3.0;
    let [first, second, last] = [&gravity.held_out, &with_friction.held_out, whole].map(mean);
    assert!(first > 1.2 * second && second > 50.0 * last, "{first} {second} {last}");
}

/// Torques of motors feel the rotors before their gears: unknown, these are found with all else, but for those of the first joints, which are one
/// with their links' inertia; left out, they are named as what the model lacks, with what to say.
#[test]
fn rotor_inertias_are_found_or_named() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording { seed: 4, rotors: ROTORS, ..Recording::default() };
    let text = SESSION.replace("torque_sign = \"normal\"", "torque_sign = \"normal\"\nrotor_inertia = \"unknown\"");
    let mut result = estimated(&recorded(folder.path(), recording, &text));
    let open: Vec<&str> = result.parameters.iter().filter(|p| p.value.is_none()).map(|p| p.name.as_str()).collect();
    assert_eq!(open, ["turn.rotor_inertia", "shoulder.rotor_inertia", "elbow.position_offset"]);
    let rotor = result.parameters.iter().find(|parameter| parameter.name == "elbow.rotor_inertia").unwrap();
    assert!(rotor.unit == "kg·m²" && rotor.std.unwrap() < 0.05, "{rotor:?}");
    let together =
        result.moments.iter().find(|moment| moment.terms.iter().any(|(name, _)| name == "turn.rotor_inertia"));
    assert!(together.unwrap().terms.iter().any(|(name, _)| name.starts_with("trunk.inertia")), "{together:?}");
    result.parameters.retain(|parameter| !parameter.name.ends_with("rotor_inertia") || parameter.value.is_some());
    let all = errors(&result);
    assert!(all.len() == 19 && rms(&all) < 1.6, "{} {all:?}", rms(&all));
    let result = estimated(&recorded(folder.path(), recording, SESSION));
    let named = |test: &&ResidualTest| test.named && test.kind == ResidualTestKind::Acceleration;
    assert!(result.residual_tests.iter().any(|test| named(&test) && test.size > 0.0), "{:?}", result.residual_tests);
    let reported =
        result.notes.iter().any(|note| note.contains("say rotor_inertia = \"unknown\" in the joint's [[joint]]"));
    assert!(reported, "{:?}", result.notes);
}

/// What passes for a rotor of negative inertia is told not to be one.
#[test]
fn rotors_of_negative_inertia_are_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording { seed: 4, rotors: [0.0, 0.0, -0.1], ..Recording::default() };
    let text = SESSION.replace("torque_sign = \"normal\"", "torque_sign = \"normal\"\nrotor_inertia = \"unknown\"");
    let result = estimated(&recorded(folder.path(), recording, &text));
    let reported: Vec<&String> = result.notes.iter().filter(|note| note.contains("inertia below zero")).collect();
    assert!(reported.len() == 1 && reported[0].contains("elbow.rotor_inertia (-0.09"), "{reported:?}");
}

/// Rotors of known inertia are known torques: without any load they tell the gains, with their scale.
#[test]
fn known_rotor_inertias_tell_torque_gains() {
    let folder = tempfile::tempdir().unwrap();
    let own = |(name, inertia): (&str, f64)| {
        format!("[[joint]]\nname = \"{name}\"\nrotor_inertia = {{ fixed = {inertia}, unit = \"kg*m^2\" }}\n")
    };
    let joints: String = ["turn", "shoulder", "elbow"].into_iter().zip(ROTORS).map(own).collect();
    let text = SESSION.replace(LOADED, "").replace("[[load]]", &(joints + "[[load]]"));
    let mut all = Vec::new();
    for seed in [5, 6] {
        let result =
            estimated(&recorded(folder.path(), Recording { seed, rotors: ROTORS, ..Recording::default() }, &text));
        let open: Vec<&str> = result.parameters.iter().filter(|p| p.value.is_none()).map(|p| p.name.as_str()).collect();
        assert_eq!(open, ["elbow.position_offset"]);
        all.extend(errors(&result));
    }
    assert!((0.5..1.6).contains(&rms(&all)), "{} {all:?}", rms(&all));
}

#[test]
fn rotor_inertias_that_mean_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    session(folder.path(), 1, SESSION);
    let refused = |text: &str| {
        fs::write(folder.path().join("session.toml"), text).unwrap();
        read_session(&folder.path().join("session.toml")).unwrap_err().to_string()
    };
    let with = |said: &str| {
        SESSION.replace("torque_sign = \"normal\"", &format!("torque_sign = \"normal\"\nrotor_inertia = {said}"))
    };
    let standing =
        with("\"unknown\"").replace("motion = {}", "still = {}").replace(", { kind = \"viscous-friction\" }", "");
    for (text, expected) in [
        (standing, "joints.rotor_inertia: an arm that stands does not feel the rotor of `turn`: record it in motion"),
        (with("\"unknwon\""), "expected \"unknown\", or a table such as"),
        (with("{ nominal = 0.3, std = 0.1, unit = \"kg\" }"), "joints.rotor_inertia.unit: "),
        (
            with("{ fixed = -0.3, unit = \"kg·m²\" }"),
            "joints.rotor_inertia.fixed: -0.3 kg·m² is no inertia of a rotor: expected zero or more",
        ),
    ] {
        let error = refused(&text);
        assert!(error.contains(expected), "{error}");
    }
}

/// Names of what is not determined.
fn undetermined(folder: &Path, text: &str) -> Vec<String> {
    let result = estimated(&session(folder, 7, text));
    let gravity = result.gravity.is_none().then(|| "gravity".to_owned());
    let parameters = result.parameters.iter().filter(|parameter| parameter.value.is_none());
    gravity.into_iter().chain(parameters.map(|parameter| parameter.name.clone())).collect()
}

const GAINS: [&str; 3] = ["turn.torque_gain", "shoulder.torque_gain", "elbow.torque_gain"];
/// The frame of the last link is a choice, where nothing known hangs on it.
const LAST: &str = "elbow.position_offset";
const LOADED: &str = "[[poses]]\nfile = \"loaded.csv\"\nload = \"plate\"\n";
const BARE: &str = "[[poses]]\nfile = \"bare.csv\"\n";

/// What the rank of the exact Jacobian says (rows of the table in the design of identification in motion); the first joint's offset is the choice of
/// the base's frame, and has a value.
#[test]
fn what_is_determined_is_what_can_be_known() {
    let folder = tempfile::tempdir().unwrap();
    let mut scale = GAINS.map(str::to_owned).to_vec();
    scale.push(LAST.to_owned());
    scale.sort();
    let of = |text: &str| {
        let mut found = undetermined(folder.path(), text);
        found.retain(|name| !name.contains("bias") && !name.contains("friction"));
        found.sort();
        found
    };
    assert_eq!(of(&SESSION.replace(LOADED, "")), scale, "without load");
    assert_eq!(of(&SESSION.replace(BARE, "")), scale, "loaded runs only");
    assert_eq!(of(SESSION), [LAST], "bare and loaded runs");
    let placed = SESSION.replace("link = \"forearm\"", "link = \"forearm\"\nposition_m = [0.12, -0.05, 0.09]");
    assert!(of(&placed).is_empty(), "the load's place known");
}

/// What would be recorded besides stands, and shows no inertia tensor of the load that it carries.
#[test]
fn a_load_that_only_stands_cures_what_a_recording_in_motion_leaves_open() {
    let folder = tempfile::tempdir().unwrap();
    let report = check(&session(folder.path(), 7, &SESSION.replace(LOADED, ""))).unwrap();
    let gains =
        report.undetermined.iter().find(|open| open.undetermined.parameters.contains(&GAINS[0].to_owned())).unwrap();
    let words = gains.cures.iter().map(|cure| cure.addition.as_str()).collect::<Vec<_>>().join("; ");
    assert!(words.contains("with a load of known mass"), "{words}");
}

#[test]
fn joints_that_never_move_are_reported_and_what_the_other_does_is_no_sweep() {
    let folder = tempfile::tempdir().unwrap();
    session(folder.path(), 3, SESSION);
    for file in ["bare.csv", "loaded.csv"] {
        let text = fs::read_to_string(folder.path().join(file)).unwrap();
        let stuck: Vec<String> = text
            .lines()
            .map(|line| {
                let mut cells: Vec<&str> = line.split(',').collect();
                if cells[0] != "time_s" {
                    [cells[1], cells[2]] = ["0.25", "0.5"];
                }
                cells.join(",")
            })
            .collect();
        fs::write(folder.path().join(file), stuck.join("\n")).unwrap();
    }
    let session = read_session(&folder.path().join("session.toml")).unwrap();
    let note = session.unmoved_note().unwrap();
    assert!(
        note.contains("turn (0.250000 rad), shoulder (0.500000 rad)") && note.contains("its position gain stays open"),
        "{note}"
    );
    assert!(find_sweeps(&session).is_empty());
}
