//! A robot of which only the directions of the axes are kept.

use crate::chain::Chain;
use crate::joint::Joint;
use crate::transform::Transform;

impl Chain {
    /// The same chain with every length at zero: all axes and the origins of all links in one point, all directions as
    /// they were. Nothing is known of its links' masses.
    ///
    /// While the joints beyond some joint stand, what hangs there is one rigid body, and the moment of this chain's links
    /// can be that of the body: lengths only add moments that stand still with it (paper, eqs. (4), (19)–(21)).
    pub fn without_lengths(&self) -> Chain {
        let turned = |transform: &Transform| Transform::turned(transform.rotation);
        self.with_joints(|joint| Joint { before: turned(&joint.before), after: turned(&joint.after), ..joint.clone() })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use proptest::prelude::*;

    use crate::joint::JointKind;
    use crate::random_chain::pose;

    proptest! {
        #[test]
        fn directions_stay_and_lengths_vanish(pose in pose()) {
            let bare = pose.chain.without_lengths();
            prop_assert_eq!(bare.axis_rotations(), pose.chain.axis_rotations());
            let turning = bare.movers().iter().all(|joint| joint.kind == JointKind::Revolute);
            for (link, original) in bare.forward(&pose.coordinates).iter().zip(pose.chain.forward(&pose.coordinates)) {
                prop_assert!((link.rotation - original.rotation).abs().max() < 1e-13);
                prop_assert!(!turning || link.translation == Vector3::zeros());
            }
        }
    }
}
