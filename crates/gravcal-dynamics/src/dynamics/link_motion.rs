//! How each link moves: from the base outward.
//!
//! With `S_i = (z_i, o_i × z_i)` (revolute) or `(0, z_i)` (prismatic) the motion by coordinate i alone, and p the link before,
//!
//! ```text
//!     v_i = v_p + S_i θ̇_i,     Ψ̇_i = v_p × S_i,     a_i = a_p + S_i θ̈_i + Ψ̇_i θ̇_i,     v_0 = 0,  a_0 = (0, −g)
//! ```

use nalgebra::Vector3;

use super::joint_motion::JointMotion;
use super::spatial::Twist;
use crate::arithmetic::{Arithmetic, Stored, cross};
use crate::chain::{Chain, Run};
use crate::frame::constant;
use crate::gravity::{Bodies, BodyBeyond};

/// The motion of one link, as it lies in memory.
#[derive(Clone, Debug)]
pub(super) struct LinkMotion<L> {
    /// S_i.
    pub axis: Twist<L>,
    /// v_i.
    pub velocity: Twist<L>,
    /// Ψ̇_i.
    pub axis_rate: Twist<L>,
    /// a_i, spatial, gravity taken off.
    pub acceleration: Twist<L>,
}

impl<L: Stored> LinkMotion<L> {
    pub fn still() -> Self {
        LinkMotion { axis: Twist::ZERO, velocity: Twist::ZERO, axis_rate: Twist::ZERO, acceleration: Twist::ZERO }
    }
}

/// Velocity and acceleration of a link.
pub(super) struct Carrier<N> {
    pub velocity: Twist<N>,
    pub acceleration: Twist<N>,
}

/// What a link hangs on.
#[inline(always)]
pub(super) fn carrier<A: Arithmetic>(
    on: A,
    motions: &[LinkMotion<A::Stored>],
    parent: Option<usize>,
    gravity: [f64; 3],
) -> Carrier<A::Number> {
    match parent {
        Some(parent) => {
            let LinkMotion { velocity, acceleration, .. } = &motions[parent];
            Carrier { velocity: velocity.load(on), acceleration: acceleration.load(on) }
        }
        None => {
            let still = Twist { angular: constant(on, &Vector3::zeros()), linear: constant(on, &Vector3::zeros()) };
            Carrier { velocity: still, acceleration: Twist { linear: -constant(on, &gravity.into()), ..still } }
        }
    }
}

/// The motions of all links, whose frames are placed. `sample`: of each link's mover.
#[inline(always)]
pub(super) fn sweep<A: Arithmetic>(
    on: A,
    chain: &Chain,
    bodies: &Bodies<A::Stored>,
    sample: JointMotion<'_, A::Stored>,
    gravity: [f64; 3],
    motions: &mut [LinkMotion<A::Stored>],
) {
    for Run { links, parent } in &chain.topology.runs {
        let Carrier { mut velocity, mut acceleration } = carrier(on, motions, *parent, gravity);
        for k in links.clone() {
            let axis = axis(on, &bodies.as_slice()[k]);
            let (speed, rate) = (on.load(sample.velocities[k]), on.load(sample.accelerations[k]));
            let axis_rate = velocity.cross(&axis);
            velocity = velocity.plus(&axis.times(speed));
            acceleration = acceleration.plus(&axis.times(rate)).plus(&axis_rate.times(speed));
            motions[k] = LinkMotion {
                axis: Twist::store(on, &axis),
                velocity: Twist::store(on, &velocity),
                axis_rate: Twist::store(on, &axis_rate),
                acceleration: Twist::store(on, &acceleration),
            };
        }
    }
}

#[inline(always)]
fn axis<A: Arithmetic>(on: A, body: &BodyBeyond<A::Stored>) -> Twist<A::Number> {
    match body.axis(on) {
        (axis, Some(point)) => Twist { angular: axis, linear: cross(&point, &axis) },
        (axis, None) => Twist { angular: constant(on, &Vector3::zeros()), linear: axis },
    }
}
