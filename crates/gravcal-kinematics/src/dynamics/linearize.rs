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
    let n = out.motions.len();
    out.by_coordinate.fill(A::Stored::ZERO);
    out.by_velocity.fill(A::Stored::ZERO);
    out.by_acceleration.fill(A::Stored::ZERO);
    for i in 0..n {
        let motion = &out.motions[i];
        let Carrier { velocity, acceleration } = carrier(on, &out.motions, chain.topology.parents[i], gravity);
        let (axis, rate) = (motion.axis.load(on), motion.axis_rate.load(on));
        out.axis_changes[i] = Twist::store(on, &acceleration.cross(&axis).plus(&velocity.cross(&rate)));
    }
    for j in 0..n {
        let at = at_axis(on, out, j);
        let by_gravity = at.by_acceleration.force;
        for (entry, by) in out.by_gravity[3 * j..3 * j + 3].iter_mut().zip([by_gravity.x, by_gravity.y, by_gravity.z]) {
            *entry = on.store(-by);
        }
        let mut before = Some(j);
        while let Some(i) = before {
            let motion = &out.motions[i];
            let (axis, rate, change) = (motion.axis.load(on), motion.axis_rate.load(on), out.axis_changes[i].load(on));
            let (above, below) = (n * i + j, n * j + i);
            let inertia = on.store(axis.dot(&at.by_acceleration));
            out.by_acceleration[above] = inertia;
            out.by_acceleration[below] = inertia;
            if i < j {
                let by_coordinate = change.dot(&at.by_acceleration) + dot(&rate.angular, &at.turned);
                out.by_coordinate[below] = on.store(by_coordinate);
                let twice = on.constant(2.0) * rate.dot(&at.by_acceleration);
                out.by_velocity[below] = on.store(twice + dot(&axis.angular, &at.turned));
            }
            out.by_coordinate[above] = on.store(axis.dot(&at.by_coordinate));
            out.by_velocity[above] = on.store(axis.dot(&at.by_velocity));
            before = chain.topology.parents[i];
        }
    }
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
