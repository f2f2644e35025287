//! An arm in motion whose truth is known, as a session without any file: seven joints, bare and with a load of known mass.
//!
//! Readings come of inverse dynamics alone. Positions are exact, torques are not; a window's reading is the mean of its samples.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gravcal_dynamics::{Chain, DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_recording::{Conditions, Course, MotionSample, PositionUnit, Reading, TorqueUnit};
use gravcal_robot_model::Registry;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::sensors::{Options, Site, declare_terms};
use gravcal_robot_model::session::{
    GravityPrior, JointPriors, Load, ParameterPrior, Pose, PoseTable, PriorKind, Session,
};
use gravcal_session::read_robot;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub const JOINTS: usize = 7;
const MAGNITUDE: f64 = 9.81;
const LOAD: f64 = 2.0;
/// Samples a second, of which so many make a window, one each so many; so many seconds bare, and as many loaded.
pub const RATE: f64 = 50.0;
const WINDOW: usize = 16;
const STEP: usize = 4;
pub const DURATION: f64 = 24.0;
/// Numbers of a sensor (gain, bias, position gain, offset, Coulomb and viscous friction), of a link, of a load that is not known.
const SENSOR: usize = 6;
const BODY: usize = 10;
pub const UNKNOWN: usize = 2 + (SENSOR + BODY) * JOINTS + 9;

/// What is estimated of each joint, in the order of its numbers.
pub const QUANTITIES: [&str; SENSOR] =
    ["torque_gain", "torque_bias", "position_gain", "position_offset", "coulomb_friction", "viscous_friction"];

/// The arm, its truth, and how it moves.
pub struct Arm {
    pub robot: Robot,
    /// Two small turns of gravity, the sensors' numbers joint by joint, the links', the load's place and tensor.
    pub truth: [f64; UNKNOWN],
    gravity: [f64; 3],
    /// Every sample of both runs.
    pub samples: Vec<MotionSample>,
}

