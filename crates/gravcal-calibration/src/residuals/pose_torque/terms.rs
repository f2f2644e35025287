//! What sensors beyond the affine ones add to the residual and its derivatives.
//!
//! ```text
//!     ∂y_i/∂τ_j = k_i [i = j] + Σ_p a_p ∂φ_p/∂τ_j,   ∂y_i/∂a_p = φ_p  (own),   ∂y_i/∂a_p = (∂y_i/∂o_j) ψ_p(q_j)  (of position j)
//! ```

use gravcal_recording::Conditions;

use crate::sensors::SensorTerms;

/// The terms of all sensors, and where their parameters are stored.
#[derive(Debug)]
pub(super) struct Terms {
    pub(super) functions: SensorTerms,
    pub(super) joints: usize,
    /// First stored column: that of the first term.
    pub(super) column: usize,
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
    pub(super) fn slopes<'s>(
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
