//! What of a chain moves with what.

use std::borrow::Cow;

use super::{Chain, Drive};

impl Chain {
    /// Whether every joint has a coordinate of its own and hangs on the link of the one before: joint k moves the links
    /// from k on. A body without joints is no such chain.
    pub fn is_serial(&self) -> bool {
        !self.joints.is_empty() && self.topology.is_serial() && self.drives.is_none()
    }

    /// The link that a link hangs on; `None`: the base.
    pub fn parent(&self, link: usize) -> Option<usize> {
        self.topology.parents[link]
    }

    /// The links on which nothing hangs: the ends of all branches.
    pub fn last_links(&self) -> impl Iterator<Item = usize> {
        (0..self.link_count()).filter(|link| self.topology.ends[*link] == link + 1)
    }

    /// The links that a joint moves on the ones they hang on: its own, and those of the joints that mimic it.
    pub fn links_of(&self, joint: usize) -> impl Iterator<Item = usize> {
        (0..self.link_count()).filter(move |link| self.drive(*link).joint == joint)
    }

    /// Whether a joint moves a link, itself or by what mimics it.
    pub fn moves(&self, joint: usize, link: usize) -> bool {
        self.links_of(joint).any(|own| self.carries(own, link))
    }

    /// Whether a link hangs on another, directly or by links between, or is that link.
    pub fn carries(&self, link: usize, other: usize) -> bool {
        (link..self.topology.ends[link]).contains(&other)
    }

    /// Whether some link is moved by both joints: the torque of one then depends on the coordinate of the other.
    pub fn meet(&self, joint: usize, other: usize) -> bool {
        self.last_links().any(|link| self.moves(joint, link) && self.moves(other, link))
    }

    /// The joint, if there is one, on which all others hang: where its coordinate counts from is a choice of the base's
    /// frame.
    pub fn root_joint(&self) -> Option<usize> {
        let joint = self.drive(0).joint;
        (!self.joints.is_empty() && self.topology.ends[0] == self.link_count() && self.links_of(joint).eq([0]))
            .then_some(joint)
    }

    /// Whether nothing hangs on what a joint moves but by its own motion: where its coordinate counts from is a choice of
    /// these links' frames.
    pub fn is_last(&self, joint: usize) -> bool {
        self.links_of(joint).all(|link| self.topology.ends[link] == link + 1)
    }

    /// The links, and with them their movers, from the base to a link; none where there is no joint.
    pub(crate) fn path(&self, link: usize) -> Vec<usize> {
        if self.joints.is_empty() { Vec::new() } else { self.topology.path(link) }
    }

    /// What moves a link.
    pub(crate) fn drive(&self, link: usize) -> Drive {
        self.drives.as_ref().map_or_else(|| Drive::own(link), |drives| drives[link])
    }

    /// The coordinate of each link's mover, from those of the joints.
    pub(crate) fn axis_coordinates<'a>(&self, coordinates: &'a [f64]) -> Cow<'a, [f64]> {
        assert_eq!(coordinates.len(), self.joint_count(), "one coordinate for each joint");
        match &self.drives {
            None => Cow::Borrowed(coordinates),
            Some(drives) => drives.iter().map(|drive| drive.coordinate(coordinates)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use crate::chain::{Attachment, Chain, Mimic};
    use crate::random_chain::{branched, pose, turning};

    /// A torso with two arms of two joints; the last joint of the second arm mimics its first.
    fn torso() -> Chain {
        let mut attachments =
            [None, Some(0), Some(1), Some(0), Some(3)].map(|parent| Attachment { parent, mimic: None });
        attachments[4].mimic = Some(Mimic { leader: 3, multiplier: -1.0, offset: 0.0 });
        branched(vec![turning(); 5], &attachments)
    }

    #[test]
    fn what_moves_what() {
        let chain = torso();
        assert!(!chain.is_serial());
        assert_eq!((chain.joint_count(), chain.link_count()), (4, 5));
        assert_eq!(chain.last_links().collect::<Vec<_>>(), [2, 4]);
        assert_eq!(chain.links_of(3).collect::<Vec<_>>(), [3, 4]);
        assert!((0..5).all(|link| chain.moves(0, link)));
        assert_eq!((0..5).filter(|link| chain.moves(1, *link)).collect::<Vec<_>>(), [1, 2]);
        assert_eq!((0..5).filter(|link| chain.carries(3, *link)).collect::<Vec<_>>(), [3, 4]);
        assert!(chain.meet(1, 2) && chain.meet(0, 3) && !chain.meet(1, 3));
        assert_eq!((0..4).filter(|joint| chain.is_last(*joint)).collect::<Vec<_>>(), [2]);
        assert_eq!((chain.root_joint(), chain.parent(3), chain.parent(0)), (Some(0), Some(0), None));
    }

    proptest! {
        /// A joint that sits aside carries what hangs on it as much aside: gravity's torques are those of its parent's moment, larger by the mass times it.
        #[test]
        fn a_joint_aside_is_a_moment_of_the_link_before(
            pose in pose(),
            link in any::<prop::sample::Index>(),
            aside in [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0],
        ) {
            let chain = &pose.chain;
            let link = link.index(chain.link_count());
            prop_assume!(chain.parent(link).is_some());
            let moved = chain.with_joint_aside(link, aside);
            let torques = |chain: &Chain, inertia: &[f64]| {
                let mut torques = vec![0.0; chain.joint_count()];
                chain.gravity_torque(&pose.coordinates, pose.gravity, inertia, &mut torques);
                torques
            };
            let mut inertia = pose.inertia.clone();
            let beyond = (0..chain.link_count()).filter(|other| chain.carries(link, *other));
            let mass: f64 = beyond.map(|other| pose.inertia[4 * other]).sum();
            let parent = 4 * chain.parent(link).unwrap();
            (0..3).for_each(|axis| inertia[parent + 1 + axis] += mass * aside[axis]);
            for (a, b) in torques(&moved, &pose.inertia).iter().zip(torques(chain, &inertia)) {
                prop_assert!((a - b).abs() < 1e-9 * (1.0 + a.abs().max(mass)), "{a} {b}");
            }
        }
    }

    #[test]
    fn no_joint_moves_a_free_body() {
        let body = Chain::free_body("base", "body");
        assert_eq!((body.joint_count(), body.link_count(), body.root_joint()), (0, 1, None));
        assert_eq!(body.last_links().collect::<Vec<_>>(), [0]);
        assert!(!body.is_serial());
        assert_eq!(body.forward(&[]), [crate::Transform::identity()]);
        let gravity = body.link_gravity(0, &[], [1.0, 2.0, 3.0]);
        assert_eq!((gravity.value, gravity.by_coordinate.len()), ([1.0, 2.0, 3.0], 0));
        assert_eq!(gravity.by_gravity, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn without_a_common_trunk_no_joint_is_the_root() {
        let apart = [None, Some(0), None].map(|parent| Attachment { parent, mimic: None });
        assert_eq!(branched(vec![turning(); 3], &apart).root_joint(), None);
        let mut followed = [None, Some(0), Some(1)].map(|parent| Attachment { parent, mimic: None });
        followed[2].mimic = Some(Mimic { leader: 0, multiplier: 1.0, offset: 0.0 });
        let followed = branched(vec![turning(); 3], &followed);
        assert_eq!((followed.root_joint(), followed.is_last(0), followed.is_last(1)), (None, false, false));
    }
}
