//! The inverse dynamics as a linear function of the links' parameters.
//!
//! In the frame of link k, with `ω`, `α` its angular velocity and acceleration, `a` the acceleration of its origin less gravity, and
//! `s_ω`, `s_v` the motion of the link by coordinate i alone (angular, and of the link's origin),
//!
//! ```text
//!     ∂τ_i/∂m_k = s_v · a
//!     ∂τ_i/∂h_k = a × s_ω + s_v × α + ω × (ω × s_v)
//!     ∂τ_i/∂I_k:  s_ω · I α + t · I ω,   t = s_ω × ω,     so xx: s_x α_x + t_x ω_x,   xy: s_x α_y + s_y α_x + t_x ω_y + t_y ω_x, …
//! ```

use nalgebra::Vector3;

use super::link_motion::LinkMotion;
use super::spatial::Twist;
use crate::arithmetic::{Arithmetic, Number, Stored, cross, dot, transposed_times};
use crate::body_inertia::BODY;
use crate::chain::Chain;
use crate::frame::Frame;
use crate::gravity::Bodies;

/// A link's motion in its own frame.
struct OwnMotion<N> {
    velocity: Vector3<N>,
    rate: Vector3<N>,
    /// Of its origin, gravity taken off.
    acceleration: Vector3<N>,
}

/// Rows of `10 l` numbers, one for each axis.
#[inline(always)]
pub(super) fn write<A: Arithmetic>(
    on: A,
    chain: &Chain,
    bodies: &Bodies<A::Stored>,
    motions: &[LinkMotion<A::Stored>],
    out: &mut [A::Stored],
) {
    let width = BODY * motions.len();
    for ((i, row), end) in out.chunks_exact_mut(width).enumerate().zip(&chain.topology.ends) {
        row[..BODY * i].fill(A::Stored::ZERO);
        row[BODY * end..].fill(A::Stored::ZERO);
    }
    for (k, motion) in motions.iter().enumerate() {
        let frame = bodies.as_slice()[k].link_pose(on);
        let own = own_motion(&frame, &motion.velocity.load(on), &motion.acceleration.load(on));
        let mut axis = Some(k);
        while let Some(i) = axis {
            let by = motions[i].axis.load(on);
            let turn = transposed_times(&frame.rotation, &by.angular);
            let way = transposed_times(&frame.rotation, &by.at(&frame.translation));
            let entries = &mut out[width * i + BODY * k..width * i + BODY * (k + 1)];
            for (entry, by) in entries.iter_mut().zip(own.by_parameters(&turn, &way)) {
                *entry = on.store(by);
            }
            axis = chain.topology.parents[i];
        }
    }
}

#[inline(always)]
fn own_motion<N: Number>(frame: &Frame<N>, velocity: &Twist<N>, acceleration: &Twist<N>) -> OwnMotion<N> {
    let origin = &frame.translation;
    // The spatial acceleration is that of the flow at a place; a point of the link moves on with it.
    let of_origin = acceleration.at(origin) + cross(&velocity.angular, &velocity.at(origin));
    OwnMotion {
        velocity: transposed_times(&frame.rotation, &velocity.angular),
        rate: transposed_times(&frame.rotation, &acceleration.angular),
        acceleration: transposed_times(&frame.rotation, &of_origin),
    }
}

impl<N: Number> OwnMotion<N> {
    #[inline(always)]
    fn by_parameters(&self, s: &Vector3<N>, way: &Vector3<N>) -> [N; BODY] {
        let OwnMotion { velocity: w, rate: r, acceleration } = self;
        let moment = cross(acceleration, s) + cross(way, r) + cross(w, &cross(w, way));
        let t = cross(s, w);
        [
            dot(way, acceleration),
            moment.x,
            moment.y,
            moment.z,
            s.x * r.x + t.x * w.x,
            s.x * r.y + s.y * r.x + t.x * w.y + t.y * w.x,
            s.y * r.y + t.y * w.y,
            s.x * r.z + s.z * r.x + t.x * w.z + t.z * w.x,
            s.y * r.z + s.z * r.y + t.y * w.z + t.z * w.y,
            s.z * r.z + t.z * w.z,
        ]
    }
}
