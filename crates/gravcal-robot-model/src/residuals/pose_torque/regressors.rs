//! A window of an arm whose positions are known exactly: torques are linear in gravity and in the links' parameters.
//!
//! ```text
//!     τ̄ = (Y_0 + Σ_a g_a Y_a) π,      Y_0 = Σ_t h(t) Y(θ, θ̇, θ̈; 0),   Y_a = Σ_t h(t) ∂Y(θ, θ̇, θ̈; g)/∂g_a
//! ```
//!
//! `Y_a` has columns of masses and first moments only. All four are computed once, of as many moments at once as the processor has lanes.

use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{Arithmetic, Chain, InverseDynamics, Single, Stored, Vectorized};
use gravcal_recording::Course;
use pulp::{Arch, Simd, WithSimd};

use super::means::Means;
use super::model::{BODY, GRAVITY, INERTIA, add};
use super::moments::{Moments, Moving, add_lanes, at_once, weights};

/// Mean regressors of a window.
#[derive(Clone, Debug)]
pub(super) struct Regressors {
    /// n × l.
    entries: Vec<Entries>,
}

/// Those of a joint's torque by the parameters of one link.
#[derive(Clone, Debug)]
struct Entries {
    /// Of `Y_0`.
    without_gravity: [f64; BODY],
    /// Of `Y_a`, for each axis.
    by_gravity: [[f64; INERTIA]; GRAVITY],
}

/// Those of a course that are kept with it, and of which chain and positions they are.
struct Of {
    chain: Arc<Chain>,
    positions: Vec<[f64; 2]>,
    regressors: Arc<Regressors>,
}

/// The mean regressors by vector instructions; nothing where these have other lanes.
struct Summed<'a>(&'a Chain, &'a Course, &'a [[f64; 2]]);

impl WithSimd for Summed<'_> {
    type Output = Option<Regressors>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Summed(chain, course, positions) = self;
        Some(summed(Vectorized::new(simd)?, chain, course, positions))
    }
}

#[inline(always)]
fn summed<A: Arithmetic>(on: A, chain: &Chain, course: &Course, positions: &[[f64; 2]]) -> Regressors
where
    A::Stored: Moments,
{
    let (n, links) = (chain.joint_count(), chain.link_count());
    let zeros = |count: usize| vec![A::Stored::ZERO; count];
    let mut dynamics: InverseDynamics<A::Stored> = InverseDynamics::new(chain);
    let mut without_gravity = zeros(n * BODY * links);
    let mut by_gravity = [(); GRAVITY].map(|()| zeros(n * INERTIA * links));
    let mut moving = Moving::new(n);
    for (moments, shares) in at_once::<A::Stored>(course) {
        moving.set(moments, positions.iter().copied());
        let weight = on.load(weights(shares));
        chain.affine_regressor(on, moving.of_joints(), &mut dynamics);
        add_lanes(on, &mut without_gravity, weight, &dynamics.by_parameters);
        let by_axes = dynamics.regressor_by_gravity.chunks_exact((n * INERTIA * links).max(1));
        by_gravity.iter_mut().zip(by_axes).for_each(|(sum, own)| add_lanes(on, sum, weight, own));
    }
    let without_gravity = without_gravity.as_chunks::<BODY>().0;
    let by_gravity = by_gravity.each_ref().map(|by_axis| by_axis.as_chunks::<INERTIA>().0);
    let of_place = |place: usize| Entries {
        without_gravity: without_gravity[place].map(Moments::sum),
        by_gravity: by_gravity.map(|by_axis| by_axis[place].map(Moments::sum)),
    };
    Regressors { entries: (0..n * links).map(of_place).collect() }
}

impl Regressors {
    /// The same, kept with the course: a problem is built again and again, of the same windows.
    pub fn kept(chain: &Arc<Chain>, course: &Course, positions: &[[f64; 2]]) -> Arc<Regressors> {
        let make = || Arc::new(Regressors::new(chain, course, positions));
        let of = || Of { chain: Arc::clone(chain), positions: positions.to_vec(), regressors: make() };
        let same = |of: &&Of| of.positions == positions && (Arc::ptr_eq(&of.chain, chain) || of.chain == *chain);
        course.kept.or_make(of).filter(same).map_or_else(make, |of| Arc::clone(&of.regressors))
    }

    /// `positions`: gain and offset of each joint's position sensor.
    pub fn new(chain: &Chain, course: &Course, positions: &[[f64; 2]]) -> Regressors {
        let batch = Arch::new().dispatch(Summed(chain, course, positions));
        batch.unwrap_or_else(|| summed(Single, chain, course, positions))
    }

    /// Torques, and their derivatives by gravity and by the parameters; those by positions stay as they are. `felt`: the links that each joint's
    /// torque can feel, beyond which all is zero.
    pub fn evaluate(&self, gravity: [f64; 3], parameters: &[f64], felt: &[Range<usize>], mean: &mut Means) {
        let (bodies, _) = parameters.as_chunks::<BODY>();
        let (by_parameters, _) = mean.by_parameters.as_chunks_mut::<BODY>();
        let by_gravity = mean.by_gravity.as_chunks_mut::<GRAVITY>().0;
        for (joint, felt) in felt.iter().enumerate() {
            let places = joint * bodies.len() + felt.start..joint * bodies.len() + felt.end;
            let links = self.entries[places.clone()].iter().zip(&bodies[felt.clone()]);
            let (mut torque, mut by_axes) = (0.0, [0.0; GRAVITY]);
            for ((entries, body), by_body) in links.zip(&mut by_parameters[places]) {
                *by_body = entries.without_gravity;
                for ((by_axis, own), component) in by_axes.iter_mut().zip(&entries.by_gravity).zip(gravity) {
                    *by_axis += own.iter().zip(body).map(|(entry, parameter)| entry * parameter).sum::<f64>();
                    add(&mut by_body[..INERTIA], component, own);
                }
                torque += by_body.iter().zip(body).map(|(entry, parameter)| entry * parameter).sum::<f64>();
            }
            mean.torque[joint] = torque;
            by_gravity[joint] = by_axes;
        }
    }
}
