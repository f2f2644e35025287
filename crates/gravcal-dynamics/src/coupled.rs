//! Joints that mimic others.
//!
//! With `θ = A q + c` the coordinates of all axes, by those `q` of the joints that have one of their own (a row of A holds a
//! multiplier), velocities and accelerations are `A q̇` and `A q̈`, and by virtual work
//!
//! ```text
//!     τ_q = Aᵀ τ_θ,     ∂τ_q/∂q = Aᵀ (∂τ_θ/∂θ) A,     ∂τ_q/∂(g, π) = Aᵀ ∂τ_θ/∂(g, π)
//! ```
//!
//! with π the links' masses, first moments and tensors; and by q̇ and q̈ as by q. A joint that others mimic carries what they carry, times
//! their multipliers.

use crate::arithmetic::{Arithmetic, Stored};
use crate::chain::Drive;

/// `Aᵀ` times a matrix that has a row for each axis: its rows are summed by joint.
#[inline(always)]
pub(crate) fn gather<A: Arithmetic>(on: A, drives: &[Drive], by_axis: &[A::Stored], by_joint: &mut [A::Stored]) {
    by_joint.fill(A::Stored::ZERO);
    let width = by_axis.len() / drives.len();
    for (drive, row) in drives.iter().zip(by_axis.chunks_exact(width)) {
        let sums = &mut by_joint[width * drive.joint..width * (drive.joint + 1)];
        for (sum, entry) in sums.iter_mut().zip(row) {
            *sum = on.store(on.load(*sum) + on.constant(drive.multiplier) * on.load(*entry));
        }
    }
}

/// `Aᵀ M A` of a matrix by axes.
#[inline(always)]
pub(crate) fn gather_both<A: Arithmetic>(on: A, drives: &[Drive], by_axes: &[A::Stored], by_joints: &mut [A::Stored]) {
    by_joints.fill(A::Stored::ZERO);
    let joints = by_joints.len().isqrt();
    for (i, row) in drives.iter().zip(by_axes.chunks_exact(drives.len())) {
        for (j, second) in drives.iter().zip(row) {
            let sum = &mut by_joints[joints * i.joint + j.joint];
            *sum = on.store(on.load(*sum) + on.constant(i.multiplier * j.multiplier) * on.load(*second));
        }
    }
}