impl Arm {
    /// `upright`: whether gravity is parallel to the first joint's axis.
    pub fn new(upright: bool) -> Result<Arm, String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/kuka-lbr-iiwa14/robot.toml");
        let robot = read_robot(&path).map_err(|error| error.to_string())?;
        let gravity =
            if upright { [0.0, 0.0, -MAGNITUDE] } else { [2.4, -1.7, -(MAGNITUDE * MAGNITUDE - 8.65_f64).sqrt()] };
        let truth = truth(&robot.chain);
        let runs = [11, 12]
            .into_iter()
            .flat_map(|seed| (0..(RATE * DURATION) as usize).map(move |k| moment(k as f64 / RATE, seed)));
        Ok(Arm { robot, truth, gravity, samples: runs.collect() })
    }

    /// Gravity turned by two small angles about axes across it, m/s².
    pub fn gravity(&self, by: &[f64]) -> [f64; 3] {
        let down = nalgebra::Vector3::from(self.gravity);
        let across = nalgebra::Vector3::new(0.0, -down.z, down.y).normalize();
        let other = down.normalize().cross(&across);
        (MAGNITUDE * (down + MAGNITUDE * (by[0] * across + by[1] * other)).normalize()).into()
    }

    /// What the sensors read of every sample at such numbers, without noise.
    pub fn readings(&self, x: &[f64]) -> Vec<[f64; JOINTS]> {
        let sensors = x[2..2 + SENSOR * JOINTS].as_chunks::<SENSOR>().0;
        let bodies = &x[2 + SENSOR * JOINTS..2 + (SENSOR + BODY) * JOINTS];
        let load = &x[2 + (SENSOR + BODY) * JOINTS..];
        let mut loaded = bodies.to_vec();
        let last = &mut loaded[BODY * (JOINTS - 1)..];
        last[0] += LOAD;
        (0..3).for_each(|axis| last[1 + axis] += LOAD * load[axis]);
        (0..6).for_each(|entry| last[4 + entry] += load[3 + entry]);
        let (gravity, mut dynamics) = (self.gravity(&x[..2]), InverseDynamics::new(&self.robot.chain));
        let half = self.samples.len() / 2;
        let read = |(place, sample): (usize, &MotionSample)| {
            let scaled = |list: &[f64]| -> [f64; JOINTS] { std::array::from_fn(|j| sensors[j][2] * list[j]) };
            let mut coordinates = scaled(&sample.position);
            coordinates.iter_mut().zip(sensors).for_each(|(coordinate, [_, _, _, offset, ..])| *coordinate += offset);
            let (velocities, accelerations) = (scaled(&sample.velocity), scaled(&sample.acceleration));
            let motion =
                JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
            let links: &[f64] = if place < half { bodies } else { &loaded };
            let inertia = DynamicParameters { links, rotor_inertia: &[0.0; JOINTS] };
            self.robot.chain.inverse_dynamics(Single, motion, gravity, inertia, &mut dynamics);
            std::array::from_fn(|j| {
                let [gain, bias, _, _, coulomb, viscous] = sensors[j];
                gain * dynamics.torque[j] + bias + coulomb * sample.velocity[j].signum() + viscous * sample.velocity[j]
            })
        };
        self.samples.iter().enumerate().map(read).collect()
    }

    /// First sample of each window.
    fn windows(&self) -> impl Iterator<Item = usize> {
        let half = self.samples.len() / 2;
        (0..half - WINDOW + 1)
            .step_by(STEP)
            .flat_map(move |first| [first, half + first])
            .collect::<std::collections::BTreeSet<_>>()
            .into_iter()
    }

    /// The session: its poses have the readings that `readings` says of each sample.
    pub fn session(&self, readings: &[[f64; JOINTS]]) -> Session {
        let mut session = self.template();
        let half = self.samples.len() / 2;
        session.poses = self.windows().map(|first| self.window(first, usize::from(first >= half), readings)).collect();
        session
    }

    /// The same with other readings, of the same windows.
    pub fn with_readings(&self, session: &Session, readings: &[[f64; JOINTS]]) -> Session {
        let mut session = session.clone();
        for (pose, first) in session.poses.iter_mut().zip(self.windows()) {
            pose.torque = torques(first, readings);
        }
        session
    }

    fn window(&self, first: usize, table: usize, readings: &[[f64; JOINTS]]) -> Pose {
        let samples: Vec<(f64, MotionSample)> =
            (0..WINDOW).map(|place| (weight(place), self.samples[first + place].clone())).collect();
        let mean = |of: &dyn Fn(&MotionSample) -> &[f64], change: fn(f64) -> f64| -> Vec<f64> {
            (0..JOINTS).map(|j| samples.iter().map(|(weight, sample)| weight * change(of(sample)[j])).sum()).collect()
        };
        Pose {
            table,
            line: first as u64,
            sweep_label: None,
            load: (table == 1).then_some(0),
            position: mean(&|sample| &sample.position, |q| q),
            orientation: None,
            torque: torques(first, readings),
            instruments: Vec::new(),
            conditions: Conditions {
                time: Some((first + WINDOW / 2) as f64 / RATE),
                temperature: Vec::new(),
                velocity: mean(&|sample| &sample.velocity, |v| v),
                acceleration: mean(&|sample| &sample.acceleration, |a| a),
                direction: mean(&|sample| &sample.velocity, f64::signum),
                presliding: Vec::new(),
                further: Vec::new(),
            },
            course: Some(Arc::new(Course::of(&samples))),
        }
    }

    /// What the session says beforehand: the robot's lengths and masses, nothing of its sensors but nominal values.
    fn template(&self) -> Session {
        let start = |nominal| ParameterPrior { nominal, kind: PriorKind::Flat };
        let joint = JointPriors {
            torque_unit: Some(TorqueUnit::NewtonMeter),
            torque_sign_declared: true,
            position_unit: PositionUnit::Radian,
            parameters: [1.0, 0.0, 1.0, 0.0].map(start),
        };
        let hemisphere = self.gravity.map(|g| g / MAGNITUDE);
        let gravity = GravityPrior { magnitude: MAGNITUDE, magnitude_std: None, hemisphere: Some(hemisphere) };
        let mut session = Session::new(self.robot.clone(), gravity, vec![joint; JOINTS]);
        let joints = self.robot.chain.joints();
        let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
        let kinds: Vec<_> = joints.iter().map(|joint| joint.kind).collect();
        let registry = Registry::standard();
        for index in 0..JOINTS {
            let site = Site::new(index, &names, &kinds, &session.joints[index]);
            let models = ["coulomb-friction", "viscous-friction"].map(|name| registry.sensor_model(name));
            let declared =
                models.into_iter().flatten().flat_map(|model| declare_terms(model, &site, &Options::default()));
            let declared: Vec<_> = declared.flatten().collect();
            for (term, parameters) in declared {
                session.terms.extend([term]);
                session.further.extend(parameters);
            }
        }
        // As the peers have them.
        session.deflection.stiff = true;
        session.loads =
            vec![Load { name: "plate".into(), mass: LOAD, link: JOINTS - 1, position: None, position_std: None }];
        let table = |table: usize| PoseTable {
            path: PathBuf::from(format!("run-{table}")),
            load: (table == 1).then_some(0),
            swept: None,
            step: None,
        };
        session.tables = [0, 1].map(table).to_vec();
        session
    }
}

