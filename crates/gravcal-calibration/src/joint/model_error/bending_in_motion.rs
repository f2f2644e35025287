//! Joints that bend while the arm moves: what their compliances do to the readings of windows.
//!
//! ```text
//!     θ_j = s_j q_j + o_j + c_j τ_j(t),     θ̇_j = s_j q̇_j + c_j τ̇_j,     θ̈_j = s_j q̈_j + c_j τ̈_j
//!     C_j = [y(c_1, …, c_j, 0, …) − y(c_1, …, c_(j−1), 0, …)] / c_j
//! ```
//!
//! `τ_j(t)` is the torque that passes the joint's gear at each moment of a window, as the model has it: without friction and without the rotor's, which are
//! on the motor's side. Its derivatives by time are those of the quartic that is nearest to nine moments that follow each other: what is
//! faster than that is more noise than torque. `y(c)` are predictions for positions as they would be read beyond joints that bend so. What
//! a compliance does to the readings, `C_j`, is a constant of each fit. It is a secant: at the compliances of a solution all joints together do exactly
//! what they do there.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{DynamicParameters, InverseDynamics, JointMotion, Single};
use gravcal_estimation::{EvaluateError, in_parallel};
use gravcal_recording::{Course, Kept, MotionSample, WeighedStretch};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use nalgebra::DMatrix;

use crate::joint::bodies::bodies_in_pose;
use crate::joint::building::displacements::predictions;
use crate::joint::measurement_set::{Effect, MeasurementSet};
use crate::joint::variables::State;

/// Moments over which a torque is followed, and the degree of the polynomial that follows it.
const FOLLOWED: usize = 9;
const DEGREE: usize = 4;
/// By which share of the usual one a step between two moments of a run may differ from it.
const UNEVEN: f64 = 0.5;
/// Rounds in which what bends and what it carries come to agree: each makes the difference smaller by compliance times stiffness, and by the square of
/// the frequency over that of the joint's resonance, a few per cent.
const ROUNDS: usize = 4;
/// A compliance that is a larger share of its prior's standard deviation is itself the step of its secant; else the step is this share.
const STEP: f64 = 0.01;

/// What a compliance of 1 rad/(N·m) of each joint that may bend (`std` is positive) does to the readings of windows, by pose and channel; zero of
/// static poses. Nothing where there are no windows.
///
/// # Errors
/// Where a residual has no value there.
pub(in crate::joint) fn effects_in_motion(
    session: &Session,
    readings: &MeasurementSet,
    state: &State,
    std: &[f64],
) -> Result<Vec<Effect>, EvaluateError> {
    if session.poses.iter().all(|pose| pose.course.is_none()) {
        return Ok(Vec::new());
    }
    // What recordings were searched for is large, and no prediction reads it.
    let session = &Session { searched: Vec::new(), validation: Vec::new(), ..session.clone() };
    let moments = Moments::of(session);
    let found = |joint: usize| state.bending.get(joint).copied().unwrap_or(0.0);
    let carried = moments.carried_by_bent_joints(session, state, &(0..std.len()).map(found).collect::<Vec<_>>());
    let bending: Vec<usize> = (0..std.len()).filter(|joint| std[*joint] > 0.0).collect();
    let step = |joint: usize| if found(joint).abs() > STEP * std[joint] { found(joint) } else { STEP * std[joint] };
    let of_links = without_rotors(session, state);
    // The first joints bend, and the others do not.
    let predicted = |count: usize| {
        let mut compliances = vec![0.0; std.len()];
        bending[..count].iter().for_each(|joint| compliances[*joint] = step(*joint));
        let beyond = moments.session_read_beyond(session, state, &compliances, &carried);
        predictions(&beyond, readings, &of_links, &session.robot.chain)
    };
    let predicted = in_parallel(0..=bending.len(), predicted).into_iter().collect::<Result<Vec<Effect>, _>>()?;
    let effect = |(joint, pair): (&usize, &[Effect])| -> Effect {
        let of_pose = |(with, without): (&Vec<f64>, &Vec<f64>)| {
            with.iter().zip(without).map(|(with, without)| (with - without) / step(*joint)).collect()
        };
        pair[1].iter().zip(&pair[0]).map(of_pose).collect()
    };
    Ok(bending.iter().zip(predicted.windows(2)).map(effect).collect())
}

