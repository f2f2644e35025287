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
//!
//! Gravity is in `a` alone, `∂a/∂g = −R_kᵀ`: by its component along axis e of the base, `∂τ_i/∂m_k` changes with `−s_v · R_kᵀ e` and
//! `∂τ_i/∂h_k` with `−R_kᵀ e × s_ω`.

use nalgebra::Vector3;

use super::link_motion::LinkMotion;
use super::spatial::Twist;
use crate::arithmetic::{Arithmetic, Number, Stored, cross, dot, transposed_times};
use crate::body_inertia::BODY;
use crate::chain::Chain;
use crate::frame::Frame;
use crate::gravity::{Bodies, INERTIA};

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
            let (turn, way) = alone(&frame, &motions[i].axis.load(on));
            let entries = &mut out[width * i + BODY * k..width * i + BODY * (k + 1)];
            for (entry, by) in entries.iter_mut().zip(own.by_parameters(&turn, &way)) {
                *entry = on.store(by);
            }
            axis = chain.topology.parents[i];
        }
    }
}

/// For each axis of the base rows of `4 l` numbers, one for each axis of the chain.
#[inline(always)]
pub(super) fn write_by_gravity<A: Arithmetic>(
    on: A,
    chain: &Chain,
    bodies: &Bodies<A::Stored>,
    motions: &[LinkMotion<A::Stored>],
    out: &mut [A::Stored],
) {
    out.fill(A::Stored::ZERO);
    let width = INERTIA * motions.len();
    let rows = width * motions.len();
    for k in 0..motions.len() {
        let frame = bodies.as_slice()[k].link_pose(on);
        let by_components = [0, 1, 2].map(|e| -frame.rotation.row(e).transpose());
        let mut axis = Some(k);
        while let Some(i) = axis {
            let (turn, way) = alone(&frame, &motions[i].axis.load(on));
            for (e, by_component) in by_components.iter().enumerate() {
                let moment = cross(by_component, &turn);
                let entries = &mut out[rows * e + width * i + INERTIA * k..][..INERTIA];
                for (entry, by) in entries.iter_mut().zip([dot(&way, by_component), moment.x, moment.y, moment.z]) {
                    *entry = on.store(by);
                }
            }
            axis = chain.topology.parents[i];
        }
    }
}

/// The motion of a link by one coordinate alone, in its own frame: angular, and of its origin.
#[inline(always)]
fn alone<N: Number>(frame: &Frame<N>, by: &Twist<N>) -> (Vector3<N>, Vector3<N>) {
    (transposed_times(&frame.rotation, &by.angular), transposed_times(&frame.rotation, &by.at(&frame.translation)))
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
