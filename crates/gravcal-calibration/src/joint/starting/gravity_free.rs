//! Joints that carry no gravity: their axis is parallel to it in every pose.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::variables::State;

/// A joint is gravity-free where its axis is within this angle of gravity, rad.
const GRAVITY_FREE_ANGLE: f64 = 0.05;

/// By joint, whether it is gravity-free at the given values: it, and those that mimic it.
pub(crate) fn gravity_free_joints(session: &Session, state: &State) -> Vec<bool> {
    let chain = &session.robot.chain;
    let gravity = Vector3::from(state.gravity);
    let mut gravity_free: Vec<bool> = chain.movers().iter().map(|mover| mover.kind == JointKind::Revolute).collect();
    for pose in &session.poses {
        if !gravity_free.contains(&true) {
            break;
        }
        let axes = chain.axes(&session.terms.coordinates(&pose.position, &pose.conditions, state));
        for (gravity_free, axis) in gravity_free.iter_mut().zip(axes) {
            *gravity_free &= gravity.cross(&Vector3::from(axis)).norm() < GRAVITY_FREE_ANGLE * gravity.norm();
        }
    }
    (0..session.joints.len()).map(|joint| chain.links_of(joint).all(|link| gravity_free[link])).collect()
}
