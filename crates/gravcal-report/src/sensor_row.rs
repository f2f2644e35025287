//! How a sensor parameter stands in a table: by joint, angles in degrees.

/// The unit in which a table shows a quantity of this unit, and the factor to it. Files stay in rad.
pub(crate) fn shown_unit(unit: &str) -> (&str, f64) {
    match unit {
        "rad" => ("deg", 180.0 / std::f64::consts::PI),
        other => (other, 1.0),
    }
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
    fn only_angles_change_their_unit() {
        let (unit, factor) = shown_unit("rad");
        assert_eq!((unit, factor * std::f64::consts::PI), ("deg", 180.0));
        assert_eq!(shown_unit("rad/count"), ("rad/count", 1.0));
        assert_eq!(shown_unit("m"), ("m", 1.0));
    }

    #[test]
    fn a_joint_may_have_points_in_its_name() {
        assert_eq!(split_name("arm.joint1.torque_gain"), ("arm.joint1", "torque_gain"));
        assert_eq!(split_name("gravity"), ("", "gravity"));
    }
}
