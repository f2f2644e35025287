//! A robot one of whose joints is turned, or sits elsewhere, on the link that it hangs on.

use nalgebra::{Rotation3, Vector3};

use crate::chain::Chain;
use crate::joint::Joint;
use crate::transform::Transform;

impl Chain {
    /// The same chain with the joint that moves a link turned about its frame's origin: `turn` is a rotation vector in the joint's frame, rad. What hangs on
    /// it turns with it; what is known of links stays, as it is told in their frames.
    pub fn with_joint_turned(&self, link: usize, turn: [f64; 3]) -> Chain {
        let rotation = Rotation3::new(Vector3::from(turn)).into_inner();
        self.with_joint_placed(link, |before| before.compose(&Transform::turned(rotation)))
    }

    /// The same chain with the joint that moves a link as far aside, m, along the axes of the link that it hangs on. What hangs on it goes with it; what is
    /// known of links stays.
    pub fn with_joint_aside(&self, link: usize, aside: [f64; 3]) -> Chain {
        self.with_joint_placed(link, |before| Transform::along(aside).compose(before))
    }

    fn with_joint_placed(&self, link: usize, placed: impl Fn(&Transform) -> Transform) -> Chain {
        let name = &self.movers()[link].name;
        let changed = self.with_joints(|joint| match joint.name == *name {
            true => Joint { before: placed(&joint.before), ..joint.clone() },
            false => joint.clone(),
        });
        changed.with_links_of(self)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use proptest::prelude::*;

    use super::*;
    use crate::random_chain::pose;

    proptest! {
        /// What hangs on the joint turns as one body about the joint's origin, and nothing else moves.
        #[test]
        fn what_hangs_on_a_joint_turns_with_it(pose in pose(), link in any::<prop::sample::Index>(), turn in [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]) {
            let chain = &pose.chain;
            let link = link.index(chain.link_count());
            let before = &chain.movers()[link].before;
            let links = chain.forward(&pose.coordinates);
            let frame = chain.parent(link).map_or_else(Transform::identity, |parent| links[parent]).compose(before);
            let turned = Transform::turned(Rotation3::new(Vector3::from(turn)).into_inner());
            let about_joint = frame.compose(&turned).compose(&frame.inverse());
            for (other, found) in chain.with_joint_turned(link, turn).forward(&pose.coordinates).iter().enumerate() {
                let expected = if chain.carries(link, other) { about_joint.compose(&links[other]) } else { links[other] };
                prop_assert!((found.rotation - expected.rotation).abs().max() < 1e-12);
                prop_assert!((found.translation - expected.translation).abs().max() < 1e-9);
            }
        }
    }
}
