//! Recordings in motion: the arm moves from pose to pose, settles, stands, and every sample is recorded.
//!
//! ```text
//!   position      ╭────────  standstill of `samples`  ───╮        a move of least jerk, then A σ exp(−t/T) cos(2π f t)
//!   ╭─ move ─╮ settling                                  ╰─ move   of vibration in every reading, and noise
//! ```
//!
//! A sweep with a speed is one joint that goes slowly to the end of its way and back ([`super::stroke`]) while the others stand.
//!
//! A move takes the torques that gravity and the arm's inertia need, where the robot's file states the links' inertia tensors; else those of
//! gravity alone, and such a recording is for standstills only.
//!
//! Noise of a sample is that of the averaged reading times the root of the number of samples; with a correlation time it is of first
//! order from sample to sample. What makes a recording dirty (outliers, lost messages, touches) is drawn apart from the noise: a dirty
//! recording has the noise of the clean one; so are friction at rest ([`super::friction`]) and the walk of zeros.

use gravcal_recording::{Conditions, DahlFriction, Reading};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::sensors::Moment;
use gravcal_robot_model::session::{Pose, Session};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::draw::stands;
use super::earlier_load::Kept;
use super::experiment::{Run, Simulation};
use super::friction::Bristles;
use super::harmonic::Dynamics;
use super::motion::{HarmonicMotion, Motion};
use super::normal::normal;
use super::statics::{Stand, Statics};
use super::stroke::Stroke;

/// Frequency of what vibrates after a move, Hz.
const VIBRATION: f64 = 12.0;
/// Largest outlier and touch, in standard deviations of a sample.
const OUTLIER: f64 = 50.0;
const TOUCH: f64 = 20.0;
/// How long a touch lasts, s.
const TOUCHED: f64 = 0.06;
/// From how far a joint comes to a pose from a chosen side, rad or m.
const ASIDE: f64 = 0.05;
/// Keeps the stream of the zeros' walk apart from the others.
const WALK: u64 = 0x7761_6c6b;
/// Time between two stretches of motion at least, s.
const LEAST_PAUSE: f64 = 1.0;
/// Time between the recordings of two tables, s.
const BETWEEN: f64 = 10.0;

/// Where a pose truly stands still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueStandstill {
    /// Index of the table.
    pub table: usize,
    /// From the end of the move to the beginning of the next, s; it settles first.
    pub interval: [f64; 2],
    /// Whether something touches the arm.
    pub touched: bool,
}

/// Takes the index of a table, and the cells of its next row.
pub type Sink<'a, E> = dyn FnMut(usize, &[f64]) -> Result<(), E> + 'a;

/// What a recording should lead to.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// The session whose poses are the means over the true standstills, before anything makes the recording dirty; slow sweeps have none.
    pub session: Session,
    /// One for each of its poses.
    pub standstills: Vec<TrueStandstill>,
}

/// Records one trial: `sink` takes each row of each table, its time, then the position and the torque reading of every joint.
/// Instruments are not recorded.
///
/// # Errors
/// Those of `sink`.
pub fn record<E>(simulation: &Simulation, motion: &Motion, trial: u64, sink: &mut Sink<'_, E>) -> Result<Recorded, E> {
    let mut random = Pcg64::new(u128::from(simulation.seed), u128::from(trial));
    let runs: Vec<Vec<Stand>> = simulation.runs.iter().map(|run| stands(simulation, run, &mut random)).collect();
    let poses = runs.iter().map(Vec::len).sum::<usize>() * motion.approach.sides().len();
    let mut recorder = Recorder::new(simulation, motion, random, trial, poses);
    for (table, (stands, run)) in runs.iter().zip(&simulation.runs).enumerate() {
        match (&motion.harmonic, motion.sweeping, run) {
            (Some(harmonic), ..) => recorder.record_motion(table, stands.len(), harmonic, sink)?,
            (None, Some(speed), Run::Sweep { swept, .. }) => {
                recorder.record_sweep(table, stands, *swept, speed, sink)?;
            }
            _ => recorder.record_table(table, stands, sink)?,
        }
    }
    Ok(Recorded { session: recorder.session, standstills: recorder.standstills })
}

