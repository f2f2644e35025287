//! The row of a reading whose sensor has terms beyond the affine ones.

use gravcal_dynamics::GravityTorque;

use super::model::sensor_column;
use super::residual::PoseTorque;
use super::terms::Terms;
use crate::parameter::Quantity;

impl PoseTorque {
    /// One row of the Jacobian. `scratch`: as long as a row.
    pub(super) fn fill_row_with_terms(
        &self,
        terms: &Terms,
        x: &[f64],
        joint: usize,
        torque: &GravityTorque,
        row: &mut [f64],
        scratch: &mut Vec<f64>,
    ) {
        let sensor = |quantity, joint| sensor_column(terms.joints, quantity, joint);
        let slopes = || terms.slopes(joint, &torque.torque, x);
        let own: f64 = slopes().filter(|(source, _)| *source == joint).map(|(_, slope)| slope).sum();
        row.fill(0.0);
        let (base, by_terms) = row.split_at_mut(terms.column);
        self.fill_row(x[sensor(Quantity::TorqueGain, joint)] + own, joint, torque, base);
        for (source, slope) in slopes().filter(|(source, _)| *source != joint) {
            scratch.clear();
            scratch.resize(base.len(), 0.0);
            self.fill_row(slope, source, torque, scratch);
            // The gain and bias of the other sensor have no part in this reading.
            scratch[sensor(Quantity::TorqueGain, source)] = 0.0;
            scratch[sensor(Quantity::TorqueBias, source)] = 0.0;
            base.iter_mut().zip(&*scratch).for_each(|(entry, by_source)| *entry += by_source);
        }
        for (place, function) in terms.functions.of_torque(joint) {
            let source = function.source().map_or(0.0, |source| torque.torque[source]);
            by_terms[place] = function.value(source, &self.conditions);
        }
        for (place, moved, function) in terms.functions.of_positions() {
            let by_offset = base[sensor(Quantity::PositionOffset, moved)];
            by_terms[place] = by_offset * function.value(self.position[moved]);
        }
    }
}
