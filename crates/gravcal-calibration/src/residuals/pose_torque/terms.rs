//! What sensors beyond the affine ones add to the residual and its derivatives.
//!
//! ```text
//!     ∂y_i/∂τ_j = k_i [i = j] + Σ_p a_p ∂φ_p/∂τ_j,   ∂y_i/∂a_p = φ_p  (own),   ∂y_i/∂a_p = (∂y_i/∂o_j) ψ_p(q_j)  (of position j)
//! ```

use gravcal_recording::Conditions;

use super::PoseTorque;
use super::model::sensor_column;
use crate::parameter::Quantity;
use crate::sensors::SensorTerms;
use gravcal_kinematics::GravityTorque;

/// The terms of all sensors, and where their parameters are stored.
#[derive(Debug)]
pub(super) struct Terms {
    functions: SensorTerms,
    joints: usize,
    /// First stored column: that of the first term.
    column: usize,
}

impl Terms {
    pub fn new(functions: SensorTerms, joints: usize, column: usize) -> Terms {
        Terms { functions, joints, column }
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// What position sensors add to the coordinates.
    pub fn add_to_coordinates(&self, position: &[f64], x: &[f64], coordinates: &mut [f64]) {
        let values = &x[self.column..];
        for (place, joint, function) in self.functions.of_positions() {
            coordinates[joint] += values[place] * function.value(position[joint]);
        }
    }

    /// What the torque sensor of a joint adds to its reading.
    pub fn reading(&self, joint: usize, torque: &[f64], conditions: &Conditions, x: &[f64]) -> f64 {
        let values = &x[self.column..];
        let of_source = |source: Option<usize>| source.map_or(0.0, |source| torque[source]);
        let own = self.functions.of_torque(joint);
        own.map(|(place, function)| values[place] * function.value(of_source(function.source()), conditions)).sum()
    }

    /// By which torques, beyond its gain, a joint's reading changes, and how much.
    fn slopes<'s>(
        &'s self,
        joint: usize,
        torque: &'s [f64],
        x: &'s [f64],
    ) -> impl Iterator<Item = (usize, f64)> + use<'s> {
        let values = &x[self.column..];
        self.functions.of_torque(joint).filter_map(move |(place, function)| {
            let source = function.source()?;
            Some((source, values[place] * function.slope(torque[source])))
        })
    }

    /// Stored columns that a joint's reading touches by its terms, and joints whose torque it reads besides its own.
    pub fn touched(&self, joint: usize) -> (Vec<usize>, Vec<usize>) {
        let own = || self.functions.of_torque(joint);
        let positions = self.functions.of_positions().map(|(place, _, _)| self.column + place);
        let columns = own().map(|(place, _)| self.column + place).chain(positions).collect();
        (columns, own().filter_map(|(_, function)| function.source()).filter(|source| *source != joint).collect())
    }
}

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
