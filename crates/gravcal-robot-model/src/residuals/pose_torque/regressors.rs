//! A window of an arm whose positions are known exactly: torques are linear in gravity and in the links' parameters.
//!
//! ```text
//!     τ̄ = (Y_0 + Σ_a g_a Y_a) π,      Y_0 = Σ_t h(t) Y(θ, θ̇, θ̈; 0),   Y_a = Σ_t h(t) [Y(θ, θ̇, θ̈; e_a) − Y(θ, θ̇, θ̈; 0)]
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
use super::moments::{Moments, Moving, add_lanes, weights};

/// Mean regressors of a window.
#[derive(Clone, Debug)]
pub(super) struct Regressors {
    /// n × 10 l.
    without_gravity: Vec<f64>,
    /// For each axis n × 4 l.
    by_gravity: [Vec<f64>; GRAVITY],
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
    let mut alone = zeros(n * BODY * links);
    for moments in course.samples.chunks(A::Stored::COUNT) {
        moving.set(moments, positions.iter().copied());
        let (motion, weight) = (moving.of_joints(), on.load(weights(moments)));
        chain.inverse_dynamics_regressor(on, motion, [0.0; 3], &mut dynamics);
        alone.copy_from_slice(&dynamics.by_parameters);
        add_lanes(on, &mut without_gravity, weight, &alone);
        for (axis, by_axis) in by_gravity.iter_mut().enumerate() {
            let mut unit = [0.0; GRAVITY];
            unit[axis] = 1.0;
            chain.inverse_dynamics_regressor(on, motion, unit, &mut dynamics);
            let bodies = dynamics.by_parameters.as_chunks::<BODY>().0.iter().zip(alone.as_chunks::<BODY>().0);
            for (sum, (with, without)) in by_axis.as_chunks_mut::<INERTIA>().0.iter_mut().zip(bodies) {
                for ((sum, with), without) in sum.iter_mut().zip(with).zip(without) {
                    *sum = on.store(on.load(*sum) + weight * (on.load(*with) - on.load(*without)));
                }
            }
        }
    }
    let total = |sums: Vec<A::Stored>| sums.into_iter().map(Moments::sum).collect();
    Regressors { without_gravity: total(without_gravity), by_gravity: by_gravity.map(total) }
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
        let (alone, _) = self.without_gravity.as_chunks::<BODY>();
        let by_gravity = [0, 1, 2].map(|axis| self.by_gravity[axis].as_chunks::<INERTIA>().0);
        let (by_parameters, _) = mean.by_parameters.as_chunks_mut::<BODY>();
        for (joint, felt) in felt.iter().enumerate() {
            let (mut torque, mut by_axes) = (0.0, [0.0; GRAVITY]);
            for link in felt.clone() {
                let (place, body) = (joint * bodies.len() + link, &bodies[link]);
                let mut by_body = alone[place];
                for ((by_axis, by_gravity), gravity) in by_axes.iter_mut().zip(by_gravity).zip(gravity) {
                    let entries = &by_gravity[place];
                    *by_axis += entries.iter().zip(body).map(|(entry, parameter)| entry * parameter).sum::<f64>();
                    add(&mut by_body[..INERTIA], gravity, entries);
                }
                torque += by_body.iter().zip(body).map(|(entry, parameter)| entry * parameter).sum::<f64>();
                by_parameters[place] = by_body;
            }
            mean.torque[joint] = torque;
            mean.by_gravity[GRAVITY * joint..GRAVITY * (joint + 1)].copy_from_slice(&by_axes);
        }
    }
}