/// The same without rotor inertias: rotors move as their sensors read, whatever bends behind them.
fn without_rotors(session: &Session, state: &State) -> State {
    let mut state = state.clone();
    session.rotors.iter().flatten().for_each(|place| state.further[*place] = 0.0);
    state
}

/// The moments of all windows of a session, each once.
struct Moments {
    stretches: Vec<Arc<[MotionSample]>>,
    /// Of each stretch, the first pose that sees it, and the number of its first moment.
    poses: Vec<usize>,
    firsts: Vec<usize>,
    /// By pose, the numbers of the stretches that it sees.
    seen: Vec<Vec<usize>>,
    /// By moment, how its derivatives are those of its neighbours.
    derivatives: Vec<Derivatives>,
}

/// First and second derivatives by time as sums over moments that follow each other.
#[derive(Clone, Debug)]
struct Derivatives {
    moments: Range<usize>,
    first: Vec<f64>,
    second: Vec<f64>,
}

/// By moment: each joint's torque, N·m, and its derivatives by time, per second and per second squared.
type Carried = Vec<[Vec<f64>; 3]>;

impl Moments {
    fn of(session: &Session) -> Moments {
        let (mut stretches, mut poses, mut firsts, mut times) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut numbers: HashMap<*const MotionSample, usize> = HashMap::new();
        let mut seen = vec![Vec::new(); session.poses.len()];
        for (pose, seen) in seen.iter_mut().enumerate() {
            for WeighedStretch { moments, .. } in session.poses[pose].course.iter().flat_map(|course| &course.stretches)
            {
                let number = *numbers.entry(moments.as_ptr()).or_insert_with(|| {
                    stretches.push(Arc::clone(moments));
                    poses.push(pose);
                    firsts.push(times.len());
                    times.extend(moments.iter().map(|moment| moment.time));
                    stretches.len() - 1
                });
                seen.push(number);
            }
        }
        let load = |stretch: usize| session.poses[poses[stretch]].load;
        let changes = (1..stretches.len()).filter(|stretch| load(*stretch) != load(stretch - 1));
        let changes: Vec<usize> = changes.map(|stretch| firsts[stretch]).collect();
        Moments { derivatives: derivatives(&times, &changes), stretches, poses, firsts, seen }
    }

    /// Each moment with the pose that sees it first.
    fn all(&self) -> impl Iterator<Item = (usize, &MotionSample)> {
        self.stretches
            .iter()
            .zip(&self.poses)
            .flat_map(|(stretch, pose)| stretch.iter().map(move |moment| (*pose, moment)))
    }

    /// What joints carry that bend by these compliances, in rounds as long as each moves it by less than the one before.
    fn carried_by_bent_joints(&self, session: &Session, state: &State, compliances: &[f64]) -> Carried {
        let bends = compliances.iter().any(|compliance| *compliance != 0.0);
        let mut carried = self.carried(session, state, compliances, None);
        let mut moved = f64::INFINITY;
        for _ in 1..if bends { ROUNDS } else { 1 } {
            let anew = self.carried(session, state, compliances, Some(&carried));
            let pairs = anew.iter().zip(&carried).flat_map(|([anew, ..], [before, ..])| anew.iter().zip(before));
            let moves: f64 = pairs.map(|(anew, before)| (anew - before).powi(2)).sum();
            if moves >= moved {
                break;
            }
            (carried, moved) = (anew, moves);
        }
        carried
    }

