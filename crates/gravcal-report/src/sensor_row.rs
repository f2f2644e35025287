//! How a sensor parameter stands in a table: by joint, angles in degrees.

pub(crate) use gravcal_robot_model::number::shown_unit;

/// Whether a parameter is one of a joint's friction, which is no part of its sensor.
pub(crate) fn is_friction(quantity: &str) -> bool {
    ["coulomb_friction", "viscous_friction", "presliding_travel"].contains(&quantity)
}

/// `joint1.torque_gain` as joint and quantity; a name without a point has no joint.
pub(crate) fn split_name(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// Angle between gravity and the base's −z axis, rad: 0 for a base that stands upright.
pub(crate) fn tilt([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).atan2(-z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_may_have_points_in_its_name() {
        assert_eq!(split_name("arm.joint1.torque_gain"), ("arm.joint1", "torque_gain"));
        assert_eq!(split_name("gravity"), ("", "gravity"));
    }
}
