//! What joints carry while the arm moves, where they bend under it.
//!
//! ```text
//!     x = c τ(q + x, q̇ + D₁ x, q̈ + D₂ x)         x: how far the joints bend, at all moments;  D: derivatives by time
//! ```
//!
//! It is solved in rounds, from stiff joints on. What swings at the frequency `ω` each round makes smaller by `c M ω²`, with `M` the inertia that
//! the joint feels: by the square of the frequency over that of the arm's resonance on its gears. What is faster than the resonance
//! would grow from round to round; it is noise, or motion of which positions on the motors' side tell nothing. So derivatives are those of a polynomial through
//! as many moments as leave it out.
//!
//! Through few moments they follow the noise of the position sensors: the acceleration that is read has it, `D₂ τ` has it with the opposite sign, and what both have in common
//! passes for compliance. Through many they do not follow the motion. So they begin with as many as differ least from the next: noise makes the first differences
//! large, and motion the last. A few more are taken where rounds do not come to an end.

use gravcal_dynamics::{DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_recording::MotionSample;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use nalgebra::{DMatrix, DVector};

use crate::joint::bodies::bodies_in_pose;
use crate::joint::model_error::bending_in_motion::derivatives::{Derivatives, derivatives};
use crate::joint::model_error::bending_in_motion::moments::{Moments, read_beyond};
use crate::joint::variables::State;

/// Over how many moments a torque may be followed, 0.1 to 1.9 s with windows of 0.32 s.
pub(super) const WIDTHS: [usize; 8] = [9, 17, 25, 33, 49, 73, 105, 151];
/// Of so many widths the first is taken over which rounds come to an end: wider ones, which noise asks for, follow less of the motion.
const FOR_ROUNDS: usize = 4;
/// A torque is followed where no more than this share of what it changes by is left: noise of accelerations, and not the motion.
const UNFOLLOWED: f64 = 0.1;
/// What changes by a smaller share of what changes most is rounding.
const LEAST_SHARE: f64 = 1e-6;
/// Rounds in which what bends and what it carries come to agree.
const ROUNDS: usize = 6;
/// They do where the last moves it by no more than this share of what the first did.
const AGREE: f64 = 0.01;

/// By moment: each joint's torque, N·m, and its derivatives by time, per second and per second squared.
pub(super) type Carried = Vec<CarriedAt>;

/// The same of one moment.
pub(super) type CarriedAt = [Vec<f64>; 3];

impl Moments {
    /// What joints carry that bend by these compliances, and the place of the width over which it is followed. Where rounds come to no
    /// agreement, it is that of the widest that is tried.
    pub fn carried_by_bent_joints(&self, session: &Session, state: &State, compliances: &[f64]) -> (Carried, usize) {
        let steadiest = self.steadiest_width(session, state);
        let mut widths = steadiest..FOR_ROUNDS.max(steadiest + 1);
        loop {
            let place = widths.next().unwrap_or(0);
            let (carried, agree) = self.carried_over(WIDTHS[place], session, state, compliances);
            if agree || widths.is_empty() {
                return (carried, place);
            }
        }
    }

    /// The place of the width whose second derivatives differ least from those of the next, of what stiff joints carry, each joint's in share of its own; of
    /// widths over which the torque itself is followed.
    fn steadiest_width(&self, session: &Session, state: &State) -> usize {
        let torques = self.torques(session, state, &[], None);
        let of_width = |width: &usize| {
            let derivatives = derivatives(&self.times, &self.changes, *width);
            let followed = summed(&torques, &derivatives, |derivatives| &derivatives.value);
            (summed(&torques, &derivatives, |derivatives| &derivatives.second), follows(&torques, &followed))
        };
        let of_widths: Vec<(DMatrix<f64>, bool)> = WIDTHS.iter().map(of_width).collect();
        let sizes = squares(&of_widths[WIDTHS.len() - 1].0);
        let apart = |pair: &[(DMatrix<f64>, bool)]| shares(&squares(&(&pair[0].0 - &pair[1].0)), &sizes).sum::<f64>();
        let apart: Vec<f64> = of_widths.windows(2).map(apart).collect();
        let places = (0..apart.len()).take_while(|place| of_widths[*place].1);
        places.min_by(|a, b| apart[*a].total_cmp(&apart[*b])).unwrap_or(0)
    }

    /// What joints carry that bend by these compliances, followed over so many moments; and whether rounds agree. Where one moves it by no less than the one before, as what is
    /// too fast grows, it is left out with all that follow.
    pub fn carried_over(&self, width: usize, session: &Session, state: &State, compliances: &[f64]) -> (Carried, bool) {
        let derivatives = derivatives(&self.times, &self.changes, width);
        let mut torques = self.torques(session, state, compliances, None);
        if compliances.iter().all(|compliance| *compliance == 0.0) {
            return (followed(&torques, &derivatives), true);
        }
        let (mut first, mut last) = (f64::INFINITY, f64::INFINITY);
        for round in 0..ROUNDS {
            let anew = self.torques(session, state, compliances, Some(&followed(&torques, &derivatives)));
            let moved = bent_by(&(&anew - &torques), compliances);
            if moved >= last {
                break;
            }
            (torques, last) = (anew, moved);
            first = if round == 0 { moved } else { first };
        }
        (followed(&torques, &derivatives), last <= AGREE * first)
    }

    /// What joints carry that bend under `before`, N·m, by joint and moment; stiff ones where nothing is said.
    fn torques(&self, session: &Session, state: &State, compliances: &[f64], before: Option<&Carried>) -> DMatrix<f64> {
        let chain = &session.robot.chain;
        let (mut dynamics, still) = (InverseDynamics::new(chain), vec![0.0; chain.joint_count()]);
        let mut bodies: Option<(Option<usize>, Vec<f64>)> = None;
        let mut torques = DMatrix::zeros(chain.joint_count(), self.times.len());
        for (number, (pose, moment)) in self.all().enumerate() {
            let load = session.poses[pose].load;
            let (_, links) = match bodies.take() {
                Some(same) if same.0 == load => bodies.insert(same),
                _ => bodies.insert((load, bodies_in_pose(session, state, pose))),
            };
            let beyond = before.map(|before| read_beyond(moment, state, compliances, &before[number]));
            let MotionSample { position, velocity, acceleration, .. } = beyond.as_ref().unwrap_or(moment);
            let coordinates = coordinates(state, position);
            let [velocities, accelerations] = [velocity, acceleration].map(|rates| of_joints(state, rates));
            let motion =
                JointMotion { coordinates: &coordinates, velocities: &velocities, accelerations: &accelerations };
            let inertia = DynamicParameters { links, rotor_inertia: &still };
            chain.inverse_dynamics(Single, motion, state.gravity, inertia, &mut dynamics);
            torques.column_mut(number).copy_from_slice(&dynamics.torque);
        }
        torques
    }
}

/// Torques with their derivatives by time.
fn followed(torques: &DMatrix<f64>, derivatives: &[Derivatives]) -> Carried {
    let of_moment = |(moment, Derivatives { moments, first, second, .. }): (usize, &Derivatives)| {
        let beside = torques.columns(moments.start, moments.len());
        let sum = |weights: &[f64]| (beside * DVector::from_column_slice(weights)).as_slice().to_vec();
        [torques.column(moment).as_slice().to_vec(), sum(first), sum(second)]
    };
    derivatives.iter().enumerate().map(of_moment).collect()
}

/// Of torques by joint and moment, these sums over the moments beside each.
fn summed(torques: &DMatrix<f64>, derivatives: &[Derivatives], weights: fn(&Derivatives) -> &Vec<f64>) -> DMatrix<f64> {
    let mut sums = DMatrix::zeros(torques.nrows(), derivatives.len());
    for (mut column, over) in sums.column_iter_mut().zip(derivatives) {
        let beside = torques.columns(over.moments.start, over.moments.len());
        column.gemv(1.0, &beside, &DVector::from_column_slice(weights(over)), 0.0);
    }
    sums
}

/// Whether torques are followed well enough that their derivatives are those of the motion.
fn follows(torques: &DMatrix<f64>, followed: &DMatrix<f64>) -> bool {
    let mut changes = torques.clone();
    changes.row_iter_mut().for_each(|mut row| row.add_scalar_mut(-row.mean()));
    shares(&squares(&(torques - followed)), &squares(&changes)).all(|share| share < UNFOLLOWED * UNFOLLOWED)
}

/// By joint, the sum of squares over all moments.
fn squares(of: &DMatrix<f64>) -> Vec<f64> {
    of.row_iter().map(|row| row.norm_squared()).collect()
}

/// Of each joint, the share that some squares are of others, where these are more than rounding.
fn shares(of: &[f64], sizes: &[f64]) -> impl Iterator<Item = f64> {
    let least = LEAST_SHARE * LEAST_SHARE * sizes.iter().copied().fold(0.0, f64::max);
    of.iter().zip(sizes).filter(move |(_, size)| **size > least).map(|(of, size)| of / size)
}

/// How far torques bend joints, all moments together, rad.
fn bent_by(torques: &DMatrix<f64>, compliances: &[f64]) -> f64 {
    let of_joint = |(joint, compliance): (usize, &f64)| (compliance * torques.row(joint).norm()).powi(2);
    compliances.iter().enumerate().map(of_joint).sum::<f64>().sqrt()
}

/// Of joints, rad or m, whose position sensors read this.
fn coordinates(state: &State, positions: &[f64]) -> Vec<f64> {
    let offsets = state.sensors.iter().map(|sensor| sensor[SensorParameter::PositionOffset as usize]);
    of_joints(state, positions).into_iter().zip(offsets).map(|(turned, offset)| turned + offset).collect()
}

/// Velocities or accelerations of joints whose position readings have these.
fn of_joints(state: &State, rates: &[f64]) -> Vec<f64> {
    rates
        .iter()
        .zip(&state.sensors)
        .map(|(rate, sensor)| sensor[SensorParameter::PositionGain as usize] * rate)
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gravcal_recording::Course;

    use super::*;
    use crate::testing::sarcos_shoulder;

    /// Of each link about every axis, kg·m²: the first joint turns three of them, with an inertia of 6 kg·m².
    const TENSOR: [f64; 6] = [2.0, 0.0, 2.0, 0.0, 0.0, 2.0];
    const INERTIA: f64 = 6.0;

    /// An arm without weight whose first joint is read to swing by 0.5 rad at this frequency, rad/s: its moments each 0.0125 s, 8 s long, in one window.
    fn swinging(frequency: f64) -> (Session, State) {
        let mut session = sarcos_shoulder().session(0);
        let moment = |number: usize| {
            let time = 0.0125 * number as f64;
            let (sin, cos) = (frequency * time).sin_cos();
            let first = |value: f64| vec![value, 0.0, 0.0];
            MotionSample {
                time,
                position: first(0.5 * sin),
                velocity: first(0.5 * frequency * cos),
                acceleration: first(-0.5 * frequency * frequency * sin),
            }
        };
        session.poses.truncate(1);
        let moments: Vec<(f64, MotionSample)> = (0..640).map(|number| (1.0 / 640.0, moment(number))).collect();
        session.poses[0].course = Some(Arc::new(Course::of(&moments)));
        let mut state = State::nominal(&session);
        state.sensors.iter_mut().for_each(|sensor| sensor[SensorParameter::PositionGain as usize] = 1.0);
        state.inertia.iter_mut().for_each(|moments| *moments = [0.0; 4]);
        state.tensors = vec![TENSOR; session.robot.chain.link_count() + session.loads.len()];
        (session, state)
    }

    /// Noise of 1 % in the acceleration is as large as all of its second derivative over few moments.
    #[test]
    fn noise_is_left_out_of_derivatives() {
        let (session, state) = swinging(3.0);
        let quiet = Moments::of(&session);
        let mut noisy = session.clone();
        let noise = |number: usize| 0.045 * (37.0 * (number * number) as f64).sin();
        let course = session.poses[0].course.as_ref().unwrap();
        let with_noise = |(number, (weight, moment)): (usize, (f64, &MotionSample))| {
            let acceleration = vec![moment.acceleration[0] + noise(number), 0.0, 0.0];
            (weight, MotionSample { acceleration, ..moment.clone() })
        };
        let moments: Vec<(f64, MotionSample)> = course.moments().enumerate().map(with_noise).collect();
        noisy.poses[0].course = Some(Arc::new(Course::of(&moments)));
        let noisy = Moments::of(&noisy);
        let second = |time: f64| 0.5 * INERTIA * 3.0_f64.powi(4) * (3.0 * time).sin();
        let off = |width: usize| {
            let (carried, _) = noisy.carried_over(width, &session, &state, &[0.0; 3]);
            let inner = carried.iter().zip(&noisy.times).skip(100).take(440);
            inner.map(|([.., found], time)| (found[0] - second(*time)).powi(2)).sum::<f64>().sqrt()
        };
        let [without, with] = [&quiet, &noisy].map(|moments| moments.steadiest_width(&session, &state));
        let all: Vec<f64> = WIDTHS.iter().map(|width| off(*width)).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(without < with && all[with] < 3.0 * least && all[with] < 0.02 * all[0], "{without} {with} {all:?}");
    }

    /// A spring `c` swings a mass beyond it by `1 / (1 + c M ω²)` as far as it is swung itself. Well below the resonance it is
    /// followed over so few moments that rounds agree, and is no farther from the truth than that width differs from the next. Above the resonance, at 13 rad/s, nothing agrees.
    #[test]
    fn a_joint_that_bends_carries_what_swings_beyond_it() {
        for (frequency, compliance, sees) in
            [(3.0, -1e-4, true), (4.0, -1.0 / 600.0, true), (6.0, 1e-3, true), (30.0, -1e-3, false)]
        {
            let (session, state) = swinging(frequency);
            let moments = Moments::of(&session);
            let compliances = [compliance, 0.0, 0.0];
            let (carried, place) = moments.carried_by_bent_joints(&session, &state, &compliances);
            let swings = 0.5 / (1.0 + compliance * INERTIA * frequency * frequency);
            let torque = |time: f64| -INERTIA * swings * frequency * frequency * (frequency * time).sin();
            let off = |carried: &Carried| {
                let inner = carried.iter().zip(&moments.times).skip(100).take(440);
                inner.map(|([found, ..], time)| (found[0] - torque(*time)).abs()).fold(0.0, f64::max)
            };
            let (next, agree) = moments.carried_over(WIDTHS[place + 1], &session, &state, &compliances);
            let largest = INERTIA * swings.abs() * frequency * frequency;
            assert_eq!(agree, sees, "{frequency} rad/s");
            if sees {
                let (off, of_next) = (off(&carried), off(&next));
                assert!(
                    off < 2e-3 * largest && 2.0 * off < of_next,
                    "{frequency} rad/s: {off}, {of_next} of {largest}"
                );
            }
        }
    }
}
