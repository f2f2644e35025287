//! Gains of the other sign than declared: mirror images of a solution, not other answers.
//!
//! Nothing but the declaration tells some signs: gravity and all gains of a sensor negative read the same. And an axis has two ends: the
//! joint before it half a turn on puts the one where the other was, and with the reading, the torque and the offset of the joint
//! counted about that, negative all three, nothing stands or weighs otherwise,
//!
//! ```text
//!     Rot_z(π) Rot_x(±π/2) Rot_z(θ) = Rot_x(±π/2) Rot_z(−θ) Rot_y(π),
//! ```
//!
//! where masses and moments beyond are those seen from a frame half a turn about its `y` on. Of such images the one that reads as
//! declared is the answer. Where the readings say little, such an end may be no exact image: then what explains them with those sensors at their
//! nominal values is tried, too. Where joints stand, or hardly carry anything, their gains say nothing of such an image, and an offset tells it:
//! it lies half a turn from its nominal value.

use std::f64::consts::PI;

use gravcal_dynamics::{BodyInertia, JointKind, Transform};
use gravcal_identification::{DECISIVE, FIRST_ITERATIONS, SolveEnvironment, Symmetry};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{Load, Session};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::{solve_built, with_constants_anew};
use crate::joint::starting::start::start_around;
use crate::joint::variables::State;

/// Share of its nominal value below which a gain has no sign: it may be zero.
const HAS_SIGN: f64 = 0.1;
/// What costs so many times as much as the solution after its first iterations is no image of it.
const OUT_OF_REACH: f64 = 3.0;

/// The free gains that have the other sign than declared.
pub(in crate::joint) fn turned_gains(session: &Session, values: &State) -> Vec<ParameterId> {
    let joints = 0..session.joints.len();
    let sensors = joints.flat_map(|joint| {
        [SensorParameter::TorqueGain, SensorParameter::PositionGain].map(|q| ParameterId::Sensor(joint, q))
    });
    let instruments = session.instruments.iter().flat_map(|instrument| instrument.gain_parameters());
    let turned = |id: &ParameterId| {
        let nominal = session.nominal(*id);
        session.fixed(*id).is_none() && values.value(*id) * nominal < -HAS_SIGN * nominal * nominal
    };
    sensors.chain(instruments.map(ParameterId::Further)).filter(turned).collect()
}

/// The free offsets of joints that turn which lie nearer to their nominal values half a turn on.
pub(in crate::joint) fn far_offsets(session: &Session, values: &State) -> Vec<ParameterId> {
    let is_far = |offset: &ParameterId| half_turns_off(session, *offset, values.value(*offset)).rem_euclid(2.0) == 1.0;
    free_offsets(session).map(|(_, offset)| offset).filter(is_far).collect()
}

/// How many free gains and offsets are as they are not declared.
pub(in crate::joint) fn not_as_declared(session: &Session, values: &State) -> usize {
    turned_gains(session, values).len() + far_offsets(session, values).len()
}

/// Joint and free offset of each joint that turns.
fn free_offsets(session: &Session) -> impl Iterator<Item = (usize, ParameterId)> {
    let joints = session.robot.chain.joints().iter().enumerate();
    let turning = joints.filter(|(_, joint)| joint.kind == JointKind::Revolute);
    let offsets = turning.map(|(joint, _)| (joint, ParameterId::Sensor(joint, SensorParameter::PositionOffset)));
    offsets.filter(|(_, offset)| session.fixed(*offset).is_none())
}

/// By how many half turns an offset of this value is off its nominal value, to the nearest.
fn half_turns_off(session: &Session, offset: ParameterId, value: f64) -> f64 {
    ((value - session.nominal(offset)) / PI).round()
}

/// Where gains or offsets are as they are not declared: the mirror image about the axes of these joints.
pub(super) struct TurnedAxes<'a> {
    pub session: &'a Session,
}

