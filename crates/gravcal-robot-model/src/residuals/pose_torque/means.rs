//! Means over a window of an arm's torques and of their derivatives, of as many moments at once as the processor has lanes.
//!
//! ```text
//!     τ̄ = Σ_t h(t) τ(θ, θ̇, θ̈; g, π),     ∂τ̄/∂o = Σ_t h ∂τ/∂θ,     ∂τ̄/∂s = Σ_t h (q ∂τ/∂θ + q̇ ∂τ/∂θ̇ + q̈ ∂τ/∂θ̈)
//! ```

use std::ops::Range;
use std::sync::Arc;

use gravcal_dynamics::{Arithmetic, Chain, DynamicParameters, InverseDynamics, LANES, Single, Vectorized};
use gravcal_recording::{Course, MotionSample};
use pulp::{Arch, Simd, WithSimd};

use super::instructions::batch_instructions;
use super::model::{BODY, GRAVITY};
use super::moments::{Moments, Moving, add_lanes, weights};

/// Torques and their derivatives, row-major: by gravity (n × 3), by gains and offsets of positions (n × n each), by the links' parameters
/// (n × 10 l).
pub(super) struct Means<L = f64> {
    pub torque: Vec<L>,
    pub by_gravity: Vec<L>,
    pub by_position_gains: Vec<L>,
    pub by_offsets: Vec<L>,
    pub by_parameters: Vec<L>,
}

impl<L: Moments> Means<L> {
    pub fn new(chain: &Chain) -> Self {
        let (n, links) = (chain.joint_count(), chain.link_count());
        let zeros = |count: usize| vec![L::ZERO; count];
        Means {
            torque: zeros(n),
            by_gravity: zeros(GRAVITY * n),
            by_position_gains: zeros(n * n),
            by_offsets: zeros(n * n),
            by_parameters: zeros(BODY * links * n),
        }
    }

    pub fn clear(&mut self) {
        self.lists().into_iter().for_each(|list| list.fill(L::ZERO));
    }

    fn lists(&mut self) -> [&mut [L]; 5] {
        let Means { torque, by_gravity, by_position_gains, by_offsets, by_parameters } = self;
        [torque, by_gravity, by_position_gains, by_offsets, by_parameters]
    }

    fn add_to(&mut self, total: &mut Means) {
        for (total, lanes) in total.lists().into_iter().zip(self.lists()) {
            total.iter_mut().zip(lanes).for_each(|(total, lanes)| *total += lanes.sum());
        }
    }
}

/// A window, and where its torques are asked for.
pub(super) struct At<'a> {
    pub chain: &'a Chain,
    pub course: &'a Course,
    /// Of each joint's position sensor.
    pub gains: &'a [f64],
    pub offsets: &'a [f64],
    /// m/s², in base coordinates.
    pub gravity: [f64; 3],
    pub inertia: DynamicParameters<'a>,
    /// The links that each joint's torque can feel, beyond which all is zero.
    pub felt: &'a [Range<usize>],
    pub derivatives: bool,
}

/// What the moments of a window are computed in.
pub(super) enum Workspace {
    Vectorized(Arch, Box<Lanes<[f64; LANES]>>),
    /// Where no instructions have so many lanes.
    Single(Box<Lanes<f64>>),
}

impl Workspace {
    pub fn new(chain: &Chain) -> Self {
        match batch_instructions() {
            Some(instructions) => Workspace::Vectorized(instructions, Box::new(Lanes::new(chain))),
            None => Workspace::Single(Box::new(Lanes::new(chain))),
        }
    }

    /// Adds the means to `total`.
    pub fn add(&mut self, at: &At<'_>, total: &mut Means) {
        match self {
            Workspace::Vectorized(instructions, lanes) => instructions.dispatch(Summed { lanes, at, total }),
            Workspace::Single(lanes) => lanes.add(Single, at, total),
        }
    }
}

/// As many moments as a batch has, and what their torques are: windows that overlap ask for the same ones.
pub(super) struct Lanes<L> {
    known: Vec<Known<L>>,
    /// Gains, offsets, gravity, parameters, and whether derivatives are asked for, of what is known.
    unknowns: Vec<f64>,
    /// How often anything was asked for.
    asked: u64,
    sums: Means<L>,
}

/// Torques of some moments.
struct Known<L> {
    /// A stretch, and which part of it.
    of: Option<(Arc<[MotionSample]>, usize)>,
    /// When they were asked for last.
    asked: u64,
    moving: Moving<L>,
    dynamics: InverseDynamics<L>,
}

impl<L: Moments> Lanes<L> {
    fn new(chain: &Chain) -> Self {
        Lanes { known: Vec::new(), unknowns: Vec::new(), asked: 0, sums: Means::new(chain) }
    }

