//! One pose at a time, or several at once.
//!
//! What is computed of a pose is written once, for any [`Arithmetic`]: with [`Single`] its numbers are `f64`; with [`Vectorized`] they are
//! vector registers, that hold the numbers of [`LANES`] poses. Each lane has the bits that its pose has alone: nothing is summed
//! across lanes, and no product and sum are fused.
//!
//! All of it is inlined by force into the one function that was compiled for the processor's vector instructions.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use nalgebra::{Matrix3, Scalar, Vector3};
use pulp::{Simd, bytemuck};

/// Poses that are computed in a batch.
pub const LANES: usize = 4;

/// How numbers are computed.
pub trait Arithmetic: Copy {
    /// A number as it lies in memory: one, or one for each lane.
    type Stored: Stored;
    /// A number that is computed with.
    type Number: Number;

    /// The same in each lane.
    fn constant(self, number: f64) -> Self::Number;

    /// From memory.
    fn load(self, stored: Self::Stored) -> Self::Number;

    /// To memory.
    fn store(self, number: Self::Number) -> Self::Stored;
}

/// What numbers of any arithmetic have in common.
pub trait Number:
    Scalar
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
}

impl Number for f64 {}
impl<S: Simd> Number for Lanes<S> {}

/// What numbers in memory have in common.
pub trait Stored: Scalar + Copy {
    /// Zero in each lane.
    const ZERO: Self;

    /// Whether both are the same to the bit.
    fn same(self, other: Self) -> bool;

    /// Sine and cosine; not the system's, so that a pose has the same bits on every system.
    fn sin_cos(self) -> (Self, Self);
}

impl Stored for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn same(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
}

impl Stored for [f64; LANES] {
    const ZERO: Self = [0.0; LANES];

    #[inline(always)]
    fn same(self, other: Self) -> bool {
        self.iter().zip(&other).all(|(a, b)| a.to_bits() == b.to_bits())
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (mut sin, mut cos) = (Self::ZERO, Self::ZERO);
        for (lane, number) in self.iter().enumerate() {
            (sin[lane], cos[lane]) = libm::sincos(*number);
        }
        (sin, cos)
    }
}

/// One pose at a time.
#[derive(Clone, Copy, Debug)]
pub struct Single;

impl Arithmetic for Single {
    type Stored = f64;
    type Number = f64;

    #[inline(always)]
    fn constant(self, number: f64) -> f64 {
        number
    }

    #[inline(always)]
    fn load(self, stored: f64) -> f64 {
        stored
    }

    #[inline(always)]
    fn store(self, number: f64) -> f64 {
        number
    }
}

/// [`LANES`] batched poses, by vector instructions that have as many lanes.
#[derive(Clone, Copy, Debug)]
pub struct Vectorized<S>(S);

impl<S: Simd> Vectorized<S> {
    /// With these instructions; nothing if their registers have another number of lanes.
    #[inline(always)]
    pub fn new(simd: S) -> Option<Self> {
        (S::F64_LANES == LANES).then_some(Vectorized(simd))
    }
}

impl<S: Simd> Arithmetic for Vectorized<S> {
    type Stored = [f64; LANES];
    type Number = Lanes<S>;

    #[inline(always)]
    fn constant(self, number: f64) -> Lanes<S> {
        Lanes { simd: self.0, register: self.0.splat_f64s(number) }
    }

    #[inline(always)]
    fn load(self, stored: [f64; LANES]) -> Lanes<S> {
        Lanes { simd: self.0, register: bytemuck::cast(stored) }
    }

    #[inline(always)]
    fn store(self, number: Lanes<S>) -> [f64; LANES] {
        bytemuck::cast(number.register)
    }
}

/// A vector register, and what computes with it.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    simd: S,
    register: S::f64s,
}

/// To the bit: what nalgebra asks of a scalar.
impl<S: Simd> PartialEq for Lanes<S> {
    fn eq(&self, other: &Self) -> bool {
        bytemuck::bytes_of(&self.register) == bytemuck::bytes_of(&other.register)
    }
}

macro_rules! lane_by_lane {
    ($operation:ident, $method:ident, $assigning:ident, $assign:ident, $instruction:ident) => {
        impl<S: Simd> $operation for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Lanes { simd: self.simd, register: self.simd.$instruction(self.register, other.register) }
            }
        }

        impl<S: Simd> $assigning for Lanes<S> {
            #[inline(always)]
            fn $assign(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    };
}

lane_by_lane!(Add, add, AddAssign, add_assign, add_f64s);
lane_by_lane!(Sub, sub, SubAssign, sub_assign, sub_f64s);
lane_by_lane!(Mul, mul, MulAssign, mul_assign, mul_f64s);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Lanes { simd: self.simd, register: self.simd.neg_f64s(self.register) }
    }
}

// nalgebra's products, and closures that arrays are mapped by, are not inlined by force.

#[inline(always)]
pub(crate) fn cross<N: Number>(a: &Vector3<N>, b: &Vector3<N>) -> Vector3<N> {
    Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

#[inline(always)]
pub(crate) fn dot<N: Number>(a: &Vector3<N>, b: &Vector3<N>) -> N {
    a.x * b.x + a.y * b.y + a.z * b.z
}

#[inline(always)]
pub(crate) fn columns<N: Scalar + Copy>(m: &Matrix3<N>) -> [Vector3<N>; 3] {
    [Vector3::new(m.m11, m.m21, m.m31), Vector3::new(m.m12, m.m22, m.m32), Vector3::new(m.m13, m.m23, m.m33)]
}

/// The matrix with these columns.
#[inline(always)]
pub(crate) fn matrix<N: Scalar + Copy>(x: Vector3<N>, y: Vector3<N>, z: Vector3<N>) -> Matrix3<N> {
    Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)
}

/// `M v`.
#[inline(always)]
pub(crate) fn times<N: Number>(m: &Matrix3<N>, v: &Vector3<N>) -> Vector3<N> {
    Vector3::new(
        m.m11 * v.x + m.m12 * v.y + m.m13 * v.z,
        m.m21 * v.x + m.m22 * v.y + m.m23 * v.z,
        m.m31 * v.x + m.m32 * v.y + m.m33 * v.z,
    )
}

/// `Mᵀ v`.
#[inline(always)]
pub(crate) fn transposed_times<N: Number>(m: &Matrix3<N>, v: &Vector3<N>) -> Vector3<N> {
    let [x, y, z] = columns(m);
    Vector3::new(dot(&x, v), dot(&y, v), dot(&z, v))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct HaveLanes;

    impl pulp::WithSimd for HaveLanes {
        type Output = bool;

        fn with_simd<S: Simd>(self, simd: S) -> bool {
            Vectorized::new(simd).is_some()
        }
    }

    /// Else the tests of batched poses would compare nothing, and nobody would see it.
    #[test]
    #[cfg(target_arch = "x86_64")]
    fn a_processor_with_avx2_computes_four_lanes() {
        let able = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt");
        assert_eq!(pulp::Arch::new().dispatch(HaveLanes), able);
    }
}