struct Recorder<'a> {
    simulation: &'a Simulation,
    statics: Statics<'a>,
    /// Of the table that is recorded, where tensors are known.
    dynamics: Option<Dynamics<'a>>,
    motion: &'a Motion,
    random: Pcg64,
    /// Of dirt.
    dirty: Pcg64,
    touched: Vec<usize>,
    bristles: Option<Bristles<'a>>,
    kept: Kept<'a>,
    /// Of trajectories.
    trajectories: Pcg64,
    /// Of the walk.
    walking: Pcg64,
    /// Where the zero of each torque reading has gone, unit of the reading.
    walked: Vec<f64>,
    /// Noise of each position and torque reading, in standard deviations.
    noise: Vec<f64>,
    /// Time of the next sample, s, is this and so many samples.
    begun: f64,
    sample: u64,
    direction: Vec<f64>,
    session: Session,
    standstills: Vec<TrueStandstill>,
}

/// Readings without noise, and in which phase.
struct Still {
    readings: Vec<f64>,
    /// Since the end of the move, s; negative during it.
    since: f64,
}

impl<'a> Recorder<'a> {
    fn new(simulation: &'a Simulation, motion: &'a Motion, random: Pcg64, trial: u64, poses: usize) -> Recorder<'a> {
        let joints = simulation.template.joints.len();
        let mut dirty = Pcg64::seed_from_u64(simulation.seed ^ trial.rotate_left(32) ^ 0x6469_7274);
        let touched = rand::seq::index::sample(&mut dirty, poses, motion.dirt.touched.min(poses)).into_vec();
        let session = simulation.template.clone();
        let noise = vec![0.0; 2 * joints];
        let direction = vec![0.0; joints];
        let standstills = Vec::new();
        Recorder {
            simulation,
            statics: Statics::new(simulation),
            dynamics: None,
            motion,
            random,
            dirty,
            touched,
            bristles: motion.friction.as_ref().map(|friction| Bristles::new(friction, simulation.seed, trial)),
            kept: Kept::new(motion.hysteresis.as_ref(), motion.creep),
            trajectories: Pcg64::seed_from_u64(motion.harmonic.map_or(0, |harmonic| harmonic.seed)),
            walking: Pcg64::seed_from_u64(simulation.seed ^ trial.rotate_left(32) ^ WALK),
            walked: vec![0.0; joints],
            noise,
            begun: 0.0,
            sample: 0,
            direction,
            session,
            standstills,
        }
    }

    fn time(&self) -> f64 {
        self.begun + self.sample as f64 / self.motion.rate
    }

    fn record_table<E>(&mut self, table: usize, stands: &[Stand], sink: &mut Sink<'_, E>) -> Result<(), E> {
        let (simulation, load) = (self.simulation, self.simulation.template.tables[table].load);
        self.dynamics = (!simulation.truth.tensors.is_empty()).then(|| Dynamics::new(simulation, load));
        let count = |seconds: f64| (seconds * self.motion.rate).round() as u64;
        let (moving, settling) = (count(self.motion.moving).max(1), count(self.motion.settling));
        let sides = self.motion.approach.sides();
        let visits = stands.iter().flat_map(|stand| sides.iter().map(move |side| (stand, *side)));
        let mut before = stands[0].clone();
        self.appear(&before);
        for (index, (stand, side)) in visits.enumerate() {
            if index > 0 && side != 0.0 {
                let aside = self.aside(stand, side);
                self.go(table, [&before, &aside], moving, sink)?;
                before = aside;
            }
            let beyond = if index == 0 { stand.clone() } else { self.beyond(stand) };
            if index > 0 {
                self.go(table, [&before, &beyond], moving, sink)?;
            }
            for step in 1..=if index == 0 { moving + settling } else { settling } {
                // The arm stands at the first pose from the beginning.
                let since = if index == 0 { f64::MAX } else { step as f64 / self.motion.rate };
                let readings = self.readings(table, &between(&beyond, stand, step as f64 / settling.max(1) as f64));
                self.row(table, &Still { readings, since }, None, sink)?;
            }
            self.stand(table, index, stand, sink)?;
            before = stand.clone();
        }
        self.begun = self.time() + BETWEEN;
        self.sample = 0;
        Ok(())
    }

    /// So many stretches of an arm that never stands; what is between two is not recorded.
    fn record_motion<E>(
        &mut self,
        table: usize,
        stretches: usize,
        harmonic: &HarmonicMotion,
        sink: &mut Sink<'_, E>,
    ) -> Result<(), E> {
        let simulation = self.simulation;
        let mut dynamics = Dynamics::new(simulation, simulation.template.tables[table].load);
        for _ in 0..stretches {
            let trajectory = harmonic.trajectory(simulation, &mut self.trajectories);
            let joint = |joint| DahlFriction::new(self.position_gain(joint));
            let mut built_up: Vec<DahlFriction> = (0..self.direction.len()).map(joint).collect();
            for sample in 0..self.motion.samples {
                let time = sample as f64 / self.motion.rate;
                let [coordinates, velocities, accelerations] = trajectory.at(time);
                let bent = dynamics.bent(&trajectory, time);
                let sensed = coordinates.iter().zip(&bent.by).map(|(coordinate, by)| coordinate - by);
                let sensors = sensed.zip(&simulation.truth.sensors);
                let position: Vec<f64> =
                    sensors.map(|(sensed, [_, _, gain, offset])| (sensed - offset) / gain).collect();
                // Friction is on the motors' side of what bends.
                let of_motors: Vec<f64> =
                    velocities.iter().zip(&bent.rate).map(|(of_link, rate)| of_link - rate).collect();
                let velocity = self.velocities_told(&of_motors);
                self.direction = velocity.iter().map(|speed| speed.signum()).collect();
                built_up.iter_mut().zip(&position).for_each(|(friction, reading)| friction.go(*reading));
                let presliding = built_up.iter().map(DahlFriction::state).collect();
                let conditions = Conditions { velocity, presliding, ..self.conditions(self.time()) };
                let mut true_coordinates = simulation.coordinates(&position, &conditions);
                true_coordinates.iter_mut().zip(&bent.by).for_each(|(coordinate, by)| *coordinate += by);
                let mut torque = dynamics.torques([&true_coordinates, &velocities, &accelerations]).to_vec();
                torque.iter_mut().zip(&bent.of_rotors).for_each(|(torque, less)| *torque -= less);
                if let Some(bristles) = &mut self.bristles {
                    let of_motors: Vec<f64> =
                        coordinates.iter().zip(&bent.by).map(|(of_link, by)| of_link - by).collect();
                    match sample {
                        0 => bristles.appear(of_motors),
                        _ => bristles.go(&of_motors),
                    }
                    bristles.add_to(&mut torque);
                }
                let at = Moment::new(&torque, &true_coordinates, &position, &conditions);
                let torques = simulation.torque_readings(&at);
                let readings = position.into_iter().chain(torques).collect();
                self.row(table, &Still { readings, since: f64::MAX }, None, sink)?;
            }
            self.begun = self.time() + self.motion.moving.max(LEAST_PAUSE);
            self.sample = 0;
        }
        self.begun += BETWEEN;
        Ok(())
    }

    /// One joint goes slowly from its first pose to its last, and back.
    fn record_sweep<E>(
        &mut self,
        table: usize,
        stands: &[Stand],
        swept: usize,
        speed: f64,
        sink: &mut Sink<'_, E>,
    ) -> Result<(), E> {
        self.dynamics = Some(Dynamics::new(self.simulation, self.simulation.template.tables[table].load));
        let ends = [&stands[0], &stands[stands.len() - 1]];
        let gain = self.position_gain(swept);
        self.appear(ends[0]);
        // It stands before it sets out, and where it turns.
        let pause = (self.motion.settling * self.motion.rate).round() as u64 + 1;
        for [from, to] in [ends, [ends[1], ends[0]]] {
            for _ in 0..pause {
                let readings = self.readings(table, from);
                self.row(table, &Still { readings, since: f64::MAX }, None, sink)?;
            }
            self.turn(from, to);
            let stroke = Stroke::new(gain * (to.position[swept] - from.position[swept]), speed, self.motion.moving);
            let steps = (stroke.duration() * self.motion.rate).floor() as u64;
            for step in 1..=steps {
                let [far, velocity, acceleration] = stroke.at(step as f64 / self.motion.rate);
                let mut at = from.clone();
                at.position[swept] += far / gain;
                let rates = [velocity, acceleration].map(|rate| {
                    let mut rates = vec![0.0; at.position.len()];
                    rates[swept] = rate;
                    rates
                });
                let readings = self.readings_in_motion(table, &at, Some(&rates));
                self.row(table, &Still { readings, since: f64::MAX }, None, sink)?;
            }
        }
        self.begun = self.time() + BETWEEN;
        self.sample = 0;
        Ok(())
    }

    /// One move.
    fn go<E>(&mut self, table: usize, [from, to]: [&Stand; 2], steps: u64, sink: &mut Sink<'_, E>) -> Result<(), E> {
        self.turn(from, to);
        let duration = steps as f64 / self.motion.rate;
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            let rates = self.rates([from, to], share, duration);
            let readings = self.readings_in_motion(table, &between(from, to, share), Some(&rates));
            let since = (step as f64 - steps as f64) / self.motion.rate;
            self.row(table, &Still { readings, since }, None, sink)?;
        }
        Ok(())
    }

    /// Velocities and accelerations of all coordinates after a share of a move that takes so long, s.
    fn rates(&self, [from, to]: [&Stand; 2], share: f64, duration: f64) -> [Vec<f64>; 2] {
        let far = |joint: usize| self.position_gain(joint) * (to.position[joint] - from.position[joint]);
        smooth_rates(share, duration).map(|rate| (0..to.position.len()).map(|joint| rate * far(joint)).collect())
    }

    /// Coordinates of all joints for what friction does.
    fn travelled(&self, stand: &Stand) -> Vec<f64> {
        stand.position.iter().enumerate().map(|(joint, reading)| self.position_gain(joint) * reading).collect()
    }

    /// What a recording tells of these velocities of the coordinates: those of its readings by the nominal gain, rad/s or m/s.
    fn velocities_told(&self, velocities: &[f64]) -> Vec<f64> {
        let told = |(joint, speed): (usize, &f64)| speed * self.nominal_gain(joint) / self.position_gain(joint);
        velocities.iter().enumerate().map(told).collect()
    }

    fn nominal_gain(&self, joint: usize) -> f64 {
        self.simulation.template.joints[joint].of(SensorParameter::PositionGain).nominal
    }

    fn position_gain(&self, joint: usize) -> f64 {
        self.simulation.truth.sensors[joint][SensorParameter::PositionGain as usize]
    }

    fn appear(&mut self, stand: &Stand) {
        let at = self.travelled(stand);
        self.bristles.iter_mut().for_each(|bristles| bristles.appear(at.clone()));
    }

    /// Where the joints go a little too far.
    fn beyond(&mut self, stand: &Stand) -> Stand {
        let goal = self.travelled(stand);
        let beyond =
            self.bristles.as_mut().map_or_else(|| vec![0.0; goal.len()], |bristles| bristles.overshoots(&goal));
        self.moved(stand, &beyond)
    }

    /// Where the joints come from to come from one side.
    fn aside(&self, stand: &Stand, side: f64) -> Stand {
        let rises = |joint| self.position_gain(joint).signum() * side;
        let away: Vec<f64> = (0..stand.position.len()).map(|joint| -ASIDE * rises(joint)).collect();
        self.moved(stand, &away)
    }

    /// The same with each joint so far away, rad or m.
    fn moved(&self, stand: &Stand, by: &[f64]) -> Stand {
        let position = stand.position.iter().zip(by).enumerate();
        let position = position.map(|(joint, (reading, by))| reading + by / self.position_gain(joint)).collect();
        Stand { position, ..stand.clone() }
    }

    /// From which side each joint comes.
    fn turn(&mut self, before: &Stand, stand: &Stand) {
        for (joint, (from, to)) in before.position.iter().zip(&stand.position).enumerate() {
            if from != to {
                self.direction[joint] = (self.nominal_gain(joint) * (to - from)).signum();
            }
        }
    }

    /// The samples of a standstill, and their mean as a pose.
    fn stand<E>(&mut self, table: usize, index: usize, stand: &Stand, sink: &mut Sink<'_, E>) -> Result<(), E> {
        let (joints, samples) = (self.direction.len(), self.motion.samples);
        let from = self.time();
        let arrival = from - (if index == 0 { self.motion.moving } else { 0.0 }) - self.motion.settling;
        let mut mean = vec![0.0; 2 * joints];
        let touched = self.touched.contains(&self.session.poses.len());
        let length = samples as f64 / self.motion.rate;
        let touch = touched.then(|| [from + 0.5 * length, from + 0.5 * length + TOUCHED.min(0.25 * length)]);
        for step in 0..samples {
            let since = self.motion.settling + step as f64 / self.motion.rate;
            let since = if index == 0 { f64::MAX } else { since };
            // Zeros may drift while the arm stands.
            let readings = self.readings(table, stand);
            let clean = self.row(table, &Still { readings, since }, touch, sink)?;
            mean.iter_mut().zip(clean).for_each(|(mean, reading)| *mean += reading / samples as f64);
        }
        let interval = [arrival, self.time() - 1.0 / self.motion.rate];
        let stated = |joint: usize| self.simulation.stated_std_of_recording(joint, self.motion);
        let reading = |joint: usize| {
            self.simulation.template.joints[joint].torque_unit?;
            Some(Reading { value: mean[joints + joint], std: Some(stated(joint)) })
        };
        let conditions = self.conditions(0.5 * (from + interval[1]));
        let pose = Pose {
            table,
            line: index as u64 + 2,
            sweep_label: None,
            load: self.simulation.template.tables[table].load,
            position: mean[..stand.position.len()].to_vec(),
            orientation: None,
            torque: (0..joints).map(reading).collect(),
            instruments: Vec::new(),
            conditions,
            course: None,
        };
        self.session.poses.push(pose);
        self.standstills.push(TrueStandstill { table, interval, touched });
        Ok(())
    }

    fn conditions(&self, time: f64) -> Conditions {
        Conditions { time: Some(time), direction: self.direction.clone(), ..Conditions::default() }
    }

    /// What all sensors would read without noise: positions, then torques.
    fn readings(&mut self, table: usize, stand: &Stand) -> Vec<f64> {
        self.readings_in_motion(table, stand, None)
    }

    /// The same of an arm that passes with these velocities and accelerations.
    fn readings_in_motion(&mut self, table: usize, stand: &Stand, rates: Option<&[Vec<f64>; 2]>) -> Vec<f64> {
        let simulation = self.simulation;
        let velocity = rates.map(|[velocities, _]| self.velocities_told(velocities)).unwrap_or_default();
        let conditions = Conditions { velocity, ..self.conditions(self.time()) };
        let travelled = self.travelled(stand);
        let (coordinates, torque) = self.statics.of(stand, &conditions, simulation.template.tables[table].load);
        let mut torque = torque.to_vec();
        if let (Some(dynamics), Some([velocities, accelerations])) = (&mut self.dynamics, rates) {
            let of_motion = dynamics.torques_of_motion([&coordinates, velocities, accelerations]);
            torque.iter_mut().zip(of_motion).for_each(|(torque, of_motion)| *torque += of_motion);
        }
        if let Some(bristles) = &mut self.bristles {
            bristles.go(&travelled);
            bristles.add_to(&mut torque);
        }
        let seen = simulation.seen_positions(stand, &conditions, &coordinates);
        let torques = simulation.torque_readings(&Moment::new(&torque, &coordinates, &seen, &conditions));
        seen.into_iter().chain(torques).collect()
    }

    /// The zeros walk on by one sample.
    fn walk(&mut self) {
        for (walked, walk) in self.walked.iter_mut().zip(&self.motion.walk).filter(|(_, walk)| **walk > 0.0) {
            *walked += walk / self.motion.rate.sqrt() * normal(&mut self.walking);
        }
    }

    /// Records one row, unless its message is lost. Gives the readings before anything makes them dirty.
    fn row<E>(
        &mut self,
        table: usize,
        still: &Still,
        touch: Option<[f64; 2]>,
        sink: &mut Sink<'_, E>,
    ) -> Result<Vec<f64>, E> {
        let time = self.time();
        self.sample += 1;
        let (motion, dirt) = (self.motion, self.motion.dirt);
        let vibration = if still.since > 0.0 {
            let phase = std::f64::consts::TAU * VIBRATION * still.since.min(1e3);
            motion.vibration * (-still.since / motion.settling_time).exp() * phase.cos()
        } else {
            0.0
        };
        self.walk();
        let joints = self.direction.len();
        let lacks = self.kept.lacks(&still.readings[joints..], time);
        let mut cells = vec![time];
        let mut clean = Vec::with_capacity(still.readings.len());
        for (channel, reading) in still.readings.iter().enumerate() {
            let white = normal(&mut self.random);
            let keeps = if motion.correlation > 0.0 { (-1.0 / (motion.rate * motion.correlation)).exp() } else { 0.0 };
            self.noise[channel] = keeps * self.noise[channel] + (1.0 - keeps * keeps).sqrt() * white;
            let std = self.simulation.sample_std(channel, motion);
            let convert = |value: f64| match self.simulation.disturbance.converter {
                Some(converter) if channel >= joints => converter.convert(value),
                _ => value,
            };
            let zero = channel.checked_sub(joints).map_or(0.0, |joint| self.walked[joint] - lacks[joint]);
            let value = reading + zero + std * (self.noise[channel] + vibration);
            clean.push(convert(value));
            let is_touched = touch.is_some_and(|[from, until]| (from..until).contains(&time));
            let touched = if is_touched && channel >= joints { TOUCH * std } else { 0.0 };
            let is_outlier = dirt.outliers > 0.0 && self.dirty.random_range(0.0..1.0) < dirt.outliers;
            let outlier = if is_outlier { self.dirty.random_range(-OUTLIER..OUTLIER) * std } else { 0.0 };
            let has_sensor =
                channel < joints || self.simulation.template.joints[channel - joints].torque_unit.is_some();
            cells.push(if has_sensor { convert(value + touched + outlier) } else { f64::NAN });
        }
        let is_lost = dirt.dropped > 0.0 && self.dirty.random_range(0.0..1.0) < dirt.dropped;
        if !is_lost {
            sink(table, &cells)?;
        }
        Ok(clean)
    }
}

