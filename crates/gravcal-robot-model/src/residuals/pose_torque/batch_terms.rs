//! Terms of the sensors of poses that are evaluated in a batch: one pose after the other, between what all compute at once.
//!
//! Every number has the bits that the pose has alone.

use gravcal_dynamics::LANES;

use super::model::sensor_column;
use super::residual::PoseTorque;
use super::terms::{Slopes, Terms};
use crate::parameter::SensorParameter;
use crate::sensors::Moment;

/// What terms of one pose read, and their derivatives.
pub(super) struct Lane {
    /// NaN but for the joint whose reading is evaluated: no term says that it reads another's.
    torque: Vec<f64>,
    coordinates: Vec<f64>,
    slopes: Slopes,
}

/// What terms add to one reading of each pose.
pub(super) struct Further {
    pub value: [f64; LANES],
    /// Derivative by the joint's own torque.
    pub by_torque: [f64; LANES],
}

impl Lane {
    pub fn new(joints: usize) -> Lane {
        Lane { torque: vec![f64::NAN; joints], coordinates: vec![0.0; joints], slopes: Slopes::default() }
    }
}

/// Adds what position sensors do beyond gain and offset to the coordinates, which come as those of affine sensors; keeps derivatives where
/// they are wanted.
pub(super) fn move_joints(
    terms: &Terms,
    poses: &[&PoseTorque; LANES],
    (x, wanted): (&[f64], bool),
    coordinates: &mut [[f64; LANES]],
    lanes: &mut [Lane; LANES],
) {
    lanes.iter_mut().for_each(|own| terms.fit(&mut own.slopes));
    if !(terms.move_joints() || terms.read_coordinates()) {
        return;
    }
    for (lane, (pose, own)) in poses.iter().zip(lanes).enumerate() {
        own.coordinates.iter_mut().zip(&*coordinates).for_each(|(own, all)| *own = all[lane]);
        let read = (pose.position.as_slice(), &pose.conditions);
        terms.add_to_coordinates(read, x, &mut own.coordinates, wanted.then_some(&mut own.slopes));
        coordinates.iter_mut().zip(&own.coordinates).for_each(|(all, own)| all[lane] = *own);
    }
}

/// What terms add to the reading of a joint, whose torques are these. The lanes keep derivatives for [`write`], where they are wanted.
pub(super) fn read(
    terms: &Terms,
    poses: &[&PoseTorque; LANES],
    (joint, torque): (usize, [f64; LANES]),
    (x, wanted): (&[f64], bool),
    lanes: &mut [Lane; LANES],
) -> Further {
    let mut further = Further { value: [0.0; LANES], by_torque: [0.0; LANES] };
    for (lane, (pose, own)) in poses.iter().zip(lanes).enumerate() {
        own.torque[joint] = torque[lane];
        let at = Moment::new(&own.torque, &own.coordinates, &pose.position, &pose.conditions);
        further.value[lane] = terms.reading(joint, &at, x, wanted.then_some(&mut own.slopes));
        if wanted && terms.torques(joint).contains(&joint) {
            further.by_torque[lane] = own.slopes.by_torque[joint];
        }
        own.torque[joint] = f64::NAN;
    }
    further
}

/// Completes the rows of a joint's readings: columns of affine sensors, which have what torques do, and those of terms.
pub(super) fn write(
    terms: &Terms,
    poses: &[&PoseTorque; LANES],
    joint: usize,
    lanes: &[Lane; LANES],
    (row, by_terms): (&mut [[f64; LANES]], &mut [[f64; LANES]]),
) {
    if !(terms.has(joint) || terms.move_joints()) {
        return;
    }
    let sensor = |quantity, joint| sensor_column(terms.joints, quantity, joint);
    for (lane, (pose, Lane { slopes, .. })) in poses.iter().zip(lanes).enumerate() {
        for moved in terms.coordinates(joint) {
            let by_coordinate = slopes.by_coordinate[*moved];
            row[sensor(SensorParameter::PositionOffset, *moved)][lane] += by_coordinate;
            row[sensor(SensorParameter::PositionGain, *moved)][lane] += by_coordinate * pose.position[*moved];
        }
        for place in terms.of_torque(joint).flat_map(|term| term.places.clone()) {
            by_terms[place][lane] = slopes.by_parameter[place];
        }
        for term in terms.functions.of_positions() {
            let by_offset = row[sensor(SensorParameter::PositionOffset, term.joint)][lane];
            for place in term.places.clone() {
                by_terms[place][lane] = by_offset * slopes.by_parameter[place];
            }
        }
    }
}
