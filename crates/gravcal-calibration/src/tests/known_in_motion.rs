//! What can be known of an arm in motion: a Jacobian of which the estimator has no part says so. Readings come of inverse dynamics alone, their
//! derivatives are differences, and the directions without information are nalgebra's, at values drawn about the nominal ones.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use gravcal_dynamics::{Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_recording::{Conditions, Course, MotionSample, PositionUnit, Reading, TorqueUnit};
use gravcal_robot_model::robot::{NominalSensors, Robot};
use gravcal_robot_model::sensors::{Options, Site, declare_terms};
use gravcal_robot_model::session::{
    GravityPrior, JointPriors, Load, ParameterPrior, Pose, PoseTable, PriorKind, Session,
};
use gravcal_robot_model::{Registry, State};
use gravcal_session::read_robot;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use crate::joint::{Signals, estimate_jointly};
use crate::testing::{shared_data, with_environment};

const MAGNITUDE: f64 = 9.81;
const LOAD: f64 = 1.5;
/// Of a window's reading, N·m.
const NOISE: f64 = 1e-5;
const WINDOWS: usize = 60;
/// Below this share of the largest, a singular value is zero; a parameter has a part in what is not known from this share on.
const ZERO: f64 = 1e-7;
const SHARED: f64 = 1e-4;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Loads {
    None,
    Always,
    AtTimes,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Rotors {
    None,
    Unknown,
    Known,
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
struct Line {
    loads: Loads,
    /// Whether the load's place is known.
    placed: bool,
    rotors: Rotors,
}

/// An arm with its truth; `x` is all of it as one list, in the order of `names`.
struct Arm {
    chain: Chain,
    names: Vec<String>,
    x: Vec<f64>,
    gravity: [f64; 3],
    line: Line,
    /// Table and moments of each window.
    windows: Vec<(usize, Vec<(f64, MotionSample)>)>,
}

const QUANTITIES: [&str; 4] = ["torque_gain", "torque_bias", "position_gain", "position_offset"];

impl Arm {
    fn new(chain: Chain, gravity: [f64; 3], line: Line, seed: u64) -> Arm {
        let mut random = Pcg64::seed_from_u64(seed);
        let (mut names, mut x) = (Vec::new(), Vec::new());
        let mut add = |name: String, value: f64| {
            names.push(name);
            x.push(value);
        };
        let size = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let gravity = gravity.map(|g| MAGNITUDE * g / size);
        ["gravity", "gravity"].iter().for_each(|name| add((*name).to_owned(), 0.0));
        let mut about = |middle: f64, spread: f64| middle + spread * random.random_range(-1.0..1.0);
        for (quantity, (middle, spread)) in QUANTITIES.iter().zip([(1.0, 0.05), (0.0, 0.5), (1.0, 0.01), (0.0, 0.03)]) {
            for (index, joint) in chain.joints().iter().enumerate() {
                let value = if index == 0 && *quantity == "position_offset" { 0.0 } else { about(middle, spread) };
                add(format!("{}.{quantity}", joint.name), value);
            }
        }
        for friction in ["coulomb_friction", "viscous_friction"] {
            chain.joints().iter().for_each(|joint| add(format!("{}.{friction}", joint.name), about(0.3, 0.1)));
        }
        for link in chain.links() {
            let body = [(2.0, 0.5), (0.1, 0.1), (0.1, 0.1), (0.1, 0.1)];
            let tensor = [(0.08, 0.02), (0.0, 0.01), (0.07, 0.02), (0.0, 0.01), (0.0, 0.01), (0.09, 0.02)];
            body.iter().chain(&tensor).for_each(|(middle, spread)| add(link.name.clone(), about(*middle, *spread)));
        }
        for joint in chain.joints() {
            let value = if line.rotors == Rotors::None { 0.0 } else { about(0.4, 0.1) };
            add(format!("{}.rotor_inertia", joint.name), value);
        }
        [0.12, -0.05, 0.09].iter().for_each(|value| add("load".into(), *value));
        [0.02, 0.001, 0.018, -0.001, 0.002, 0.015].iter().for_each(|value| add("load's tensor".into(), *value));
        let windows = (0..WINDOWS).map(|window| {
            let table = usize::from(line.loads == Loads::AtTimes && window % 2 == 1);
            let middle = 0.37 * window as f64;
            let moments = [(0.25, -0.05), (0.5, 0.0), (0.25, 0.05)];
            (table, moments.map(|(weight, shift)| (weight, moment(chain.joint_count(), middle + shift))).to_vec())
        });
        Arm { windows: windows.collect(), chain, names, x, gravity, line }
    }

    fn joints(&self) -> usize {
        self.chain.joint_count()
    }

    /// Whether a load hangs on it in a table.
    fn carries(&self, table: usize) -> bool {
        self.line.loads == Loads::Always || table == 1
    }

    /// Whether a number is unknown to whoever estimates.
    fn is_unknown(&self, place: usize) -> bool {
        let name = &self.names[place];
        let first = format!("{}.position_offset", self.chain.joints()[0].name);
        match name.as_str() {
            "load" => self.line.loads != Loads::None && !self.line.placed,
            "load's tensor" => self.line.loads != Loads::None,
            _ if name.ends_with("rotor_inertia") => self.line.rotors == Rotors::Unknown,
            _ => *name != first,
        }
    }

    /// Gravity turned by two small angles.
    fn turned(&self, by: &[f64]) -> [f64; 3] {
        let [gx, gy, gz] = self.gravity;
        // Perpendicular to it, for whatever does not lie along x.
        let across = nalgebra::Vector3::new(0.0, -gz, gy).normalize();
        let other = nalgebra::Vector3::new(gx, gy, gz).normalize().cross(&across);
        let turned = nalgebra::Vector3::new(gx, gy, gz) + MAGNITUDE * (by[0] * across + by[1] * other);
        (MAGNITUDE * turned.normalize()).into()
    }

    /// Every reading of every window.
    fn readings(&self, x: &[f64]) -> Vec<f64> {
        let n = self.joints();
        let links = self.chain.link_count();
        let gravity = self.turned(&x[..2]);
        let of = |quantity: usize, joint: usize| x[2 + n * quantity + joint];
        let bodies = &x[2 + 6 * n..2 + 6 * n + 10 * links];
        let rotors = &x[2 + 6 * n + 10 * links..2 + 7 * n + 10 * links];
        let load = &x[2 + 7 * n + 10 * links..];
        let mut dynamics = InverseDynamics::new(&self.chain);
        let mut readings = Vec::new();
        for (table, moments) in &self.windows {
            let mut parameters = bodies.to_vec();
            if self.carries(*table) {
                let last = &mut parameters[10 * (links - 1)..];
                last[0] += LOAD;
                (0..3).for_each(|axis| last[1 + axis] += LOAD * load[axis]);
                (0..6).for_each(|entry| last[4 + entry] += load[3 + entry]);
            }
            let mut read = vec![0.0; n];
            for (weight, moment) in moments {
                let state = |list: &[f64], offset: bool| -> Vec<f64> {
                    (0..n).map(|j| of(2, j) * list[j] + if offset { of(3, j) } else { 0.0 }).collect()
                };
                let (coordinates, velocities, accelerations) =
                    (state(&moment.position, true), state(&moment.velocity, false), state(&moment.acceleration, false));
                let motion =
                    JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
                let inertia = DynamicParameters { links: &parameters, rotor_inertia: &vec![0.0; n] };
                self.chain.inverse_dynamics(Single, motion, gravity, inertia, &mut dynamics);
                for (joint, read) in read.iter_mut().enumerate() {
                    let torque = dynamics.torque[joint] + rotors[joint] * accelerations[joint];
                    let speed = moment.velocity[joint];
                    let friction = of(4, joint) * speed.signum() + of(5, joint) * speed;
                    *read += weight * (of(0, joint) * torque + of(1, joint) + friction);
                }
            }
            readings.extend(read);
        }
        readings
    }

    /// Names of what the rank leaves open: sensors, rotors and gravity.
    fn open_by_rank(&self) -> Vec<String> {
        let unknown: Vec<usize> = (0..self.x.len()).filter(|place| self.is_unknown(*place)).collect();
        let column = |place: &usize| -> Vec<f64> {
            let at = |step: f64| {
                let mut x = self.x.clone();
                x[*place] += step;
                self.readings(&x)
            };
            let slope: Vec<f64> = at(1e-4).iter().zip(at(-1e-4)).map(|(a, b)| (a - b) / 2e-4).collect();
            let norm = slope.iter().map(|s| s * s).sum::<f64>().sqrt();
            if norm > 1e-6 { slope.iter().map(|s| s / norm).collect() } else { vec![0.0; slope.len()] }
        };
        let columns: Vec<Vec<f64>> = unknown.iter().map(column).collect();
        let jacobian = DMatrix::from_fn(columns[0].len(), columns.len(), |row, column| columns[column][row]);
        let values = jacobian.svd(false, true);
        let (sizes, directions) = (&values.singular_values, values.v_t.as_ref().unwrap());
        let largest = sizes.max();
        let share = |own: usize| -> f64 {
            (0..sizes.len()).filter(|i| sizes[*i] < ZERO * largest).map(|i| directions[(i, own)].powi(2)).sum()
        };
        let reported = |name: &str| {
            name.contains("_gain") || name.contains("_offset") || name.contains("rotor") || name == "gravity"
        };
        let open =
            unknown.iter().enumerate().filter(|(own, place)| reported(&self.names[**place]) && share(*own) > SHARED);
        sorted(open.map(|(_, place)| self.names[*place].clone()).collect())
    }

    /// The session that such readings make, with a little noise.
    fn session(&self) -> Session {
        let unknown = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
        let joint = JointPriors {
            torque_unit: Some(TorqueUnit::NewtonMeter),
            torque_sign_declared: true,
            position_unit: PositionUnit::Radian,
            parameters: [1.0, 0.0, 1.0, 0.0].map(unknown),
        };
        let n = self.joints();
        let sensors = vec![NominalSensors::default(); n];
        let robot = Robot { name: "arm".into(), chain: self.chain.clone(), sensors };
        let size = self.gravity.map(|g| g / MAGNITUDE);
        let gravity = GravityPrior { magnitude: MAGNITUDE, magnitude_std: None, hemisphere: Some(size) };
        let mut session = Session::new(robot, gravity, vec![joint; n]);
        let names: Vec<&str> = self.chain.joints().iter().map(|joint| joint.name.as_str()).collect();
        let kinds: Vec<_> = self.chain.joints().iter().map(|joint| joint.kind).collect();
        for index in 0..n {
            for model in ["coulomb-friction", "viscous-friction"] {
                let site = Site::new(index, &names, &kinds, &session.joints[index]);
                let registry = Registry::standard();
                let model = registry.sensor_model(model).unwrap();
                for (term, parameters) in declare_terms(model, &site, &Options::default()).unwrap() {
                    session.terms.extend([term]);
                    session.further.extend(parameters);
                }
            }
        }
        let first_rotor = 2 + 6 * n + 10 * self.chain.link_count();
        for index in 0..n {
            let (value, kind) = (self.x[first_rotor + index], self.line.rotors);
            match kind {
                Rotors::None => {}
                Rotors::Unknown => session.set_rotor_inertia(index, unknown(0.0)),
                Rotors::Known => {
                    session.set_rotor_inertia(index, ParameterPrior { nominal: value, kind: PriorKind::Fixed });
                }
            }
        }
        if self.line.loads != Loads::None {
            let place = self.x.len() - 9;
            let position = self.line.placed.then(|| [self.x[place], self.x[place + 1], self.x[place + 2]]);
            let link = self.chain.link_count() - 1;
            session.loads = vec![Load { name: "plate".into(), mass: LOAD, link, position, position_std: None }];
        }
        let carried = |table: usize| self.carries(table).then_some(0);
        let table =
            |table: usize| PoseTable { path: PathBuf::from("run.csv"), load: carried(table), swept: None, step: None };
        session.tables = [0, 1].map(table).to_vec();
        let mut random = Pcg64::seed_from_u64(5);
        let readings = self.readings(&self.x);
        session.poses = self
            .windows
            .iter()
            .enumerate()
            .map(|(window, (table, moments))| {
                let mean = |of: &dyn Fn(&MotionSample, usize) -> f64| -> Vec<f64> {
                    (0..n).map(|j| moments.iter().map(|(weight, moment)| weight * of(moment, j)).sum()).collect()
                };
                let reading = |joint: usize| {
                    let noise: f64 = NOISE * random.sample::<f64, _>(StandardNormal);
                    Some(Reading { value: readings[n * window + joint] + noise, std: Some(NOISE) })
                };
                Pose {
                    table: *table,
                    line: window as u64,
                    sweep_label: None,
                    load: carried(*table),
                    position: mean(&|moment, j| moment.position[j]),
                    orientation: None,
                    torque: (0..n).map(reading).collect(),
                    instruments: Vec::new(),
                    conditions: Conditions {
                        time: Some(window as f64),
                        temperature: Vec::new(),
                        velocity: mean(&|moment, j| moment.velocity[j]),
                        acceleration: mean(&|moment, j| moment.acceleration[j]),
                        direction: mean(&|moment, j| moment.velocity[j].signum()),
                        presliding: Vec::new(),
                        further: Vec::new(),
                    },
                    course: Some(Arc::new(Course::of(moments))),
                }
            })
            .collect();
        session
    }

    /// The same of the estimate.
    fn open_by_estimate(&self) -> Vec<String> {
        let session = self.session();
        assert_eq!(State::nominal(&session).tensors.len(), self.chain.link_count() + session.loads.len());
        let result =
            with_environment(|environment| estimate_jointly(&session, Signals::All, None, environment)).unwrap();
        let reported = |name: &str| !name.contains("bias") && !name.contains("friction");
        let open = result.parameters.iter().filter(|parameter| parameter.value.is_none() && reported(&parameter.name));
        let gravity = result.gravity.is_none().then(|| "gravity".to_owned());
        sorted(open.map(|parameter| parameter.name.clone()).chain(gravity).collect())
    }
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort();
    names.dedup();
    names
}

/// Sums of sines, other ones in each joint.
fn moment(joints: usize, time: f64) -> MotionSample {
    let mut moment = MotionSample { time, position: Vec::new(), velocity: Vec::new(), acceleration: Vec::new() };
    for joint in 0..joints {
        let mut random = Pcg64::seed_from_u64(90 + joint as u64);
        let mut state = [0.0, 0.0, 0.0];
        for harmonic in 1..=5 {
            let rate = 0.55 * f64::from(harmonic);
            let size = random.random_range(0.3..0.9) / f64::from(harmonic).sqrt();
            let (sin, cos) = (rate * time + random.random_range(0.0..TAU)).sin_cos();
            state[0] += size * sin;
            state[1] += size * rate * cos;
            state[2] -= size * rate * rate * sin;
        }
        moment.position.push(state[0]);
        moment.velocity.push(state[1]);
        moment.acceleration.push(state[2]);
    }
    moment
}

fn line(loads: Loads, placed: bool, rotors: Rotors) -> Line {
    Line { loads, placed, rotors }
}

/// The lines of the table, and whether they tell the gains, and the last joint's offset.
fn lines() -> [(Line, bool, bool); 6] {
    [
        (line(Loads::None, false, Rotors::None), false, false),
        (line(Loads::None, false, Rotors::Unknown), false, false),
        (line(Loads::None, false, Rotors::Known), true, false),
        (line(Loads::AtTimes, false, Rotors::None), true, false),
        (line(Loads::Always, false, Rotors::None), false, false),
        (line(Loads::AtTimes, true, Rotors::None), true, true),
    ]
}

/// Each line, upright and tilted: what the table says, what the rank says, and what the estimate tells are the same.
fn every_line_holds_of(chain: &Chain) {
    let joints = chain.joints();
    for gravity in [[0.0, 0.0, -1.0], [0.3, -0.2, -1.0]] {
        for (line, gains, last_offset) in lines() {
            let arm = Arm::new(chain.clone(), gravity, line, 3);
            let ranked = arm.open_by_rank();
            let gain = |joint: &gravcal_dynamics::Joint| format!("{}.torque_gain", joint.name);
            let offset = format!("{}.position_offset", joints[joints.len() - 1].name);
            let expected: Vec<String> = if gains { Vec::new() } else { joints.iter().map(gain).collect() };
            let offset = (!last_offset).then_some(offset);
            let expected = sorted(expected.into_iter().chain(offset).collect());
            let sensors: Vec<String> = ranked.iter().filter(|name| !name.contains("rotor")).cloned().collect();
            assert_eq!(sensors, expected, "{line:?} {gravity:?}: the rank beside the table");
            assert_eq!(arm.open_by_estimate(), ranked, "{line:?} {gravity:?}: the estimate beside the rank");
        }
    }
}

#[test]
fn what_three_joints_in_motion_tell_is_what_the_rank_says() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("robot.toml"), super::moving_arm::ROBOT).unwrap();
    every_line_holds_of(&read_robot(&folder.path().join("robot.toml")).unwrap().chain);
}

/// An arm of its maker's lengths; its links are others, as those of a URDF may be special.
#[test]
fn what_a_panda_in_motion_tells_is_what_the_rank_says() {
    let Ok(text) = std::fs::read_to_string(shared_data().join("urdf/panda_arm_drake.urdf")) else { return };
    every_line_holds_of(&Chain::from_urdf(&text, "panda_link0", &["panda_link7"]).unwrap());
}
