//! Forward kinematics: where every link is.

use crate::chain::Chain;
use crate::transform::Transform;

impl Chain {
    /// Pose of every link's frame in base coordinates, proximal first.
    ///
    /// `coordinates`: the true coordinate of every joint, rad or m.
    ///
    /// # Panics
    ///
    /// When `coordinates` has not `joint_count()` entries.
    pub fn forward(&self, coordinates: &[f64]) -> Vec<Transform> {
        assert_eq!(coordinates.len(), self.joint_count(), "one coordinate for each joint");
        let mut pose = Transform::identity();
        self.axis_frames
            .iter()
            .zip(coordinates)
            .map(|(frame, &coordinate)| {
                pose = frame.link_pose(&frame.at_rest(&pose), frame.motion(coordinate));
                pose
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::joint::{Joint, JointKind};
    use crate::random_chain::pose;

    /// The motion of a joint in its own frame, by Rodrigues' formula written out per entry.
    fn motion(joint: &Joint, coordinate: f64) -> Transform {
        let [x, y, z] = joint.axis;
        let (sin, cos) = coordinate.sin_cos();
        let versine = 1.0 - cos;
        match joint.kind {
            JointKind::Prismatic => Transform::along([x * coordinate, y * coordinate, z * coordinate]),
            JointKind::Revolute => Transform::from_rotation(
                [
                    [x * x * versine + cos, x * y * versine - z * sin, x * z * versine + y * sin],
                    [x * y * versine + z * sin, y * y * versine + cos, y * z * versine - x * sin],
                    [x * z * versine - y * sin, y * z * versine + x * sin, z * z * versine + cos],
                ],
                [0.0; 3],
            )
            .unwrap(),
        }
    }

    proptest! {
        #[test]
        fn poses_are_the_product_of_the_joints_parts(pose in pose()) {
            let mut expected = Transform::identity();
            let poses = pose.chain.forward(&pose.coordinates);
            for (k, joint) in pose.chain.joints().iter().enumerate() {
                expected = expected * joint.before * motion(joint, pose.coordinates[k]) * joint.after;
                prop_assert!((poses[k].rotation - expected.rotation).norm() < 1e-13);
                prop_assert!((poses[k].translation - expected.translation).norm() < 1e-13);
            }
        }
    }
}
