//! A robot one of whose joints is turned on the link that it hangs on.

use nalgebra::{Rotation3, Vector3};

use crate::chain::Chain;
use crate::joint::Joint;
use crate::transform::Transform;

impl Chain {
    /// The same chain with the joint that moves a link turned about its frame's origin: `turn` is a rotation vector in the joint's frame, rad. What hangs on
    /// it turns with it. Nothing is known of its links' masses.
    pub fn with_joint_turned(&self, link: usize, turn: [f64; 3]) -> Chain {
        let rotation = Rotation3::new(Vector3::from(turn)).into_inner();
        let name = &self.movers()[link].name;
        self.with_joints(|joint| match joint.name == *name {
            true => Joint { before: joint.before.compose(&Transform::turned(rotation)), ..joint.clone() },
            false => joint.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use crate::joint::JointKind;
    use crate::random_chain::pose;

    proptest! {
        /// A turn about its axis is an offset of its coordinate.
        #[test]
        fn a_joint_that_is_turned_about_its_axis_is_moved(pose in pose(), angle in -1.0..1.0_f64) {
            let movers = pose.chain.movers();
            let turning = |link: &usize| pose.chain.joint_index(&movers[*link].name).is_some_and(|_| movers[*link].kind == JointKind::Revolute);
            if pose.chain.joint_count() == movers.len() && let Some(link) = (0..movers.len()).rfind(turning) {
                let turned = pose.chain.with_joint_turned(link, movers[link].axis.map(|component| angle * component));
                let mut moved = pose.coordinates.clone();
                moved[link] += angle;
                for (a, b) in turned.forward(&pose.coordinates).iter().zip(pose.chain.forward(&moved)) {
                    prop_assert!((a.rotation - b.rotation).abs().max() < 1e-12);
                    prop_assert!((a.translation - b.translation).abs().max() < 1e-12);
                }
            }
        }
    }
}
