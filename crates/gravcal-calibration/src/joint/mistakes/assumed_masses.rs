//! Whether torques of the estimated masses go the way of those that the robot's file assumes.

use gravcal_estimation::in_parallel;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{Pose, ReadingId, Session};

use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// Below this correlation the estimated torques oppose the assumed ones.
pub(super) const OPPOSED: f64 = -0.5;
/// Torques are seen where so many times their noise, squared and summed over the readings, is exceeded: five standard deviations of one moment.
const SEEN: f64 = 25.0;
/// A joint's torques tell of signs where it turns by so much, rad, at least; where it slides they depend on others' turning.
const TURNS: f64 = 0.8;

/// Correlation of the bare arm's gravity torques by estimated and by assumed masses, over the readings, each joint's mean taken away: the
/// weaker of that with the assumed torques at the estimate and of that with those at nominal values, as neither may hang on gravity or
/// offsets that the readings leave open. `None` where no masses are assumed, where gravity may point either way, where no joint turns far
/// enough to tell, or where both disagree.
pub(super) fn agreement(session: &Session, solved: &Solved, state: &State) -> Option<f64> {
    let links = session.robot.chain.links();
    if session.gravity.hemisphere.is_none() || links.iter().any(|link| link.inertia.is_none()) {
        return None;
    }
    let nominal = State::nominal(session);
    let estimated = bare_torques(session, state, state);
    // Looked at once a joint: once a reading would take time with the square of their number.
    let turn_far: Vec<bool> = (0..session.joints.len()).map(|joint| turns_far(session, joint)).collect();
    let of_one_that_turns = |id: &ReadingId| turn_far.get(id.channel) == Some(&true);
    let informative: Vec<ReadingId> = solved.built.rows.iter().copied().filter(of_one_that_turns).collect();
    let noise = |id: &ReadingId| {
        let gain = state.sensors[id.channel][SensorParameter::TorqueGain as usize].abs();
        solved.readings().std(session, *id) / gain
    };
    if !is_seen(&informative, &estimated, noise) {
        return None;
    }
    let with = |values: &State| {
        let assumed = bare_torques(session, values, &nominal);
        is_seen(&informative, &assumed, noise).then(|| correlation(&informative, &estimated, &assumed)).flatten()
    };
    let (here, there) = (with(state)?, with(&nominal)?);
    (here * there > 0.0).then(|| if here.abs() < there.abs() { here } else { there })
}

/// Gravity torques of the bare arm in every pose, N·m, with the masses of one set of values and the angles and gravity of another.
fn bare_torques(session: &Session, at: &State, masses: &State) -> Vec<Vec<f64>> {
    let chain = &session.robot.chain;
    let inertia: Vec<f64> = masses.inertia.iter().flatten().copied().collect();
    let of_pose = |pose: &Pose| {
        let mut torque = vec![0.0; chain.joint_count()];
        chain.gravity_torque(
            &session.terms.coordinates(&pose.position, &pose.conditions, at),
            at.gravity,
            &inertia,
            &mut torque,
        );
        torque
    };
    in_parallel(&session.poses, of_pose)
}

/// Whether a joint turns far over the poses.
fn turns_far(session: &Session, joint: usize) -> bool {
    let angles = || session.poses.iter().filter_map(|pose| pose.position.get(joint).copied());
    let gain = session.nominal(ParameterId::Sensor(joint, SensorParameter::PositionGain)).abs();
    (angles().fold(f64::MIN, f64::max) - angles().fold(f64::MAX, f64::min)) * gain > TURNS
}

/// Whether torques, each joint's mean taken away, are beyond what `noise` of a reading, N·m or N, makes of none.
fn is_seen(informative: &[ReadingId], torques: &[Vec<f64>], noise: impl Fn(&ReadingId) -> f64) -> bool {
    let of_joint = |joint: usize| {
        let own = || informative.iter().filter(move |id| id.channel == joint);
        let mean = own().map(|id| torques[id.pose][joint]).sum::<f64>() / own().count().max(1) as f64;
        own().map(|id| ((torques[id.pose][joint] - mean) / noise(id)).powi(2)).sum::<f64>()
    };
    (0..torques.first().map_or(0, Vec::len)).map(of_joint).sum::<f64>() > SEEN
}

/// Correlation of two sets of torques over these readings, by pose and joint, each joint's mean taken away.
fn correlation(informative: &[ReadingId], first: &[Vec<f64>], second: &[Vec<f64>]) -> Option<f64> {
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    for joint in 0..second.first()?.len() {
        let rows = informative.iter().filter(|id| id.channel == joint);
        let rows: Vec<(f64, f64)> = rows.map(|id| (first[id.pose][joint], second[id.pose][joint])).collect();
        let count = rows.len().max(1) as f64;
        let mean = rows.iter().fold((0.0, 0.0), |sum, (a, b)| (sum.0 + a / count, sum.1 + b / count));
        let sum = |of: fn(f64, f64) -> f64| rows.iter().map(|(a, b)| of(a - mean.0, b - mean.1)).sum::<f64>();
        (aa, ab, bb) = (aa + sum(|a, _| a * a), ab + sum(|a, b| a * b), bb + sum(|_, b| b * b));
    }
    (aa * bb > 0.0).then(|| ab / (aa * bb).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a load's unknown place leaves to the joint about whose upright axis it turns is noise, and opposes nothing.
    #[test]
    fn torques_are_seen_beyond_their_noise_only() {
        let torques: Vec<Vec<f64>> = (0..10).map(|pose| vec![7.0, 0.1 * f64::from(pose % 2)]).collect();
        let ids = |channel: usize| (0..10).map(|pose| ReadingId { pose, channel }).collect::<Vec<_>>();
        assert!(!is_seen(&ids(0), &torques, |_| 1e-3), "a mean is a bias");
        assert!(is_seen(&ids(1), &torques, |_| 0.03) && !is_seen(&ids(1), &torques, |_| 0.04));
    }
}
