//! What tilting the base would bring to the first joint.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use super::hypothetical::Hypothetical;
use super::report::{TiltReport, TiltedGain};
use crate::joint::EstimateError;

/// Angles between base and gravity at which the first joint is judged, degrees.
const TILTS_DEG: [f64; 5] = [1.0, 2.0, 5.0, 10.0, 20.0];
/// Below this angle between gravity and the first axis the effect of a tilt is told, rad.
const NEARLY_UPRIGHT: f64 = 0.1;

/// Nothing of a robot without a joint on which all others hang, or without joints.
pub(super) fn tilts(now: &Hypothetical) -> Result<Vec<TiltReport>, EstimateError> {
    if now.session.robot.chain.root_joint().is_none() {
        return Ok(Vec::new());
    }
    let (axis, gravity) = (first_axis(&now.session), Vector3::from(now.values.gravity));
    if gravity.cross(&axis).norm() / gravity.norm() > NEARLY_UPRIGHT {
        return Ok(Vec::new());
    }
    let along = gravity.norm() * gravity.dot(&axis).signum() * axis;
    let tilt = |tilt_deg: &f64| {
        let mut hypothetical = now.clone();
        hypothetical.values.gravity = turned_from(along, axis, tilt_deg.to_radians()).into();
        let verdict = hypothetical.judge()?;
        let gain = |quantity: SensorParameter| {
            let name = quantity.name(&now.session.robot.chain.joints()[0].name);
            let std = verdict.of(&name).and_then(|gain| gain.predicted_std);
            let relative_std = std.map(|std| std / now.values.sensors[0][quantity as usize].abs());
            TiltedGain { determined: verdict.determines(&name), relative_std }
        };
        Ok(TiltReport {
            tilt_deg: *tilt_deg,
            torque_gain: gain(SensorParameter::TorqueGain),
            position_gain: gain(SensorParameter::PositionGain),
        })
    };
    TILTS_DEG.iter().map(tilt).collect()
}

/// Axis of the first joint in base coordinates, of unit length.
pub(super) fn first_axis(session: &Session) -> Vector3<f64> {
    Vector3::from(session.robot.chain.axis_rotations()[0].map(|row| row[2]))
}

/// Gravity turned by an angle, rad, away from the axis; where it is along the axis, towards any side, which makes little
/// difference; where it is across the axis, towards it.
pub(super) fn turned_from(gravity: Vector3<f64>, axis: Vector3<f64>, angle: f64) -> Vector3<f64> {
    let small = 1e-6 * gravity.norm();
    let along = gravity.dot(&axis);
    let across = gravity - along * axis;
    let side = match (across.norm() > small, along.abs() > small) {
        (true, true) => across,
        (true, false) => axis,
        (false, _) => axis.cross(&Vector3::new(axis.y, axis.z, axis.x + 0.5)),
    };
    let outward = (side - side.dot(&gravity) / gravity.norm_squared() * gravity).normalize();
    angle.cos() * gravity + angle.sin() * gravity.norm() * outward
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_turns_by_the_angle_away_from_the_axis() {
        let axis = Vector3::z();
        for gravity in [Vector3::new(0.0, 0.0, -9.8), Vector3::new(3.0, 0.0, -9.0), Vector3::new(0.0, 9.8, 0.0)] {
            let turned = turned_from(gravity, axis, 0.1);
            assert!((turned.norm() - gravity.norm()).abs() < 1e-12);
            assert!((turned.angle(&gravity) - 0.1).abs() < 1e-9);
            let away = turned.cross(&axis).norm() > gravity.cross(&axis).norm();
            assert!(away || gravity.z == 0.0, "{turned}");
        }
    }
}
