//! Joints that carry no gravity: their axis is parallel to it in every pose.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use super::variables::State;

/// A joint is idle where its axis is within this angle of gravity, rad.
const IDLE_ANGLE: f64 = 0.05;

/// By joint, whether it is idle at the given values: it, and those that mimic it.
pub(crate) fn idle_joints(session: &Session, state: &State) -> Vec<bool> {
    let chain = &session.robot.chain;
    let gravity = Vector3::from(state.gravity);
    let mut idle: Vec<bool> = chain.movers().iter().map(|mover| mover.kind == JointKind::Revolute).collect();
    for pose in &session.poses {
        if !idle.contains(&true) {
            break;
        }
        let axes = chain.axes(&session.terms.coordinates(&pose.position, &pose.conditions, state));
        for (idle, axis) in idle.iter_mut().zip(axes) {
            *idle &= gravity.cross(&Vector3::from(axis)).norm() < IDLE_ANGLE * gravity.norm();
        }
    }
    (0..session.joints.len()).map(|joint| chain.links_of(joint).all(|link| idle[link])).collect()
}
