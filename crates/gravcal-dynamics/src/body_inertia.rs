//! What a rigid body does to forces: ten numbers.
//!
//! ```text
//!     π = [m, h_x, h_y, h_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz],      h = ∫ r dm,   I = ∫ (r·r 1 − r rᵀ) dm
//! ```
//!
//! with `r` counted from the origin of the frame in which they are told, **not** from the centre of mass: so bodies that hang together
//! add up, and the torque of an arm in motion is linear in them. Order and signs are Pinocchio's (`toDynamicParameters`).
//!
//! In another frame, whose origin is at `t` and whose axes are the columns of `R`,
//!
//! ```text
//!     h' = Rᵀ (h − m t),      E' = Rᵀ (E − h tᵀ − t hᵀ + m t tᵀ) R,      E = ∫ r rᵀ dm = ½ tr(I) 1 − I
//! ```

use std::ops::Add;

use nalgebra::{Matrix3, Vector3};

use crate::transform::Transform;

/// Numbers of a rigid body.
pub(crate) const BODY: usize = 10;

/// A rigid body: a link, or a load. Loads add to the link that carries them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyInertia {
    /// Mass, kg.
    pub mass: f64,
    /// Mass times centre of mass, kg·m.
    pub first_moment: [f64; 3],
    /// `[I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]` about the frame's origin, kg·m².
    pub tensor: [f64; 6],
}

impl BodyInertia {
    /// From what a data sheet or a URDF states: the centre of mass (m), and the tensor about it, along the frame's axes (kg·m²).
    pub fn about_center(mass: f64, center: [f64; 3], tensor: [f64; 6]) -> Self {
        let center = Vector3::from(center);
        let shifted = matrix(tensor) + (Matrix3::identity() * center.dot(&center) - center * center.transpose()) * mass;
        BodyInertia { mass, first_moment: (center * mass).into(), tensor: six(&shifted) }
    }

    /// The same body told in another frame, whose pose in this one is `frame`.
    ///
    /// A body that is told in its own frame, and stands at the pose `X` in a link's frame, is `in_frame(&X.inverse())` there.
    pub fn in_frame(&self, frame: &Transform) -> Self {
        let (first, way) = (Vector3::from(self.first_moment), frame.translation);
        let crossed = first * way.transpose();
        let about =
            second_moment(&matrix(self.tensor)) - crossed - crossed.transpose() + way * way.transpose() * self.mass;
        let turned = frame.rotation.transpose() * about * frame.rotation;
        BodyInertia {
            mass: self.mass,
            first_moment: frame.rotation.tr_mul(&(first - way * self.mass)).into(),
            tensor: six(&(Matrix3::identity() * turned.trace() - turned)),
        }
    }

    /// The ten numbers in their order.
    pub fn parameters(&self) -> [f64; BODY] {
        let BodyInertia { mass, first_moment: [x, y, z], tensor: [xx, xy, yy, xz, yz, zz] } = *self;
        [mass, x, y, z, xx, xy, yy, xz, yz, zz]
    }
}

/// Both bodies as one; told in the same frame.
impl Add for BodyInertia {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        BodyInertia {
            mass: self.mass + other.mass,
            first_moment: std::array::from_fn(|axis| self.first_moment[axis] + other.first_moment[axis]),
            tensor: std::array::from_fn(|entry| self.tensor[entry] + other.tensor[entry]),
        }
    }
}

/// `∫ r rᵀ dm` of a tensor.
fn second_moment(tensor: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (0.5 * tensor.trace()) - tensor
}

/// The symmetric matrix of `[xx, xy, yy, xz, yz, zz]`.
pub(crate) fn matrix([xx, xy, yy, xz, yz, zz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// `[xx, xy, yy, xz, yz, zz]` of a symmetric matrix.
pub(crate) fn six(tensor: &Matrix3<f64>) -> [f64; 6] {
    [tensor.m11, tensor.m12, tensor.m22, tensor.m13, tensor.m23, tensor.m33]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body of point masses: `(mass, place)`.
    const POINTS: [(f64, [f64; 3]); 4] =
        [(1.0, [0.1, 0.2, -0.3]), (2.0, [-0.4, 0.0, 0.5]), (0.5, [0.0, 0.7, 0.1]), (1.5, [0.3, -0.2, 0.0])];

    fn of_points(points: impl Iterator<Item = (f64, [f64; 3])>) -> BodyInertia {
        points
            .map(|(mass, place)| BodyInertia::about_center(mass, place, [0.0; 6]))
            .fold(BodyInertia::default(), Add::add)
    }

    fn assert_close(left: BodyInertia, right: BodyInertia) {
        let close = left.parameters().iter().zip(right.parameters()).all(|(l, r)| (l - r).abs() < 1e-14);
        assert!(close, "{left:?} is not {right:?}");
    }

    #[test]
    fn a_point_resists_turning_about_the_axes_that_it_is_away_from() {
        let body = BodyInertia::about_center(2.0, [3.0, 0.0, 1.0], [0.0; 6]);
        assert_eq!(body.parameters(), [2.0, 6.0, 0.0, 2.0, 2.0, 0.0, 20.0, -6.0, 0.0, 18.0]);
    }

    #[test]
    fn a_frame_sees_the_points_where_they_are_in_it() {
        let frame = Transform::from_xyz_rpy([0.5, -0.6, 0.7], [0.4, -1.1, 2.0]);
        let back = frame.inverse();
        let seen = of_points(POINTS.iter().map(|(mass, place)| (*mass, back.transform_point(*place))));
        assert_close(of_points(POINTS.into_iter()).in_frame(&frame), seen);
    }

    #[test]
    fn the_tensor_about_the_centre_is_shifted_to_the_origin() {
        let body = of_points(POINTS.into_iter());
        let center = body.first_moment.map(|moment| moment / body.mass);
        let about_center = body.in_frame(&Transform::along(center));
        assert!(about_center.first_moment.iter().all(|moment| moment.abs() < 1e-15));
        assert_close(BodyInertia::about_center(body.mass, center, about_center.tensor), body);
    }
}