    #[inline(always)]
    fn add<A: Arithmetic<Stored = L>>(&mut self, on: A, at: &At<'_>, total: &mut Means) {
        self.sums.clear();
        self.forget_others(at);
        for stretch in &at.course.stretches {
            for (part, shares) in stretch.weights.chunks(L::COUNT).enumerate() {
                let place = self.place(&stretch.moments, part);
                if self.known[place].of.is_none() {
                    self.known[place].compute(on, at, &stretch.moments, part);
                }
                let (known, weight) = (&self.known[place], on.load(weights(shares)));
                if at.derivatives {
                    add_derivatives(on, at, known, weight, &mut self.sums);
                }
                add_lanes(on, &mut self.sums.torque, weight, &known.dynamics.torque);
            }
        }
        self.sums.add_to(total);
    }

    /// What is known counts nothing where anything else is another; a window's moments all have a place.
    fn forget_others(&mut self, at: &At<'_>) {
        let DynamicParameters { links, rotor_inertia } = at.inertia;
        let lists = [at.gains, at.offsets, &at.gravity, links, rotor_inertia].into_iter().flatten();
        let unknowns = || lists.clone().copied().chain([f64::from(at.derivatives)]);
        if !self.unknowns.iter().copied().eq(unknowns()) {
            self.unknowns.clear();
            self.unknowns.extend(unknowns());
            self.known.iter_mut().for_each(|known| known.of = None);
        }
        let parts = at.course.stretches.iter().map(|stretch| stretch.moments.len().div_ceil(L::COUNT)).sum();
        while self.known.len() < parts {
            self.known.push(Known::new(at.chain));
        }
    }

    /// Where a part of a stretch is known, or can be: in place of what was asked for longest ago.
    fn place(&mut self, moments: &Arc<[MotionSample]>, part: usize) -> usize {
        let is_here = |known: &Known<L>| {
            known.of.as_ref().is_some_and(|(stretch, known)| *known == part && Arc::ptr_eq(stretch, moments))
        };
        let place = self.known.iter().position(is_here).unwrap_or_else(|| {
            let oldest = (0..self.known.len()).min_by_key(|place| self.known[*place].asked).unwrap_or(0);
            self.known[oldest].of = None;
            oldest
        });
        self.asked += 1;
        self.known[place].asked = self.asked;
        place
    }
}

impl<L: Moments> Known<L> {
    fn new(chain: &Chain) -> Self {
        Known { of: None, asked: 0, moving: Moving::new(chain.joint_count()), dynamics: InverseDynamics::new(chain) }
    }

    #[inline(always)]
    fn compute<A: Arithmetic<Stored = L>>(&mut self, on: A, at: &At<'_>, moments: &Arc<[MotionSample]>, part: usize) {
        let own = &moments[L::COUNT * part..moments.len().min(L::COUNT * (part + 1))];
        self.moving.set(own, at.gains.iter().zip(at.offsets).map(|(gain, offset)| [*gain, *offset]));
        let motion = self.moving.of_joints();
        match at.derivatives {
            true => at.chain.linearize_inverse_dynamics(on, motion, at.gravity, at.inertia, &mut self.dynamics),
            false => at.chain.inverse_dynamics(on, motion, at.gravity, at.inertia, &mut self.dynamics),
        }
        self.of = Some((Arc::clone(moments), part));
    }
}

#[inline(always)]
fn add_derivatives<A: Arithmetic>(
    on: A,
    at: &At<'_>,
    known: &Known<A::Stored>,
    weight: A::Number,
    sums: &mut Means<A::Stored>,
) where
    A::Stored: Moments,
{
    let Known { moving, dynamics, .. } = known;
    add_lanes(on, &mut sums.by_gravity, weight, &dynamics.by_gravity);
    add_lanes(on, &mut sums.by_offsets, weight, &dynamics.by_coordinate);
    let width = BODY * at.chain.link_count();
    for (joint, felt) in at.felt.iter().enumerate() {
        let of_felt = width * joint + BODY * felt.start..width * joint + BODY * felt.end;
        add_lanes(on, &mut sums.by_parameters[of_felt.clone()], weight, &dynamics.by_parameters[of_felt]);
    }
    let [position, velocity, acceleration] = moving.readings();
    let n = position.len();
    for (row, by_gains) in sums.by_position_gains.chunks_exact_mut(n).enumerate() {
        for (joint, by_gain) in by_gains.iter_mut().enumerate() {
            let entry = n * row + joint;
            let by_position = on.load(position[joint]) * on.load(dynamics.by_coordinate[entry]);
            let by_velocity = on.load(velocity[joint]) * on.load(dynamics.by_velocity[entry]);
            let by_acceleration = on.load(acceleration[joint]) * on.load(dynamics.by_acceleration[entry]);
            *by_gain = on.store(on.load(*by_gain) + weight * (by_position + by_velocity + by_acceleration));
        }
    }
}

