//! One joint of a URDF.

use urdf_rs::{JointLimit, JointType};

use super::error::UrdfError;
use crate::joint::JointKind;
use crate::transform::Transform;

/// What a joint on the way to a tip does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    Fixed,
    Moving(JointKind),
}

/// The motion of a joint on the way to a tip.
///
/// # Errors
///
/// Floating, planar and spherical joints, by name.
pub(super) fn motion(joint: &urdf_rs::Joint) -> Result<Motion, UrdfError> {
    let unsupported = |kind| Err(UrdfError::UnsupportedJoint { joint: joint.name.clone(), kind });
    match joint.joint_type {
        JointType::Fixed => Ok(Motion::Fixed),
        JointType::Revolute | JointType::Continuous => Ok(Motion::Moving(JointKind::Revolute)),
        JointType::Prismatic => Ok(Motion::Moving(JointKind::Prismatic)),
        JointType::Floating => unsupported("floating"),
        JointType::Planar => unsupported("planar"),
        JointType::Spherical => unsupported("spherical"),
    }
}

/// Pose of the joint's frame, which is the child link's frame at coordinate zero, in the parent link's frame.
pub(super) fn origin(joint: &urdf_rs::Joint) -> Result<Transform, UrdfError> {
    let origin = Transform::from_xyz_rpy(joint.origin.xyz.0, joint.origin.rpy.0);
    if !origin.is_finite() {
        return Err(UrdfError::NotFinite { what: format!("origin of joint `{}`", joint.name) });
    }
    Ok(origin)
}

/// The axis, made a unit vector.
pub(super) fn axis(joint: &urdf_rs::Joint) -> Result<[f64; 3], UrdfError> {
    let axis = joint.axis.xyz.0;
    if !axis.iter().all(|value| value.is_finite()) {
        return Err(UrdfError::NotFinite { what: format!("axis of joint `{}`", joint.name) });
    }
    // Divided by the largest component first: neither huge nor tiny axes overflow or vanish when squared.
    let largest = axis.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if largest == 0.0 {
        return Err(UrdfError::ZeroAxis { joint: joint.name.clone() });
    }
    let scaled = axis.map(|value| value / largest);
    let length = scaled.iter().map(|value| value * value).sum::<f64>().sqrt();
    Ok(scaled.map(|value| value / length))
}

/// Lower and upper limit, rad or m.
///
/// None for a continuous joint; where both are zero, which is how a URDF reads that does not state them; and where one
/// side is unbounded (URDF 1.2).
pub(super) fn limits(joint: &urdf_rs::Joint) -> Option<[f64; 2]> {
    let JointLimit { lower, upper, .. } = joint.limit;
    let unstated = lower == 0.0 && upper == 0.0;
    let unbounded = lower.is_infinite() || upper.is_infinite();
    let continuous = joint.joint_type == JointType::Continuous;
    (!continuous && !unstated && !unbounded).then_some([lower, upper])
}
