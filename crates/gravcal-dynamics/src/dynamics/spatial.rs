//! Rigid motions and what resists them, about the origin of the base and along its axes.

use nalgebra::Vector3;

use crate::arithmetic::{Arithmetic, Number, Stored, cross, dot};
use crate::frame::{load, store};

/// A rigid motion, or its rate: `u(r) = linear + angular × r`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist<N> {
    pub angular: Vector3<N>,
    /// Of the point that is at the base's origin.
    pub linear: Vector3<N>,
}

/// Force, and moment about the base's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrench<N> {
    pub force: Vector3<N>,
    pub moment: Vector3<N>,
}

impl<N: Number> Twist<N> {
    /// Of the point at `place`.
    #[inline(always)]
    pub fn at(&self, place: &Vector3<N>) -> Vector3<N> {
        self.linear + cross(&self.angular, place)
    }

    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Twist { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }

    #[inline(always)]
    pub fn times(&self, factor: N) -> Self {
        Twist { angular: self.angular * factor, linear: self.linear * factor }
    }

    /// The rate of `other` that this motion carries along: `u × s`.
    #[inline(always)]
    pub fn cross(&self, other: &Self) -> Self {
        Twist {
            angular: cross(&self.angular, &other.angular),
            linear: cross(&self.angular, &other.linear) + cross(&self.linear, &other.angular),
        }
    }

    /// The rate of a wrench that this motion carries along: `u ×* F`.
    #[inline(always)]
    pub fn carried(&self, wrench: &Wrench<N>) -> Wrench<N> {
        Wrench {
            force: cross(&self.angular, &wrench.force),
            moment: cross(&self.angular, &wrench.moment) + cross(&self.linear, &wrench.force),
        }
    }

    /// What a wrench does along the motion: `u · F`.
    #[inline(always)]
    pub fn dot(&self, wrench: &Wrench<N>) -> N {
        dot(&self.angular, &wrench.moment) + dot(&self.linear, &wrench.force)
    }
}

impl<L: Stored> Twist<L> {
    pub const ZERO: Self = Twist { angular: zero(), linear: zero() };

    #[inline(always)]
    pub fn load<A: Arithmetic<Stored = L>>(&self, on: A) -> Twist<A::Number> {
        Twist { angular: load(on, &self.angular), linear: load(on, &self.linear) }
    }

    #[inline(always)]
    pub fn store<A: Arithmetic<Stored = L>>(on: A, twist: &Twist<A::Number>) -> Self {
        Twist { angular: store(on, &twist.angular), linear: store(on, &twist.linear) }
    }
}

impl<N: Number> Wrench<N> {
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Wrench { force: self.force + other.force, moment: self.moment + other.moment }
    }
}

impl<L: Stored> Wrench<L> {
    pub const ZERO: Self = Wrench { force: zero(), moment: zero() };

    #[inline(always)]
    pub fn load<A: Arithmetic<Stored = L>>(&self, on: A) -> Wrench<A::Number> {
        Wrench { force: load(on, &self.force), moment: load(on, &self.moment) }
    }

    #[inline(always)]
    pub fn store<A: Arithmetic<Stored = L>>(on: A, wrench: &Wrench<A::Number>) -> Self {
        Wrench { force: store(on, &wrench.force), moment: store(on, &wrench.moment) }
    }
}

pub(super) const fn zero<L: Stored>() -> Vector3<L> {
    Vector3::new(L::ZERO, L::ZERO, L::ZERO)
}
