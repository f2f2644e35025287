//! Joints that mimic others.
//!
//! With `θ = A q + c` the coordinates of all axes, by those `q` of the joints that have one of their own (a row of A holds a
//! multiplier), the potential energy `U(θ(q))` has the derivatives (virtual work)
//!
//! ```text
//!     τ_q = Aᵀ τ_θ,     ∂τ_q/∂q = Aᵀ (∂τ_θ/∂θ) A,     ∂τ_q/∂(g, m, h) = Aᵀ ∂τ_θ/∂(g, m, h)
//! ```
//!
//! A joint that others mimic carries what they carry, times their multipliers.

use super::{Axes, GravityTorque};
use crate::chain::Drive;

impl Axes {
    /// `θ = A q + c`.
    pub(super) fn spread(&mut self, drives: &[Drive], coordinates: &[f64]) {
        for (own, drive) in self.coordinates.iter_mut().zip(drives) {
            *own = drive.coordinate(coordinates);
        }
    }
}

/// `Aᵀ` times a matrix that has a row for each axis: its rows are summed by joint.
pub(super) fn gather(drives: &[Drive], by_axis: &[f64], by_joint: &mut [f64]) {
    by_joint.fill(0.0);
    let width = by_axis.len() / drives.len();
    for (drive, row) in drives.iter().zip(by_axis.chunks_exact(width)) {
        let sums = &mut by_joint[width * drive.joint..width * (drive.joint + 1)];
        sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += drive.multiplier * entry);
    }
}

impl GravityTorque {
    /// Everything by joints, from everything by axes.
    pub(super) fn gather(&mut self, drives: &[Drive], axes: &GravityTorque) {
        gather(drives, &axes.torque, &mut self.torque);
        gather(drives, &axes.by_gravity, &mut self.by_gravity);
        gather(drives, &axes.by_inertia, &mut self.by_inertia);
        let (n, width) = (self.torque.len(), drives.len());
        self.by_coordinate.fill(0.0);
        for (i, row) in drives.iter().zip(axes.by_coordinate.chunks_exact(width)) {
            for (j, second) in drives.iter().zip(row) {
                self.by_coordinate[n * i.joint + j.joint] += i.multiplier * j.multiplier * second;
            }
        }
    }
}
