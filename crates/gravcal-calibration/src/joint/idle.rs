//! Joints that carry no gravity: their axis is parallel to it in every pose.

use gravcal_kinematics::JointKind;

use super::Unknowns;
use crate::axis_frames::AxisFrames;
use crate::session::Session;

/// A joint is idle where its axis is within this angle of gravity, rad.
const IDLE_ANGLE: f64 = 0.05;

/// By joint, whether it is idle at the given values.
pub(crate) fn idle_joints(session: &Session, unknowns: &Unknowns) -> Vec<bool> {
    let frames = AxisFrames::new(&session.robot.chain.axis_rotations());
    let idle = |joint: usize| {
        session.poses.iter().all(|pose| {
            let coordinates = session.terms.coordinates(&pose.position, unknowns);
            let gravity = frames.gravity(&unknowns.gravity, &coordinates[..joint]).value;
            gravity.x.hypot(gravity.y) < IDLE_ANGLE * gravity.norm()
        })
    };
    let joints = session.robot.chain.joints().iter().enumerate();
    joints.map(|(index, joint)| joint.kind == JointKind::Revolute && idle(index)).collect()
}
