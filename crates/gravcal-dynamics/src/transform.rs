//! Rigid transforms between frames.
//!
//! `X_AB` holds the rotation `R_AB` and the position `p` of B's origin in A: a point with coordinates `r` in B has the
//! coordinates `R_AB r + p` in A, and `X_AC = X_AB * X_BC`.

use std::ops::Mul;

use nalgebra::{Matrix3, Vector3};

/// Largest entry of `RᵀR − 1` with which a matrix still passes as a rotation: what eight printed digits leave.
const ORTHOGONALITY: f64 = 1e-7;

/// Pose of one frame in another: rotation (row-major, without unit) and translation (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) translation: Vector3<f64>,
}

/// A 3×3 matrix that is no rotation: not orthogonal within 1e-7, mirrored, or not finite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{0:?} is not a rotation matrix: its rows must be perpendicular unit vectors (within 1e-7) in right-handed order; \
     check for swapped rows, a sign, or degrees in place of radians"
)]
pub struct NotARotation(pub [[f64; 3]; 3]);

impl Transform {
    /// The two frames coincide.
    pub fn identity() -> Self {
        Transform { rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// From a rotation matrix (row-major) and a translation in m.
    ///
    /// # Errors
    ///
    /// [`NotARotation`] when the matrix is not orthogonal, or mirrors.
    pub fn from_rotation(rotation: [[f64; 3]; 3], translation: [f64; 3]) -> Result<Self, NotARotation> {
        let matrix = Matrix3::from_fn(|row, column| rotation[row][column]);
        let deviation = (matrix.transpose() * matrix - Matrix3::identity()).abs().max();
        // Written so that a NaN is refused as well.
        let is_rotation = deviation <= ORTHOGONALITY && matrix.determinant() > 0.0;
        if !is_rotation {
            return Err(NotARotation(rotation));
        }
        Ok(Transform { rotation: matrix, translation: translation.into() })
    }

    /// URDF's `<origin xyz rpy>`: `R = Rot_z(yaw) Rot_y(pitch) Rot_x(roll)`, angles in rad about fixed axes, m.
    pub fn from_xyz_rpy(xyz: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Self {
        Self::along(xyz) * Self::about_z(yaw) * Self::about_y(pitch) * Self::about_x(roll)
    }

    /// A pure translation, m.
    pub fn along(translation: [f64; 3]) -> Self {
        Transform { rotation: Matrix3::identity(), translation: translation.into() }
    }

    /// A pure rotation by `angle` (rad) about x.
    pub fn about_x(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self::turned(Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos))
    }

    /// A pure rotation by `angle` (rad) about y.
    pub fn about_y(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self::turned(Matrix3::new(cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos))
    }

    /// A pure rotation by `angle` (rad) about z.
    pub fn about_z(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self::turned(Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0))
    }

    pub(crate) fn turned(rotation: Matrix3<f64>) -> Self {
        Transform { rotation, translation: Vector3::zeros() }
    }

    /// The rotation matrix, row-major: column j is B's axis j in A.
    pub fn rotation(&self) -> [[f64; 3]; 3] {
        rows(&self.rotation)
    }

    /// B's origin in A, m.
    pub fn translation(&self) -> [f64; 3] {
        self.translation.into()
    }

    /// `X_AC = X_AB.compose(&X_BC)`, the same as `X_AB * X_BC`.
    pub fn compose(&self, other: &Transform) -> Transform {
        Transform {
            rotation: self.rotation * other.rotation,
            translation: self.rotation * other.translation + self.translation,
        }
    }

    /// `X_BA`.
    pub fn inverse(&self) -> Transform {
        let rotation = self.rotation.transpose();
        Transform { rotation, translation: -(rotation * self.translation) }
    }

    /// Coordinates in A of a point given in B, m.
    pub fn transform_point(&self, point: [f64; 3]) -> [f64; 3] {
        (self.rotation * Vector3::from(point) + self.translation).into()
    }

    /// Coordinates in A of a free vector (a direction, a first moment, gravity) given in B, in its own unit.
    pub fn rotate_vector(&self, vector: [f64; 3]) -> [f64; 3] {
        (self.rotation * Vector3::from(vector)).into()
    }

    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.rotation.iter().chain(&self.translation).all(|value| value.is_finite())
    }
}

impl Mul for Transform {
    type Output = Transform;

    fn mul(self, other: Transform) -> Transform {
        self.compose(&other)
    }
}

/// A matrix as row-major nested arrays.
pub(crate) fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn assert_close(left: [f64; 3], right: [f64; 3]) {
        assert!(left.iter().zip(right).all(|(l, r)| (l - r).abs() < 1e-15), "{left:?} is not {right:?}");
    }

    #[test]
    fn roll_comes_first_and_yaw_last_about_fixed_axes() {
        // Roll brings y to z, which pitch brings to x, which yaw brings to y.
        let x = Transform::from_xyz_rpy([1.0, 2.0, 3.0], [FRAC_PI_2, FRAC_PI_2, FRAC_PI_2]);
        assert_close(x.rotate_vector([0.0, 1.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_close(x.transform_point([0.0, 1.0, 0.0]), [1.0, 3.0, 3.0]);
    }

    #[test]
    fn inverse_undoes() {
        let x = Transform::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, -0.5, 0.6]);
        let back = x.inverse() * x;
        assert!((back.rotation - Matrix3::identity()).abs().max() < 1e-15);
        assert!(back.translation.norm() < 1e-15);
    }

    #[test]
    fn round_trip_through_rows() {
        let x = Transform::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, -0.5, 0.6]);
        assert_eq!(Transform::from_rotation(x.rotation(), x.translation()), Ok(x));
    }

    #[test]
    fn refuses_what_is_no_rotation() {
        let mirror = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        let sheared = [[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for bad in [mirror, sheared, [[f64::NAN; 3]; 3]] {
            let error = Transform::from_rotation(bad, [0.0; 3]).unwrap_err();
            assert!(error.to_string().contains("not a rotation matrix"), "{error}");
        }
    }
}