impl Symmetry for TurnedAxes<'_> {
    type Solution = Solved;
    type Start = State;
    type Error = EstimateError;

    fn name(&self) -> &'static str {
        "axes the other way round"
    }

    fn images(&self, solved: &Solved, _: &SolveEnvironment<'_>) -> Result<Vec<State>, EstimateError> {
        let (session, found) = (self.session, solved.state(&State::nominal(self.session)));
        let nominal = sensors_as_declared(session, &found);
        let nominal = nominal.map(|sensors| start_around(session, solved.readings(), &sensors)).transpose()?;
        Ok(turned_axes(session, &found).into_iter().chain(nominal).collect())
    }

    /// An image that leads nowhere is none, nor is one that has no fewer gains and offsets as they are not declared.
    fn follow(
        &self,
        image: State,
        solved: &Solved,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Solved>, EstimateError> {
        let built = build_with_constraints(self.session, solved.readings(), &image)?.with_loss(solved.built.loss)?;
        let nominal = State::nominal(self.session);
        let roughly = environment.roughly().within(FIRST_ITERATIONS);
        let Ok(near) = solve_built(built.clone(), &roughly) else { return Ok(None) };
        if near.estimate.cost > OUT_OF_REACH * solved.estimate.cost + DECISIVE {
            return Ok(None);
        }
        let built = built.starting_at(self.session, &near.state(&nominal));
        let Ok(other) = solve_built(built, environment) else { return Ok(None) };
        let [wrong, before] = [&other, solved].map(|solution| not_as_declared(self.session, &solution.state(&nominal)));
        Ok((wrong < before && other.estimate.termination.converged()).then_some(other))
    }

    fn height(&self, solved: &Solved) -> f64 {
        solved.estimate.cost
    }

    fn is_declared(&self) -> bool {
        true
    }

    /// Joints that bend, or are displaced, do something else there.
    fn replaced(
        &self,
        solved: Solved,
        end: Solved,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let end = with_constants_anew(self.session, end, environment)?;
        Ok(Solved { sign_known: solved.sign_known, ..end })
    }
}

/// Turned back: the axes of joints with two turned gains, where an offset is far off all turned gains, and free offsets by half turns to near
/// their nominal values; nothing where there is no such joint.
fn turned_axes(session: &Session, found: &State) -> Option<State> {
    let (gains, far) = (turned_gains(session, found), !far_offsets(session, found).is_empty());
    let has = |joint: usize, quantity: SensorParameter| gains.contains(&ParameterId::Sensor(joint, quantity));
    let both = |joint: usize| has(joint, SensorParameter::TorqueGain) && has(joint, SensorParameter::PositionGain);
    // Moments by sweep have no frames that could be turned.
    if !far && !(0..session.joints.len()).any(both) || !found.sweep_moments.is_empty() {
        return None;
    }
    let mut image = found.clone();
    let is_turned_back = |gain: &&ParameterId| matches!(gain, ParameterId::Sensor(joint, _) if far || both(*joint));
    gains.iter().filter(is_turned_back).for_each(|gain| *image.value_mut(*gain) *= -1.0);
    for (joint, offset) in free_offsets(session) {
        // An offset is counted about its axis, as the readings are.
        let sign = if has(joint, SensorParameter::PositionGain) && (far || both(joint)) { -1.0 } else { 1.0 };
        let value = sign * found.value(offset);
        *image.value_mut(offset) = value - PI * half_turns_off(session, offset, value);
    }
    Some(standing_alike(session, found, image))
}

/// The solution with those gains and offsets at their nominal values that are not as declared; nothing where all gains are.
fn sensors_as_declared(session: &Session, found: &State) -> Option<State> {
    let turned = turned_gains(session, found);
    let mut sensors = found.clone();
    for id in turned.iter().copied().chain(far_offsets(session, found)) {
        *sensors.value_mut(id) = session.nominal(id);
    }
    (!turned.is_empty()).then_some(sensors)
}

/// The image with masses and placements where they are in the first pose of what it is the image of, seen from its frames.
fn standing_alike(session: &Session, found: &State, image: State) -> State {
    let Some(pose) = session.poses.first() else { return image };
    let frames =
        |values| session.robot.chain.forward(&session.terms.coordinates(&pose.position, &pose.conditions, values));
    let from_before = |(before, after): (&Transform, &Transform)| after.inverse().compose(before);
    let moved: Vec<Transform> = frames(found).iter().zip(&frames(&image)).map(from_before).collect();
    let inertia = |(&[mass, x, y, z], moved): (&[f64; 4], &Transform)| {
        let (turned, shift) = (moved.rotate_vector([x, y, z]), moved.translation());
        let [x, y, z] = [0, 1, 2].map(|axis| turned[axis] + mass * shift[axis]);
        [mass, x, y, z]
    };
    let placement = |(position, load): (&[f64; 3], &Load)| match (load.position, load.position_std) {
        (Some(_), None) => *position,
        _ => moved[load.link].transform_point(*position),
    };
    let unknown = session.loads.iter().filter(|load| load.is_unknown()).map(|load| &moved[load.link]);
    let with_payload = |(body, moved): (&[f64; 10], &Transform)| {
        BodyInertia::from_parameters(*body).in_frame(&moved.inverse()).parameters()
    };
    State {
        with_payloads: found.with_payloads.iter().zip(unknown).map(with_payload).collect(),
        inertia: found.inertia.iter().zip(&moved).map(inertia).collect(),
        loads: found.loads.iter().zip(&session.loads).map(placement).collect(),
        ..image
    }
}

