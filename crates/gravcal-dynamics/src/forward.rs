//! Forward kinematics: where every link is.

use crate::chain::Chain;
use crate::joint::Joint;
use crate::transform::Transform;

impl Chain {
    /// Pose of every link's frame in base coordinates.
    ///
    /// `coordinates`: the true coordinate of every joint, rad or m.
    ///
    /// # Panics
    ///
    /// When `coordinates` has not `joint_count()` entries.
    pub fn forward(&self, coordinates: &[f64]) -> Vec<Transform> {
        let coordinates = self.axis_coordinates(coordinates);
        if self.joints().is_empty() {
            return vec![Transform::identity(); self.link_count()];
        }
        let mut poses: Vec<Transform> = Vec::with_capacity(self.link_count());
        for ((frame, parent), &coordinate) in self.axis_frames.iter().zip(&self.topology.parents).zip(&*coordinates) {
            let parent = parent.map_or_else(Transform::identity, |parent| poses[parent]);
            poses.push(frame.link_after(&parent, coordinate));
        }
        poses
    }

    /// Direction of the axis of every link's mover in base coordinates; `coordinates` as for [`Chain::forward`].
    pub fn axes(&self, coordinates: &[f64]) -> Vec<[f64; 3]> {
        let axis =
            |(link, mover): (Transform, &Joint)| link.rotate_vector(mover.after.inverse().rotate_vector(mover.axis));
        self.forward(coordinates).into_iter().zip(self.movers()).map(axis).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::joint::JointKind;
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
            let poses = pose.chain.forward(&pose.coordinates);
            let axes = pose.chain.axes(&pose.coordinates);
            for (k, joint) in pose.chain.movers().iter().enumerate() {
                let parent = pose.chain.parent(k).map_or_else(Transform::identity, |parent| poses[parent]);
                let expected = parent * joint.before * motion(joint, pose.of_link(k)) * joint.after;
                prop_assert!((poses[k].rotation - expected.rotation).norm() < 1e-13);
                prop_assert!((poses[k].translation - expected.translation).norm() < 1e-13);
                let axis = (parent * joint.before).rotate_vector(joint.axis);
                prop_assert!(axis.iter().zip(axes[k]).all(|(a, b)| (a - b).abs() < 1e-13));
            }
        }
    }
}
