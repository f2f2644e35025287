//! `frame = "base"`: wrenches that a driver gives in the base's frame, turned back into the sensor's as they are read.
//!
//! ```text
//!     f_base = R_s f,    n_base = R_s n,    R_s = R R_k(θ) R_m
//! ```
//!
//! `R_k` is the rotation of the sensor's link at nominal joint angles, which are those that the driver turns by; or `R` that of a
//! body without joints; `R_m` that of the mounting. Forces and moments are turned, not moved: moments are about the sensor's origin
//! either way. Gains and biases are those of what the sensor itself reads, `f = K u + b` in its own frame.
//!
//! Noise of the same size along all three axes is the same in either frame. Where it differs, each axis has the standard deviation
//! that follows for it, and that the three then share errors is not heeded.

use gravcal_recording::Reading;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::robot::Robot;
use gravcal_robot_model::session::{AuxiliarySensor, JointPriors, Pose};
use nalgebra::Matrix3;

/// Turns the readings of a wrist sensor in all poses.
pub(super) fn turn_back(robot: &Robot, joints: &[JointPriors], instrument: &AuxiliarySensor, poses: &mut [Pose]) {
    for pose in poses {
        let rotation = sensor_in_base(robot, joints, instrument, pose);
        let (triples, _) = pose.instruments[instrument.readings()].as_chunks_mut::<3>();
        triples.iter_mut().for_each(|triple| *triple = turned_back(&rotation, triple));
    }
}

/// `R_s` in one pose.
fn sensor_in_base(robot: &Robot, joints: &[JointPriors], instrument: &AuxiliarySensor, pose: &Pose) -> Matrix3<f64> {
    let nominal = |joint: &JointPriors, quantity| joint.of(quantity).nominal;
    let coordinate = |(joint, reading): (&JointPriors, &f64)| {
        nominal(joint, SensorParameter::PositionGain) * reading + nominal(joint, SensorParameter::PositionOffset)
    };
    let coordinates: Vec<f64> = joints.iter().zip(&pose.position).map(coordinate).collect();
    let sensor = pose.link_frames(&robot.chain, &coordinates)[instrument.link].compose(&instrument.mounting);
    let rotation = sensor.rotation();
    Matrix3::from_fn(|i, j| rotation[i][j])
}

/// `R_sᵀ` times three readings; none where one of them is missing.
fn turned_back(rotation: &Matrix3<f64>, readings: &[Option<Reading>; 3]) -> [Option<Reading>; 3] {
    let [Some(x), Some(y), Some(z)] = readings else { return [None; 3] };
    let along = |axis: usize| {
        let parts = || rotation.column(axis).iter().copied().zip([x, y, z]).collect::<Vec<_>>();
        let value = parts().into_iter().map(|(share, reading)| share * reading.value).sum();
        let stds = parts().into_iter().map(|(share, reading)| reading.std.map(|std| share * std));
        let std = stds.collect::<Option<Vec<f64>>>().map(|stds| stds.into_iter().fold(0.0, f64::hypot));
        Some(Reading { value, std })
    };
    [0, 1, 2].map(along)
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::session::AuxiliarySensorKind;

    use super::*;
    use crate::testing::sarcos_with_instruments;

    #[test]
    fn what_a_driver_turned_by_nominal_angles_comes_back() {
        let session = sarcos_with_instruments().session(0);
        let wrist = &session.instruments[0];
        assert_eq!((wrist.kind, wrist.first_reading), (AuxiliarySensorKind::ForceTorque, 0));
        let mut poses = session.poses.clone();
        for pose in &mut poses {
            let coordinate = |(joint, reading): (&JointPriors, &f64)| {
                joint.of(SensorParameter::PositionGain).nominal * reading
                    + joint.of(SensorParameter::PositionOffset).nominal
            };
            let coordinates: Vec<f64> = session.joints.iter().zip(&pose.position).map(coordinate).collect();
            let sensor = session.robot.chain.forward(&coordinates)[wrist.link].compose(&wrist.mounting);
            for triple in pose.instruments[wrist.readings()].as_chunks_mut::<3>().0 {
                let own = triple.map(|reading| reading.unwrap().value);
                let turned = sensor.rotate_vector(own);
                triple.iter_mut().zip(turned).for_each(|(reading, value)| reading.as_mut().unwrap().value = value);
            }
        }
        turn_back(&session.robot, &session.joints, wrist, &mut poses);
        for (own, back) in session.poses.iter().zip(&poses) {
            for (own, back) in own.instruments.iter().flatten().zip(back.instruments.iter().flatten()) {
                assert!((own.value - back.value).abs() < 1e-9 * own.value.abs().max(1.0), "{own:?} {back:?}");
                assert!((own.std.unwrap() / back.std.unwrap() - 1.0).abs() < 1e-12);
            }
        }
    }
}
