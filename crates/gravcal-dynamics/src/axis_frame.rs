//! The frame in which a joint's motion is simplest: z along the axis.
//!
//! For every joint the fixed transforms are re-cut once, so that a pose costs two products a joint whatever the
//! direction of its axis:
//!
//! ```text
//!     X_base,link(k) = X_base,link(k−1) · from_parent · (Rot_z(q) or Trans_z(q)) · to_link
//!     from_parent = before · A,   to_link = Aᵀ · after,   A e_z = axis
//! ```
//!
//! `A` is the smallest rotation that brings z to the axis, hence the identity where the axis is z already. One of the two
//! fixed parts is then the identity in most descriptions (`from_parent` of standard Denavit-Hartenberg rows, `to_link` of
//! a URDF), and costs nothing.
//!
//! What a pose passes through is inlined by force: handed over through memory, every step waits for the stores of the
//! one before, which doubles the time of a gravity torque.

use nalgebra::{Matrix3, Vector3};

use crate::arithmetic::{Arithmetic, Single, Stored, columns, matrix};
use crate::frame::Frame;
use crate::joint::{Joint, JointKind};
use crate::transform::Transform;

/// What a coordinate does in the axis frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion<L> {
    /// `Rot_z`.
    Turn { sin: L, cos: L },
    /// `Trans_z`, m.
    Slide(L),
}

/// A joint, re-cut to turn about or slide along z.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AxisFrame {
    kind: JointKind,
    /// Pose of the axis frame in the parent link's frame.
    pub from_parent: FixedTransform,
    /// Pose of the child link's frame in the moved axis frame.
    pub to_link: FixedTransform,
}

/// A constant transform that is not multiplied where it is the identity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FixedTransform {
    transform: Transform,
    is_identity: bool,
}

impl FixedTransform {
    fn new(transform: Transform) -> Self {
        FixedTransform { transform, is_identity: transform == Transform::identity() }
    }

    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.transform.rotation
    }

    /// The frame that this transform leads to from another.
    #[inline(always)]
    fn beyond<A: Arithmetic>(&self, on: A, frame: &Frame<A::Number>) -> Frame<A::Number> {
        if self.is_identity { *frame } else { frame.compose(on, &self.transform) }
    }
}

impl AxisFrame {
    /// Of a joint whose axis has been checked to be a unit vector.
    pub fn of(joint: &Joint) -> Self {
        let z_to_axis = Transform::turned(smallest_rotation_from_z(joint.axis.into()));
        AxisFrame {
            kind: joint.kind,
            from_parent: FixedTransform::new(joint.before * z_to_axis),
            to_link: FixedTransform::new(z_to_axis.inverse() * joint.after),
        }
    }

    /// The axis frame at rest (before the motion) in base coordinates.
    #[inline(always)]
    pub fn at_rest<A: Arithmetic>(&self, on: A, parent: &Frame<A::Number>) -> Frame<A::Number> {
        self.from_parent.beyond(on, parent)
    }

    /// The motion by a coordinate, rad or m.
    #[inline(always)]
    pub fn motion<L: Stored>(&self, coordinate: L) -> Motion<L> {
        match self.kind {
            JointKind::Revolute => {
                let (sin, cos) = coordinate.sin_cos();
                Motion::Turn { sin, cos }
            }
            JointKind::Prismatic => Motion::Slide(coordinate),
        }
    }

    /// The link's frame in base coordinates, from the axis frame at rest and the motion.
    #[inline(always)]
    pub fn link_pose<A: Arithmetic>(
        &self,
        on: A,
        at_rest: &Frame<A::Number>,
        motion: &Motion<A::Stored>,
    ) -> Frame<A::Number> {
        self.to_link.beyond(on, &moved(on, at_rest, motion))
    }

    /// The same of one pose, from the parent link's and the coordinate.
    pub fn link_after(&self, parent: &Transform, coordinate: f64) -> Transform {
        let at_rest = self.at_rest(Single, &Frame::from(*parent));
        self.link_pose(Single, &at_rest, &self.motion(coordinate)).into()
    }
}

/// `frame · Rot_z` or `frame · Trans_z`: touches two columns, or the translation only.
#[inline(always)]
fn moved<A: Arithmetic>(on: A, frame: &Frame<A::Number>, motion: &Motion<A::Stored>) -> Frame<A::Number> {
    let [x, y, z] = columns(&frame.rotation);
    match motion {
        Motion::Turn { sin, cos } => {
            let (sin, cos) = (on.load(*sin), on.load(*cos));
            let rotation = matrix(x * cos + y * sin, y * cos - x * sin, z);
            Frame { rotation, translation: frame.translation }
        }
        Motion::Slide(way) => Frame { rotation: frame.rotation, translation: frame.translation + z * on.load(*way) },
    }
}

/// The rotation by the angle between z and `axis` about `z × axis`.
///
/// Rodrigues' formula with `v = z × axis`, `c = z · axis`: `1 + [v] + [v]²/(1 + c)`. It loses all digits near c = −1, so
/// axes of the lower half space start from −z, to which half a turn about x leads.
fn smallest_rotation_from_z(axis: Vector3<f64>) -> Matrix3<f64> {
    if axis.z >= 0.0 {
        smallest_rotation(Vector3::z(), axis)
    } else {
        smallest_rotation(-Vector3::z(), axis) * Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0))
    }
}

fn smallest_rotation(from: Vector3<f64>, to: Vector3<f64>) -> Matrix3<f64> {
    let cross = from.cross(&to).cross_matrix();
    Matrix3::identity() + cross + cross * cross / (1.0 + from.dot(&to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brings_z_to_every_axis() {
        let axes = [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [1e-9, 0.0, -1.0],
            [0.48, -0.6, -0.64],
        ];
        for axis in axes.map(|a| Vector3::from(a).normalize()) {
            let rotation = smallest_rotation_from_z(axis);
            assert!((rotation * Vector3::z() - axis).norm() < 1e-15, "{axis}");
            assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-14, "{axis}");
            assert!(rotation.determinant() > 0.0, "{axis}");
        }
        assert_eq!(smallest_rotation_from_z(Vector3::z()), Matrix3::identity());
    }
}
