//! Where a link is, and how that changes with the joints' coordinates.
//!
//! ```text
//!     ∂R/∂q_j = [z_j] R,    ∂p/∂q_j = z_j × (p − o_j)   revolute j that moves the link
//!     ∂R/∂q_j = 0,          ∂p/∂q_j = z_j               prismatic j that moves it
//! ```
//!
//! (summed, times its multiplier, over the axes that follow a joint) with `R` and `p` the pose of the link's frame in the base's, `z_j`
//! the direction of axis j and `o_j` a point on it, both in base coordinates.

use nalgebra::{Matrix3, Vector3};

use crate::arithmetic::Single;
use crate::chain::Chain;
use crate::frame::Frame;
use crate::joint::JointKind;
use crate::transform::Transform;

/// A link's frame in the base's with its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkFrame {
    /// Its rotation, row-major.
    pub rotation: [[f64; 3]; 3],
    /// Its origin, m.
    pub origin: [f64; 3],
    /// The derivative of both by the coordinate of each joint, a rad (or a m); zero for those that do not move the link.
    pub by_coordinate: Vec<([[f64; 3]; 3], [f64; 3])>,
}

impl Chain {
    /// The frame of a link. `coordinates`: of all joints, rad or m.
    ///
    /// # Panics
    ///
    /// When `coordinates` has not `joint_count()` entries, or there is no such link.
    pub fn link_frame(&self, link: usize, coordinates: &[f64]) -> LinkFrame {
        let coordinates = self.axis_coordinates(coordinates);
        let mut pose = Frame::from(Transform::identity());
        let mut passed = Vec::new();
        for axis in self.path(link) {
            let frame = &self.axis_frames[axis];
            let at_rest = frame.at_rest(Single, &pose);
            passed.push((axis, at_rest.rotation.column(2).into_owned(), at_rest.translation));
            pose = frame.link_pose(Single, &at_rest, &frame.motion(coordinates[axis]));
        }
        let mut by_coordinate = vec![(Matrix3::zeros(), Vector3::zeros()); self.joint_count()];
        for (axis, direction, point) in passed {
            let drive = self.drive(axis);
            let (by_rotation, by_origin) = match self.movers()[axis].kind {
                JointKind::Revolute => {
                    (direction.cross_matrix() * pose.rotation, direction.cross(&(pose.translation - point)))
                }
                JointKind::Prismatic => (Matrix3::zeros(), direction),
            };
            by_coordinate[drive.joint].0 += by_rotation * drive.multiplier;
            by_coordinate[drive.joint].1 += by_origin * drive.multiplier;
        }
        let by_coordinate =
            by_coordinate.into_iter().map(|(by_rotation, by_origin)| (rows(&by_rotation), by_origin.into()));
        LinkFrame {
            rotation: rows(&pose.rotation),
            origin: pose.translation.into(),
            by_coordinate: by_coordinate.collect(),
        }
    }
}

fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::random_chain::{Pose, pose};

    /// Step of the central differences, and what they leave of lengths up to some metres.
    const STEP: f64 = 1e-5;
    const DIFFERENCE: f64 = 1e-7;

    /// All twelve numbers of a frame.
    fn numbers(rotation: [[f64; 3]; 3], origin: [f64; 3]) -> Vec<f64> {
        rotation.into_iter().flatten().chain(origin).collect()
    }

    fn last(pose: &Pose) -> LinkFrame {
        pose.chain.link_frame(pose.chain.link_count() - 1, &pose.coordinates)
    }

    proptest! {
        #[test]
        fn it_is_that_of_forward_kinematics_and_derivatives_are_slopes(pose in pose()) {
            let found = last(&pose);
            let frame = pose.chain.forward(&pose.coordinates).pop().unwrap();
            prop_assert_eq!((found.rotation, found.origin), (frame.rotation(), frame.translation()));
            for (joint, (by_rotation, by_origin)) in found.by_coordinate.iter().enumerate() {
                let moved = |step| {
                    let mut pose = pose.clone();
                    pose.coordinates[joint] += step;
                    let LinkFrame { rotation, origin, .. } = last(&pose);
                    numbers(rotation, origin)
                };
                let slopes = moved(STEP).into_iter().zip(moved(-STEP)).map(|(up, down)| (up - down) / (2.0 * STEP));
                for (slope, by) in slopes.zip(numbers(*by_rotation, *by_origin)) {
                    prop_assert!((slope - by).abs() < DIFFERENCE, "{joint}: {slope} {by}");
                }
            }
        }
    }
}
