//! A frame on its way from the base outward.

use nalgebra::{Matrix3, Vector3};

use crate::arithmetic::{Arithmetic, Number, columns, matrix, times};
use crate::transform::Transform;

/// Pose of a frame in base coordinates: rotation and translation (m), of one pose of the arm or of several.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<N> {
    pub rotation: Matrix3<N>,
    pub translation: Vector3<N>,
}

impl<N: Number> Frame<N> {
    /// A constant transform in all poses.
    #[inline(always)]
    pub fn constant<A: Arithmetic<Number = N>>(on: A, transform: &Transform) -> Self {
        let [x, y, z] = columns(&transform.rotation);
        let rotation = matrix(constant(on, &x), constant(on, &y), constant(on, &z));
        Frame { rotation, translation: constant(on, &transform.translation) }
    }

    /// The frame that a constant transform leads to from this one.
    #[inline(always)]
    pub fn compose<A: Arithmetic<Number = N>>(&self, on: A, transform: &Transform) -> Self {
        let step = Self::constant(on, transform);
        let [x, y, z] = columns(&step.rotation);
        Frame {
            rotation: matrix(times(&self.rotation, &x), times(&self.rotation, &y), times(&self.rotation, &z)),
            translation: times(&self.rotation, &step.translation) + self.translation,
        }
    }
}

impl From<Transform> for Frame<f64> {
    fn from(transform: Transform) -> Self {
        Frame { rotation: transform.rotation, translation: transform.translation }
    }
}

impl From<Frame<f64>> for Transform {
    fn from(frame: Frame<f64>) -> Self {
        Transform { rotation: frame.rotation, translation: frame.translation }
    }
}

/// The same vector in all poses.
#[inline(always)]
pub(crate) fn constant<A: Arithmetic>(on: A, vector: &Vector3<f64>) -> Vector3<A::Number> {
    Vector3::new(on.constant(vector.x), on.constant(vector.y), on.constant(vector.z))
}

/// A vector from memory.
#[inline(always)]
pub(crate) fn load<A: Arithmetic>(on: A, vector: &Vector3<A::Stored>) -> Vector3<A::Number> {
    Vector3::new(on.load(vector.x), on.load(vector.y), on.load(vector.z))
}

/// A vector to memory.
#[inline(always)]
pub(crate) fn store<A: Arithmetic>(on: A, vector: &Vector3<A::Number>) -> Vector3<A::Stored> {
    Vector3::new(on.store(vector.x), on.store(vector.y), on.store(vector.z))
}
