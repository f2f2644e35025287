//! Gravity as a link sees it.
//!
//! ```text
//!     v = R_kᵀ g
//!     ∂v/∂g = R_kᵀ,    ∂v/∂q_j = R_kᵀ (g × z_j)   revolute j that moves link k,   0   otherwise
//! ```
//!
//! (summed, times its multiplier, over the axes that follow a joint) with `R_k` the rotation of link k's frame and `z_j` the direction of axis j in base coordinates (a turn by δ about z_j
//! takes `R_kᵀ` to `R_kᵀ (1 − δ [z_j])`).

use nalgebra::Vector3;

use crate::arithmetic::Single;
use crate::chain::Chain;
use crate::frame::Frame;
use crate::joint::JointKind;
use crate::transform::Transform;

/// Gravity in a link's frame with its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkGravity {
    /// m/s².
    pub value: [f64; 3],
    /// By gravity in base coordinates, row-major.
    pub by_gravity: [[f64; 3]; 3],
    /// By the coordinate of each joint, m/s² a rad (or a m); zero for those that do not move the link.
    pub by_coordinate: Vec<[f64; 3]>,
}

impl Chain {
    /// Gravity in the frame of a link. `coordinates`: of all joints, rad or m; `gravity`: m/s² in base coordinates.
    ///
    /// # Panics
    ///
    /// When `coordinates` has not `joint_count()` entries, or there is no such link.
    pub fn link_gravity(&self, link: usize, coordinates: &[f64], gravity: [f64; 3]) -> LinkGravity {
        let gravity = Vector3::from(gravity);
        let coordinates = self.axis_coordinates(coordinates);
        let mut pose = Frame::from(Transform::identity());
        let mut turned = vec![Vector3::zeros(); self.joint_count()];
        for axis in self.path(link) {
            let (frame, drive) = (&self.axis_frames[axis], self.drive(axis));
            let at_rest = frame.at_rest(Single, &pose);
            if self.movers()[axis].kind == JointKind::Revolute {
                turned[drive.joint] += gravity.cross(&at_rest.rotation.column(2)) * drive.multiplier;
            }
            pose = frame.link_pose(Single, &at_rest, &frame.motion(coordinates[axis]));
        }
        let seen = |vector: &Vector3<f64>| pose.rotation.tr_mul(vector).into();
        let row = |axis: usize| pose.rotation.column(axis).into_owned().into();
        LinkGravity {
            value: seen(&gravity),
            by_gravity: [row(0), row(1), row(2)],
            by_coordinate: turned.iter().map(seen).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::random_chain::{Pose, pose};

    /// Step of the central differences.
    const STEP: f64 = 1e-5;
    /// What they leave of some ten m/s² where axes that follow turn the link up to seven times as fast as the joint:
    /// STEP² 7³ / 6 of it.
    const DIFFERENCE: f64 = 1e-7;

    fn seen(pose: &Pose) -> Vector3<f64> {
        pose.chain.link_gravity(pose.chain.link_count() - 1, &pose.coordinates, pose.gravity).value.into()
    }

    fn difference(pose: &Pose, change: impl Fn(&mut Pose, f64)) -> Vector3<f64> {
        let moved = |step| {
            let mut pose = pose.clone();
            change(&mut pose, step);
            seen(&pose)
        };
        (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
    }

    proptest! {
        #[test]
        fn it_is_gravity_in_the_frame_of_forward_kinematics(pose in pose()) {
            let last = pose.chain.forward(&pose.coordinates).pop().unwrap();
            let back: Vector3<f64> = last.rotate_vector(seen(&pose).into()).into();
            prop_assert!((back - Vector3::from(pose.gravity)).norm() < 1e-12);
        }

        #[test]
        fn derivatives_are_slopes(pose in pose()) {
            let last = pose.chain.link_count() - 1;
            let linearized = pose.chain.link_gravity(last, &pose.coordinates, pose.gravity);
            for (j, by) in linearized.by_coordinate.iter().enumerate() {
                let slope = difference(&pose, |pose, step| pose.coordinates[j] += step);
                prop_assert!((slope - Vector3::from(*by)).norm() < DIFFERENCE, "{j}: {slope} {by:?}");
            }
            for axis in 0..3 {
                let slope = difference(&pose, |pose, step| pose.gravity[axis] += step);
                let by = Vector3::from([0, 1, 2].map(|row| linearized.by_gravity[row][axis]));
                prop_assert!((slope - by).norm() < DIFFERENCE, "{axis}: {slope} {by:?}");
            }
        }
    }
}
