//! One trial: poses, deflections, readings.

use gravcal_recording::{Conditions, Reading, is_saturated};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::sensors::Moment;
use gravcal_robot_model::session::{Pose, Session};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::conditions::Course;
use super::disturbance::Outliers;
use super::experiment::{Run, Simulation};
use super::instruments;
use super::normal::normal;
use super::statics::{Stand, Statics};

/// Keeps the stream of outliers apart from that of the noise.
const OUTLIERS: u128 = 1 << 100;

/// The session of trial number `trial`.
pub(super) fn session(simulation: &Simulation, trial: u64) -> Session {
    let mut random = Pcg64::new(u128::from(simulation.seed), u128::from(trial));
    // Their own, so that they do not shift the noise of the other readings.
    let mut of_outliers = Pcg64::new(u128::from(simulation.seed) ^ OUTLIERS, u128::from(trial));
    let mut session = simulation.template.clone();
    let poses = simulation.runs.iter().map(Run::poses).sum();
    session.poses.reserve(poses);
    let mut statics = Statics::new(simulation);
    let mut course = Course::new(&simulation.conditions, poses, simulation.seed, trial);
    for (table, run) in simulation.runs.iter().enumerate() {
        for (index, stand) in stands(simulation, run, &mut random).into_iter().enumerate() {
            let conditions = course.next(&stand.position);
            let generators = [&mut random, &mut of_outliers];
            let pose = read_sensors(&mut statics, (table, index), &stand, conditions, generators);
            session.poses.push(pose);
        }
    }
    session
}

pub(super) fn stands(simulation: &Simulation, run: &Run, random: &mut Pcg64) -> Vec<Stand> {
    let joints = simulation.template.joints.len();
    let hold = |random: &mut Pcg64| -> Vec<f64> {
        (0..joints).map(|_| simulation.disturbance.deflection.hold_std * normal(random)).collect()
    };
    let pose_std = simulation.disturbance.deflection.pose_std;
    // Drawn only where it is wanted, so that it does not shift the noise of simulations without it.
    let of_pose = |random: &mut Pcg64| if pose_std > 0.0 { pose_std * normal(random) } else { 0.0 };
    match run {
        Run::Sweep { swept, range, poses, held } => {
            let deflection = hold(random);
            (0..*poses)
                .map(|k| {
                    let deflection = deflection.iter().map(|hold| hold + of_pose(random)).collect();
                    let share = k as f64 / (*poses as f64 - 1.0).max(1.0);
                    let mut position = held.clone();
                    position[*swept] = range[0] + share * (range[1] - range[0]);
                    Stand { position, deflection, swept: Some(*swept) }
                })
                .collect()
        }
        Run::Random { poses, moving } => {
            let mut before: Option<Vec<f64>> = None;
            (0..*poses)
                .map(|_| {
                    let position = match (moving, before.take()) {
                        (Some(moving), Some(before)) => moved(simulation, before, *moving, random),
                        _ => (0..joints).map(|joint| random_position(simulation, joint, random)).collect(),
                    };
                    before = Some(position.clone());
                    let deflection = hold(random).into_iter().map(|hold| hold + of_pose(random)).collect();
                    Stand { position, deflection, swept: None }
                })
                .collect()
        }
    }
}

/// The next readings where so many joints move on, and the others stand.
fn moved(simulation: &Simulation, mut position: Vec<f64>, moving: usize, random: &mut Pcg64) -> Vec<f64> {
    let mut standing: Vec<usize> = (0..position.len()).collect();
    for _ in 0..moving.min(position.len()) {
        let joint = standing.swap_remove(random.random_range(0..standing.len()));
        position[joint] = random_position(simulation, joint, random);
    }
    position
}

/// A reading at which the joint is anywhere within its limits (a whole turn where it has none), but for what its sensor
/// does beyond gain and offset.
fn random_position(simulation: &Simulation, joint: usize, random: &mut Pcg64) -> f64 {
    let [low, high] =
        simulation.template.robot.chain.joints()[joint].limits.unwrap_or([-std::f64::consts::PI, std::f64::consts::PI]);
    let sensor = simulation.truth.sensors[joint];
    let coordinate = random.random_range(low..=high);
    (coordinate - sensor[SensorParameter::PositionOffset as usize]) / sensor[SensorParameter::PositionGain as usize]
}

fn read_sensors(
    statics: &mut Statics<'_>,
    (table, index): (usize, usize),
    stand: &Stand,
    conditions: Conditions,
    [random, of_outliers]: [&mut Pcg64; 2],
) -> Pose {
    let simulation = statics.simulation();
    let load = simulation.template.tables[table].load;
    let (coordinates, torque) = statics.of(stand, &conditions, load);
    let disturbance = &simulation.disturbance;
    let seen = simulation.seen_positions(stand, &conditions, &coordinates);
    let position = seen.iter().zip(&disturbance.position_std).map(|(q, std)| q + std * normal(random)).collect();
    let read = simulation.torque_readings(&Moment::new(torque, &coordinates, &seen, &conditions));
    let torque = read
        .iter()
        .enumerate()
        .map(|(joint, read)| {
            // Drawn for every joint, so that a joint without a sensor does not shift the others' noise.
            let outlier = disturbance.outliers.map_or(0.0, |outliers| outliers.draw(of_outliers));
            let value = read + disturbance.torque_std[joint] * normal(random) + outlier;
            simulation.template.joints[joint].torque_unit?;
            let value = disturbance.converter.map_or(value, |converter| converter.convert(value));
            Some(Reading { value, std: Some(simulation.stated_std(joint)) })
        })
        .collect();
    let instruments = instruments::read(simulation, &coordinates, (table, load), random);
    // Line 1 of a table is its header.
    Pose {
        table,
        line: index as u64 + 2,
        sweep_label: None,
        load,
        position,
        orientation: None,
        torque,
        instruments,
        conditions,
        course: None,
    }
}

impl Simulation {
    /// The session of one trial.
    pub fn session(&self, trial: u64) -> Session {
        let mut session = session(self, trial);
        let Some([lowest, highest]) = self.disturbance.converter.map(|converter| converter.ends()) else {
            return session;
        };
        for pose in &mut session.poses {
            for (reading, saturated) in pose.torque.iter_mut().zip(&mut session.saturated) {
                if reading.is_some_and(|reading| is_saturated(reading.value, Some(lowest), Some(highest))) {
                    *reading = None;
                    *saturated += 1;
                }
            }
        }
        session
    }

    /// Position readings without noise, the joints at their true coordinates.
    pub(super) fn seen_positions(&self, stand: &Stand, conditions: &Conditions, coordinates: &[f64]) -> Vec<f64> {
        if !self.disturbance.deflection.seen {
            return stand.position.clone();
        }
        let sent = self.coordinates(&stand.position, conditions);
        let deflected = |joint: usize| {
            (coordinates[joint] - sent[joint]) / self.truth.sensors[joint][SensorParameter::PositionGain as usize]
        };
        stand.position.iter().enumerate().map(|(joint, q)| q + deflected(joint)).collect()
    }
}

impl Outliers {
    /// The error of one reading, zero for most.
    fn draw(self, random: &mut Pcg64) -> f64 {
        let error = self.std * normal(random);
        if random.random_range(0.0..1.0) < self.share { error } else { 0.0 }
    }
}
