//! The row of a reading whose sensor has terms beyond the affine ones.

use gravcal_dynamics::GravityTorque;

use super::model::{LoadState, sensor_column};
use super::residual::PoseTorque;
use super::terms::{Slopes, Terms};
use crate::parameter::SensorParameter;

impl PoseTorque {
    /// One row of the Jacobian. `slopes`: of this reading, by torques with what follows from [`Slopes::with_compliance`]; `scratch`: as
    /// long as a row.
    pub(super) fn fill_row_with_terms(
        &self,
        (terms, slopes): (&Terms, &Slopes),
        gain: f64,
        joint: usize,
        (torque, load): (&GravityTorque, Option<LoadState>),
        row: &mut [f64],
        scratch: &mut Vec<f64>,
    ) {
        let sensor = |quantity, joint| sensor_column(terms.joints, quantity, joint);
        let own = terms.torques(joint).contains(&joint).then(|| slopes.by_torque[joint]);
        row.fill(0.0);
        let (base, by_terms) = row.split_at_mut(terms.column);
        self.fill_row(gain + own.unwrap_or(0.0), joint, torque, load, base);
        for source in terms.torques(joint).iter().copied().filter(|source| *source != joint) {
            scratch.clear();
            scratch.resize(base.len(), 0.0);
            self.fill_row(slopes.by_torque[source], source, torque, load, scratch);
            // The gain and bias of the other sensor have no part in this reading.
            scratch[sensor(SensorParameter::TorqueGain, source)] = 0.0;
            scratch[sensor(SensorParameter::TorqueBias, source)] = 0.0;
            base.iter_mut().zip(&*scratch).for_each(|(entry, by_source)| *entry += by_source);
        }
        for moved in terms.coordinates(joint) {
            let by_coordinate = slopes.by_coordinate[*moved];
            base[sensor(SensorParameter::PositionOffset, *moved)] += by_coordinate;
            base[sensor(SensorParameter::PositionGain, *moved)] += by_coordinate * self.position[*moved];
        }
        for term in terms.of_torque(joint) {
            by_terms[term.places.clone()].copy_from_slice(&slopes.by_parameter[term.places.clone()]);
        }
        for term in terms.functions.of_positions() {
            let by_offset = base[sensor(SensorParameter::PositionOffset, term.joint)];
            for place in term.places.clone() {
                by_terms[place] = by_offset * slopes.by_parameter[place];
            }
        }
    }
}