struct Summed<'a> {
    lanes: &'a mut Lanes<[f64; LANES]>,
    at: &'a At<'a>,
    total: &'a mut Means,
}

impl WithSimd for Summed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Summed { lanes, at, total } = self;
        if let Some(on) = Vectorized::new(simd) {
            lanes.add(on, at, total);
        }
    }
}

#[cfg(test)]
mod tests {
    use gravcal_recording::WeighedStretch;

    use super::*;
    use crate::residuals::pose_torque::model::PoseTorqueModel;
    use crate::residuals::pose_torque::tests::{model_of, some_chain};
    use crate::residuals::testing::ids;
    use crate::sensors::SensorTerms;

    /// Nine moments: two registers of four, and one alone.
    fn course() -> Course {
        let at = |t: usize, joint: usize, phase: f64| (0.7 * t as f64 + joint as f64 + phase).sin();
        let sample = |t: usize| MotionSample {
            time: t as f64,
            position: (0..3).map(|joint| at(t, joint, 0.0)).collect(),
            velocity: (0..3).map(|joint| 2.0 * at(t, joint, 1.0)).collect(),
            acceleration: (0..3).map(|joint| 5.0 * at(t, joint, 2.0)).collect(),
        };
        Course::of(&(0..9).map(|t| (0.1 + 0.01 * t as f64, sample(t))).collect::<Vec<_>>())
    }

    fn asked<'a>(model: &'a PoseTorqueModel, course: &'a Course, links: &'a [f64]) -> At<'a> {
        At {
            chain: &model.chain,
            course,
            gains: &[1.1, 0.9, 1.2],
            offsets: &[0.1, -0.2, 0.3],
            gravity: [1.0, -2.0, -9.0],
            inertia: DynamicParameters { links, rotor_inertia: &[0.0; 3] },
            felt: &model.links,
            derivatives: true,
        }
    }

    #[test]
    fn moments_in_lanes_sum_to_what_they_do_one_by_one() {
        let lengths = [vec![3], vec![1; 12], vec![4, 4, 4, 3, 3, 1]].concat();
        let (model, course) = (model_of(some_chain(), &SensorTerms::default(), &ids(&lengths)), course());
        let chain = &model.chain;
        let links: Vec<f64> = (0..BODY * chain.link_count()).map(|k| (1.3 * k as f64).cos()).collect();
        for derivatives in [false, true] {
            let at = At { derivatives, ..asked(&model, &course, &links) };
            let [mut batch, mut single] = [(); 2].map(|()| Means::new(chain));
            Workspace::new(chain).add(&at, &mut batch);
            Lanes::new(chain).add(Single, &at, &mut single);
            assert!(single.torque.iter().all(|torque| *torque != 0.0));
            assert_eq!(single.by_offsets.iter().any(|entry| *entry != 0.0), derivatives);
            for (batch, single) in batch.lists().into_iter().zip(single.lists()) {
                for (a, b) in batch.iter().zip(single) {
                    assert!((a - *b).abs() <= 1e-12 * b.abs().max(1.0), "{a} {b}");
                }
            }
        }
    }

    /// Two windows that share a stretch, one after the other, to and fro, and with gravity changed in between.
    #[test]
    fn what_is_known_of_a_stretch_is_what_it_would_be_anew() {
        let lengths = [vec![3], vec![1; 12], vec![4, 4, 4, 3, 3, 1]].concat();
        let (model, whole) = (model_of(some_chain(), &SensorTerms::default(), &ids(&lengths)), course());
        let chain = &model.chain;
        let links: Vec<f64> = (0..BODY * chain.link_count()).map(|k| (1.3 * k as f64).cos()).collect();
        let part = |stretches: &[WeighedStretch]| Course { stretches: stretches.to_vec(), kept: Default::default() };
        let windows = [part(&whole.stretches[..2]), part(&whole.stretches[1..])];
        let mut workspace = Workspace::new(chain);
        for (place, gravity, derivatives) in
            [(0, -9.8, true), (1, -9.8, true), (0, -9.8, false), (1, -1.6, true), (0, -1.6, true), (1, -1.6, false)]
        {
            let at = asked(&model, &windows[place], &links);
            let at = At { gravity: [1.0, -2.0, gravity], derivatives, ..at };
            let [mut known, mut anew] = [(); 2].map(|()| Means::new(chain));
            workspace.add(&at, &mut known);
            Workspace::new(chain).add(&at, &mut anew);
            assert!(
                known.lists().into_iter().zip(anew.lists()).all(|(a, b)| a == b),
                "{place} {gravity} {derivatives}"
            );
        }
    }
}