#[cfg(test)]
mod tests {
    use gravcal_identification::settle;
    use gravcal_session::simulation::Run;
    use gravcal_solvers::LevenbergMarquardt;

    use super::*;
    use crate::joint::solving::solve_from::solve_from;
    use crate::joint::{Signals, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    #[test]
    fn an_axis_the_other_way_round_is_turned_back_at_no_cost() {
        let simulation = sarcos_shoulder();
        let (session, truth) = (simulation.session(0), simulation.truth);
        // The second joint half a turn on turns the axis of the third round.
        let mut mirror = truth.clone();
        mirror.sensors[1][3] += PI;
        [0, 2].into_iter().for_each(|parameter| mirror.sensors[2][parameter] *= -1.0);
        let mirror = standing_alike(&session, &truth, mirror);
        let solver = LevenbergMarquardt::default();
        let environment = SolveEnvironment::new(&solver, &|_: &str| {});
        let solved = solve_from(&session, &select(&session, Signals::All), mirror, &environment).unwrap();
        let nominal = State::nominal(&session);
        let both = [SensorParameter::TorqueGain, SensorParameter::PositionGain]
            .map(|quantity| ParameterId::Sensor(2, quantity));
        assert_eq!(turned_gains(&session, &solved.state(&nominal)), both);
        let cost = solved.estimate.cost;
        assert!(cost < 800.0, "the mirror image explains the readings: {cost}");

        let declared = settle(solved, &[&TurnedAxes { session: &session }], &environment).unwrap().solution;
        let found = declared.state(&nominal);
        assert_eq!(turned_gains(&session, &found), []);
        assert!((declared.estimate.cost / cost - 1.0).abs() < 1e-6, "{} {cost}", declared.estimate.cost);
        for (found, truth) in found.sensors.iter().zip(&truth.sensors) {
            assert!(
                (found[0] / truth[0] - 1.0).abs() < 0.02 && (found[3] - truth[3]).abs() < 0.02,
                "{found:?} {truth:?}"
            );
        }
    }

    #[test]
    fn before_a_joint_that_stands_an_offset_half_a_turn_off_is_turned_back() {
        let mut simulation = sarcos_shoulder();
        for run in &mut simulation.runs {
            let Run::Sweep { swept, .. } = run else { panic!("all are sweeps") };
            *swept = (*swept).min(1);
        }
        let (session, truth) = (simulation.session(0), simulation.truth);
        // Where the third joint stands, its position gain says nothing of how its axis points.
        let mut mirror = truth.clone();
        mirror.sensors[1][3] += PI;
        mirror.sensors[2][0] *= -1.0;
        let mirror = standing_alike(&session, &truth, mirror);
        let nominal = State::nominal(&session);
        let readings = select(&session, Signals::All);
        let (half_a_turn_off, declared) = with_environment(|w| {
            let solved = solve_from(&session, &readings, mirror, w)?;
            let before = (far_offsets(&session, &solved.state(&nominal)), solved.estimate.cost);
            Ok::<_, EstimateError>((before, settle(solved, &[&TurnedAxes { session: &session }], w)?.solution))
        })
        .unwrap();
        assert_eq!(half_a_turn_off.0, [ParameterId::Sensor(1, SensorParameter::PositionOffset)]);
        let found = declared.state(&nominal);
        assert_eq!((far_offsets(&session, &found), turned_gains(&session, &found)), (vec![], vec![]));
        assert!((declared.estimate.cost - half_a_turn_off.1).abs() < 0.1, "{half_a_turn_off:?} {declared:?}");
    }
}
