//! Moments of a window, as many at once as vector registers have lanes: see [`gravcal_dynamics::Arithmetic`].

use gravcal_dynamics::{Arithmetic, JointMotion, LANES, Stored};
use gravcal_recording::{Course, MotionSample};

/// A number of each of several moments.
pub(super) trait Moments: Stored {
    const COUNT: usize;
    /// Of a moment each.
    fn of(number: impl Fn(usize) -> f64) -> Self;
    fn map(self, change: impl Fn(f64) -> f64) -> Self;
    fn sum(self) -> f64;
}

impl Moments for f64 {
    const COUNT: usize = 1;

    #[inline(always)]
    fn of(number: impl Fn(usize) -> f64) -> Self {
        number(0)
    }

    #[inline(always)]
    fn map(self, change: impl Fn(f64) -> f64) -> Self {
        change(self)
    }

    fn sum(self) -> f64 {
        self
    }
}

impl Moments for [f64; LANES] {
    const COUNT: usize = LANES;

    #[inline(always)]
    fn of(number: impl Fn(usize) -> f64) -> Self {
        std::array::from_fn(number)
    }

    #[inline(always)]
    fn map(self, change: impl Fn(f64) -> f64) -> Self {
        <[f64; LANES]>::map(self, change)
    }

    fn sum(self) -> f64 {
        self.iter().sum()
    }
}

/// How an arm moves at several moments, n numbers each.
pub(super) struct Moving<L> {
    /// What its position sensors read, and that per second and per second squared.
    readings: [Vec<L>; 3],
    coordinates: Vec<L>,
    velocities: Vec<L>,
    accelerations: Vec<L>,
}

impl<L: Moments> Moving<L> {
    pub fn new(joints: usize) -> Self {
        let zeros = || vec![L::ZERO; joints];
        Moving {
            readings: [(); 3].map(|()| zeros()),
            coordinates: zeros(),
            velocities: zeros(),
            accelerations: zeros(),
        }
    }

    /// Of at most [`Moments::COUNT`] moments; lanes without one repeat the first. `positions`: gain and offset of each joint's sensor.
    #[inline(always)]
    pub fn set(&mut self, moments: &[MotionSample], positions: impl Iterator<Item = [f64; 2]>) {
        let [position, velocity, acceleration] = &mut self.readings;
        for (joint, [gain, offset]) in positions.enumerate() {
            position[joint] = of_each(moments, |moment| moment.position[joint]);
            velocity[joint] = of_each(moments, |moment| moment.velocity[joint]);
            acceleration[joint] = of_each(moments, |moment| moment.acceleration[joint]);
            self.coordinates[joint] = position[joint].map(|reading| gain * reading + offset);
            self.velocities[joint] = velocity[joint].map(|reading| gain * reading);
            self.accelerations[joint] = acceleration[joint].map(|reading| gain * reading);
        }
    }

    /// Position, velocity and acceleration as they were read.
    pub fn readings(&self) -> &[Vec<L>; 3] {
        &self.readings
    }

    #[inline(always)]
    pub fn of_joints(&self) -> JointMotion<'_, L> {
        let Moving { coordinates, velocities, accelerations, .. } = self;
        JointMotion { coordinates, velocities, accelerations }
    }
}

/// A number of each moment.
#[inline(always)]
fn of_each<L: Moments>(moments: &[MotionSample], number: impl Fn(&MotionSample) -> f64) -> L {
    L::of(|lane| number(moments.get(lane).unwrap_or(&moments[0])))
}

/// The moments of a window, as many at once as there are lanes, with their shares.
pub(super) fn at_once<L: Moments>(course: &Course) -> impl Iterator<Item = (&[MotionSample], &[f64])> {
    course.stretches.iter().flat_map(|stretch| stretch.moments.chunks(L::COUNT).zip(stretch.weights.chunks(L::COUNT)))
}

/// The share of each moment; nothing in lanes that have none.
#[inline(always)]
pub(super) fn weights<L: Moments>(shares: &[f64]) -> L {
    L::of(|lane| shares.get(lane).copied().unwrap_or(0.0))
}

/// `sum += weight · terms`, entry by entry.
#[inline(always)]
pub(super) fn add_lanes<A: Arithmetic>(on: A, sum: &mut [A::Stored], weight: A::Number, terms: &[A::Stored]) {
    for (sum, term) in sum.iter_mut().zip(terms) {
        *sum = on.store(on.load(*sum) + weight * on.load(*term));
    }
}