    /// What joints carry that bend under `before`; stiff ones where nothing is said.
    fn carried(&self, session: &Session, state: &State, compliances: &[f64], before: Option<&Carried>) -> Carried {
        let chain = &session.robot.chain;
        let (mut dynamics, still) = (InverseDynamics::new(chain), vec![0.0; chain.joint_count()]);
        let mut bodies: Option<(Option<usize>, Vec<f64>)> = None;
        let torques: Vec<Vec<f64>> = self
            .all()
            .enumerate()
            .map(|(number, (pose, moment))| {
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
                dynamics.torque.clone()
            })
            .collect();
        let sum = |range: &Range<usize>, weights: &[f64]| -> Vec<f64> {
            let of_joint = |joint: usize| torques[range.clone()].iter().zip(weights).map(|(t, w)| w * t[joint]).sum();
            (0..chain.joint_count()).map(of_joint).collect()
        };
        let of_moment = |(torque, own): (&Vec<f64>, &Derivatives)| {
            [torque.clone(), sum(&own.moments, &own.first), sum(&own.moments, &own.second)]
        };
        torques.iter().zip(&self.derivatives).map(of_moment).collect()
    }

    /// The session as if its positions had been read beyond joints that bend by these compliances under what they carry.
    fn session_read_beyond(&self, session: &Session, state: &State, compliances: &[f64], carried: &Carried) -> Session {
        let of_stretch = |(stretch, first): (&Arc<[MotionSample]>, &usize)| -> Arc<[MotionSample]> {
            let moments = stretch.iter().zip(&carried[*first..]);
            moments.map(|(moment, carried)| read_beyond(moment, state, compliances, carried)).collect()
        };
        let stretches: Vec<Arc<[MotionSample]>> = self.stretches.iter().zip(&self.firsts).map(of_stretch).collect();
        let mut session = session.clone();
        for (pose, seen) in session.poses.iter_mut().zip(&self.seen) {
            let Some(course) = &mut pose.course else { continue };
            let same = |(number, read): (&usize, &WeighedStretch)| WeighedStretch {
                moments: Arc::clone(&stretches[*number]),
                weights: read.weights.clone(),
            };
            let stretches = seen.iter().zip(&course.stretches).map(same).collect();
            *course = Arc::new(Course { stretches, kept: Kept::default() });
        }
        session
    }
}

/// What position sensors would read beyond joints that bend under what they carry.
fn read_beyond(moment: &MotionSample, state: &State, compliances: &[f64], carried: &[Vec<f64>; 3]) -> MotionSample {
    let added = |read: &[f64], by: &[f64]| {
        let joints = read.iter().zip(by).zip(compliances.iter().zip(&state.sensors));
        joints.map(|((read, by), (compliance, sensor))| read + compliance * by / sensor[POSITION_GAIN]).collect()
    };
    let [torque, first, second] = carried;
    MotionSample {
        time: moment.time,
        position: added(&moment.position, torque),
        velocity: added(&moment.velocity, first),
        acceleration: added(&moment.acceleration, second),
    }
}

const POSITION_GAIN: usize = SensorParameter::PositionGain as usize;
const POSITION_OFFSET: usize = SensorParameter::PositionOffset as usize;

/// Of joints, rad or m, whose position sensors read this.
fn coordinates(state: &State, positions: &[f64]) -> Vec<f64> {
    let offsets = state.sensors.iter().map(|sensor| sensor[POSITION_OFFSET]);
    of_joints(state, positions).into_iter().zip(offsets).map(|(turned, offset)| turned + offset).collect()
}

/// Velocities or accelerations of joints whose position readings have these.
fn of_joints(state: &State, rates: &[f64]) -> Vec<f64> {
    rates.iter().zip(&state.sensors).map(|(rate, sensor)| sensor[POSITION_GAIN] * rate).collect()
}