/// A move of least jerk (Flash and Hogan, 1985).
fn between(from: &Stand, to: &Stand, share: f64) -> Stand {
    let smooth = smooth(share);
    let mix = |from: &[f64], to: &[f64]| from.iter().zip(to).map(|(from, to)| from + smooth * (to - from)).collect();
    Stand {
        position: mix(&from.position, &to.position),
        deflection: mix(&from.deflection, &to.deflection),
        swept: to.swept,
    }
}

/// Share of the way after a share of the time.
fn smooth(share: f64) -> f64 {
    share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share)
}

/// Its first and second derivative by time, 1/s and 1/s², in a move that takes so long.
fn smooth_rates(share: f64, duration: f64) -> [f64; 2] {
    let left = 1.0 - share;
    [30.0 * (share * left).powi(2) / duration, 60.0 * share * left * (left - share) / duration.powi(2)]
}

impl Simulation {
    /// Standard deviation of one sample of a position (channels of joints) or a torque (those behind).
    fn sample_std(&self, channel: usize, motion: &Motion) -> f64 {
        let joints = self.template.joints.len();
        let disturbance = &self.disturbance;
        let averaged = if motion.harmonic.is_some() { 1.0 } else { motion.samples as f64 };
        let of_mean = match channel.checked_sub(joints) {
            None => disturbance.position_std[channel],
            Some(joint) => disturbance.torque_std[joint],
        };
        of_mean * averaged.sqrt()
    }

    /// Standard deviation of the mean of a joint's torque over a standstill, each sample rounded by the converter.
    fn stated_std_of_recording(&self, joint: usize, motion: &Motion) -> f64 {
        let step = self.disturbance.converter.map_or(0.0, |converter| converter.step());
        (self.disturbance.torque_std[joint].powi(2) + step * step / 12.0 / motion.samples as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_of_a_move_are_the_slopes_of_its_way() {
        let (duration, step) = (0.4, 1e-4);
        for share in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let at = |by: f64| smooth(share + by * step);
            let [velocity, acceleration] = smooth_rates(share, duration);
            let time = step * duration;
            assert!((velocity - (at(1.0) - at(-1.0)) / (2.0 * time)).abs() < 1e-5, "{share}: {velocity}");
            assert!((acceleration - (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (time * time)).abs() < 1e-4, "{share}");
        }
    }
}