/// Mean readings over a window.
fn torques(first: usize, readings: &[[f64; JOINTS]]) -> Vec<Option<Reading>> {
    let mean = |joint: usize| (0..WINDOW).map(|place| weight(place) * readings[first + place][joint]).sum();
    (0..JOINTS).map(|joint| Some(Reading { value: mean(joint), std: None })).collect()
}

/// Share of a sample in its window (Hann).
fn weight(place: usize) -> f64 {
    (1.0 - (TAU * (place as f64 + 0.5) / WINDOW as f64).cos()) / WINDOW as f64
}

fn truth(chain: &Chain) -> [f64; UNKNOWN] {
    let mut random = Pcg64::seed_from_u64(20);
    let mut about = |middle: f64, spread: f64| middle + spread * random.random_range(-1.0..1.0);
    let mut x = vec![0.0; 2];
    for joint in 0..JOINTS {
        let offset = if joint == 0 { 0.0 } else { about(0.0, 0.03) };
        x.extend([about(1.0, 0.05), about(0.0, 0.5), about(1.0, 0.005), offset, about(0.4, 0.2), about(0.3, 0.15)]);
    }
    for link in chain.links() {
        let (mass, moment) = link.inertia.map_or((2.0, [0.1; 3]), |inertia| (inertia.mass, inertia.first_moment));
        x.push(about(mass, 0.1 * mass));
        x.extend(moment.map(|h| about(h, 0.02 * mass)));
        let size = 0.02 * mass;
        x.extend(
            [size, 0.1 * size, 0.9 * size, -0.1 * size, 0.05 * size, 0.5 * size].map(|entry| about(entry, 0.1 * size)),
        );
    }
    x.extend([0.12, -0.05, 0.09]);
    x.extend([0.03, 0.001, 0.028, -0.001, 0.002, 0.025]);
    std::array::from_fn(|place| x[place])
}

/// Sums of sines, other ones in each joint and run.
fn moment(time: f64, run: u64) -> MotionSample {
    let mut moment = MotionSample { time, position: Vec::new(), velocity: Vec::new(), acceleration: Vec::new() };
    for joint in 0..JOINTS {
        let mut random = Pcg64::seed_from_u64(100 * run + joint as u64);
        let mut state = [0.0; 3];
        for harmonic in 1..=5 {
            let rate = TAU * f64::from(harmonic) / 12.0;
            let size: f64 = random.random_range(0.3..0.9) / f64::from(harmonic).sqrt();
            let (sin, cos) = (rate * time + random.random_range(0.0..TAU)).sin_cos();
            let parts = [sin, rate * cos, -rate * rate * sin];
            state.iter_mut().zip(parts).for_each(|(state, part)| *state += size * part);
        }
        moment.position.push(state[0]);
        moment.velocity.push(state[1]);
        moment.acceleration.push(state[2]);
    }
    moment
}