/// Of each of some moments at these times, s, in runs: a run ends where the next step is another than usual, and before the moments `changes`.
fn derivatives(times: &[f64], changes: &[usize]) -> Vec<Derivatives> {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let follows = |moment: usize| {
        let step = times[moment] - times[moment - 1];
        (step - usual).abs() < UNEVEN * usual && !changes.contains(&moment)
    };
    let mut all = Vec::with_capacity(times.len());
    let mut first = 0;
    for end in 1..=times.len() {
        if end == times.len() || !follows(end) {
            all.extend((first..end).map(|moment| derivatives_at(times, first..end, moment)));
            first = end;
        }
    }
    all
}

/// Those of the polynomial that is nearest to the moments of a run next to one: with `x_k` the times of these beside it and `V_kp = x_k^p`, the rows of
/// `(VᵀV)⁻¹ Vᵀ` for the first and the second power, times one and two.
fn derivatives_at(times: &[f64], run: Range<usize>, moment: usize) -> Derivatives {
    let count = run.len().min(FOLLOWED);
    let first = moment.saturating_sub(FOLLOWED / 2).clamp(run.start, run.end - count);
    let moments = first..first + count;
    let none = Derivatives { moments: moments.clone(), first: vec![0.0; count], second: vec![0.0; count] };
    if count < 3 {
        return none;
    }
    let unit = (times[moments.end - 1] - times[first]) / (count - 1) as f64;
    let powers = DMatrix::from_fn(count, DEGREE.min(count - 1) + 1, |place, power| {
        ((times[first + place] - times[moment]) / unit).powi(power as i32)
    });
    let Some(nearest) = (powers.transpose() * &powers).try_inverse().map(|inverse| inverse * powers.transpose()) else {
        return none;
    };
    let row = |power: usize, times: f64| nearest.row(power).iter().map(|weight| times * weight).collect();
    Derivatives { moments, first: row(1, 1.0 / unit), second: row(2, 2.0 / (unit * unit)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a quartic they are exact, at the ends of a run, too; no run reaches over a gap, over time that goes back or hardly goes on, or into another load.
    #[test]
    fn torques_are_differentiated_within_their_run() {
        let step = 0.02;
        let times: Vec<f64> = (0..60)
            .map(|k| match k {
                0..14 => step * f64::from(k),
                14..26 => step * f64::from(k) + 0.5,
                26..34 => step * f64::from(k - 26),
                34..40 => step * f64::from(k - 26) + 0.3,
                _ => step * f64::from(k - 27) + 0.301,
            })
            .collect();
        let value = |t: f64| 0.3 - 2.0 * t + 5.0 * t * t - 7.0 * t.powi(3) + 11.0 * t.powi(4);
        let first = |t: f64| -2.0 + 10.0 * t - 21.0 * t * t + 44.0 * t.powi(3);
        let second = |t: f64| 10.0 - 42.0 * t + 132.0 * t * t;
        let all = derivatives(&times, &[50]);
        let run = |moment: usize| {
            [0..14, 14..26, 26..34, 34..40, 40..50, 50..60].into_iter().find(|run| run.contains(&moment)).unwrap()
        };
        for (moment, Derivatives { moments, first: by_first, second: by_second }) in all.iter().enumerate() {
            let run = run(moment);
            assert!(moments.start >= run.start && moments.end <= run.end && moments.contains(&moment), "{moments:?}");
            assert_eq!(moments.len(), run.len().min(FOLLOWED));
            let sum = |weights: &[f64]| -> f64 { moments.clone().zip(weights).map(|(k, w)| w * value(times[k])).sum() };
            let (found, expected) = ([sum(by_first), sum(by_second)], [first(times[moment]), second(times[moment])]);
            assert!((found[0] - expected[0]).abs() < 1e-8, "{moment}: {found:?} {expected:?}");
            assert!((found[1] - expected[1]).abs() < 1e-6, "{moment}: {found:?} {expected:?}");
        }
    }

    #[test]
    fn two_moments_tell_no_derivative() {
        for Derivatives { first, second, .. } in derivatives(&[0.0, 0.1], &[]) {
            assert_eq!((first, second), (vec![0.0; 2], vec![0.0; 2]));
        }
    }
}
