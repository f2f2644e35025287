//! Derivatives of the inverse dynamics by coordinates, velocities, accelerations and gravity, by axes.
//!
//! A change of coordinate i turns (or shifts) all that hangs beyond axis i as one body, by `S_i`. Seen from there, it is the base that has
//! moved back: velocities change by `Ψ̇_i = v_p × S_i` and what moves the bodies by `Ψ̈_i = a_p × S_i + v_p × Ψ̇_i`, p the link before. So
//! with `I_j`, `B_j`, `F_j` those of all that hangs beyond axis j, and i before j or j itself (the second of each pair: before only),
//!
//! ```text
//!     ∂τ_i/∂θ_j = S_i · (I_j Ψ̈_j + 2 B_j Ψ̇_j + S_j ×* F_j)      ∂τ_j/∂θ_i = S_j · (I_j Ψ̈_i + 2 B_j Ψ̇_i)
//!     ∂τ_i/∂θ̇_j = S_i · (2 I_j Ψ̇_j + 2 B_j S_j)                  ∂τ_j/∂θ̇_i = S_j · (2 I_j Ψ̇_i + 2 B_j S_i)
//!     ∂τ_i/∂θ̈_j = ∂τ_j/∂θ̈_i = S_i · I_j S_j                      ∂τ_j/∂g   = −(force of I_j S_j)
//! ```
//!
//! and zero for axes on different branches (Singh, Russell and Wensing, *Efficient Analytical Derivatives of Rigid-Body Dynamics using
//! Spatial Vector Algebra*, 2022, eqs. for joints of one degree of freedom).

use nalgebra::Vector3;

use super::InverseDynamics;
use super::link_motion::{Carrier, carrier};
use super::spatial::{Twist, Wrench};
use crate::arithmetic::{Arithmetic, Stored, dot};
use crate::chain::Chain;
use crate::frame::store;

/// What the column of coordinate j needs of all axes before it, and its row of all coordinates before it.
struct AtAxis<N> {
    by_coordinate: Wrench<N>,
    by_velocity: Wrench<N>,
    /// `I_j S_j`.
    by_acceleration: Wrench<N>,
    /// `2 B_jᵀ S_j`.
    turned: Vector3<N>,
}

/// Fills all derivatives but those by parameters. The workspace's links have been placed, moved and gathered.
#[inline(always)]
pub(super) fn write<A: Arithmetic>(on: A, chain: &Chain, gravity: [f64; 3], out: &mut InverseDynamics<A::Stored>) {
    change_axes(on, chain, gravity, out);
    out.by_coordinate.fill(A::Stored::ZERO);
    out.by_velocity.fill(A::Stored::ZERO);
    out.by_acceleration.fill(A::Stored::ZERO);
    for j in 0..out.motions.len() {
        let at = at_axis(on, out, j);
        let by_gravity = store(on, &-at.by_acceleration.force);
        out.by_gravity[3 * j..3 * j + 3].copy_from_slice(by_gravity.as_slice());
        write_column(on, &at, j, j, out);
        let mut before = chain.topology.parents[j];
        while let Some(i) = before {
            write_column(on, &at, i, j, out);
            write_row(on, &at, i, j, out);
            before = chain.topology.parents[i];
        }
    }
}

/// Ψ̈ of each axis.
#[inline(always)]
fn change_axes<A: Arithmetic>(on: A, chain: &Chain, gravity: [f64; 3], out: &mut InverseDynamics<A::Stored>) {
    let InverseDynamics { motions, axis_changes, .. } = out;
    for ((motion, change), parent) in motions.iter().zip(axis_changes).zip(&chain.topology.parents) {
        let Carrier { velocity, acceleration } = carrier(on, motions, *parent, gravity);
        let (axis, rate) = (motion.axis.load(on), motion.axis_rate.load(on));
        *change = Twist::store(on, &acceleration.cross(&axis).plus(&velocity.cross(&rate)));
    }
}

/// Of the torque of axis i, by what axis j does: j is beyond i or i itself.
#[inline(always)]
fn write_column<A: Arithmetic>(
    on: A,
    at: &AtAxis<A::Number>,
    i: usize,
    j: usize,
    out: &mut InverseDynamics<A::Stored>,
) {
    let (entry, axis) = (out.motions.len() * i + j, out.motions[i].axis.load(on));
    out.by_coordinate[entry] = on.store(axis.dot(&at.by_coordinate));
    out.by_velocity[entry] = on.store(axis.dot(&at.by_velocity));
    out.by_acceleration[entry] = on.store(axis.dot(&at.by_acceleration));
}

/// Of the torque of axis j, by what axis i before it does.
#[inline(always)]
fn write_row<A: Arithmetic>(on: A, at: &AtAxis<A::Number>, i: usize, j: usize, out: &mut InverseDynamics<A::Stored>) {
    let (entry, motion) = (out.motions.len() * j + i, &out.motions[i]);
    let (axis, rate, change) = (motion.axis.load(on), motion.axis_rate.load(on), out.axis_changes[i].load(on));
    let by_coordinate = change.dot(&at.by_acceleration) + dot(&rate.angular, &at.turned);
    let by_velocity = rate.times(on.constant(2.0)).dot(&at.by_acceleration) + dot(&axis.angular, &at.turned);
    out.by_coordinate[entry] = on.store(by_coordinate);
    out.by_velocity[entry] = on.store(by_velocity);
    out.by_acceleration[entry] = on.store(axis.dot(&at.by_acceleration));
}

#[inline(always)]
fn at_axis<A: Arithmetic>(on: A, out: &InverseDynamics<A::Stored>, j: usize) -> AtAxis<A::Number> {
    let (motion, beyond) = (&out.motions[j], &out.beyond[j]);
    let (axis, rate, change) = (motion.axis.load(on), motion.axis_rate.load(on), out.axis_changes[j].load(on));
    let (body, wrench) = (beyond.body.load(on), beyond.wrench.load(on));
    let two = on.constant(2.0);
    let twice = rate.times(two);
    AtAxis {
        by_coordinate: body.resisting(&change).plus(&body.turning(&twice.angular)).plus(&axis.carried(&wrench)),
        by_velocity: body.resisting(&twice).plus(&body.turning(&(axis.angular * two))),
        by_acceleration: body.resisting(&axis),
        turned: body.turned_along(&axis) * two,
    }
}
