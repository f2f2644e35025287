//! An open chain of joints and the links they move: serial, or branched.

mod attachment;
mod branches;
mod check;
mod error;
mod inertia;
mod topology;

use std::sync::Arc;

pub(crate) use attachment::Drive;
pub use attachment::{Attachment, Mimic};
pub use error::ChainError;
pub(crate) use topology::{Run, Topology};

use crate::axis_frame::AxisFrame;
use crate::joint::{Joint, JointKind};
use crate::link::Link;
use crate::transform::Transform;

/// A robot without closed loops: every link is moved by one joint, and hangs on the base or on another link; or a
/// [free body](Chain::free_body).
///
/// `movers()[k]` moves `links()[k]`. Links are numbered by branches, a parent before its child and what hangs on a link
/// right behind it. `joints()` are those of the movers that have a coordinate of their own, in the same order: all of them,
/// unless some mimic others. Whatever is computed goes by these coordinates, and by links.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    base: String,
    /// With a coordinate of their own.
    joints: Vec<Joint>,
    /// One for each link.
    movers: Vec<Joint>,
    links: Vec<Link>,
    /// Of each link, about its frame's origin, kg·m²; zero where none is known.
    pub(crate) tensors: Vec<[f64; 6]>,
    pub(crate) topology: Topology,
    /// What moves each link, where joints mimic others.
    pub(crate) drives: Option<Vec<Drive>>,
    pub(crate) cut_joints: Vec<String>,
    /// The movers, re-cut for computing.
    pub(crate) axis_frames: Arc<[AxisFrame]>,
}

impl Chain {
    /// A serial chain from its parts: `joints[k]` moves `links[k]` and hangs on link k − 1, the first on the base.
    ///
    /// Axes are made exactly unit vectors.
    ///
    /// # Errors
    ///
    /// [`ChainError`] when there is no joint, when there are not as many links as joints, when a name occurs twice, an
    /// axis is not a unit vector (within 1e-5), limits are the wrong way round, a number is not finite, or a mass is
    /// negative.
    pub fn new(base: impl Into<String>, joints: Vec<Joint>, links: Vec<Link>) -> Result<Chain, ChainError> {
        let attachments: Vec<Attachment> =
            (0..joints.len()).map(|k| Attachment { parent: k.checked_sub(1), mimic: None }).collect();
        Chain::branched(base, joints, links, &attachments)
    }

    /// A chain that may branch, and whose joints may mimic others: `movers[k]` moves `links[k]` and hangs where
    /// `attachments[k]` says.
    ///
    /// # Errors
    ///
    /// As [`Chain::new`]; and when a link does not come behind the one it hangs on, when a branch goes on after another
    /// has begun, when a joint mimics one that is not there, or joints mimic each other in a circle.
    pub fn branched(
        base: impl Into<String>,
        mut movers: Vec<Joint>,
        links: Vec<Link>,
        attachments: &[Attachment],
    ) -> Result<Chain, ChainError> {
        let base = base.into();
        check::counts(&base, &movers, &links, attachments)?;
        check::names(&base, &movers, &links)?;
        links.iter().try_for_each(check::link)?;
        for joint in &mut movers {
            check::finite(joint)?;
            check::limits(joint)?;
            joint.axis = check::unit_axis(joint)?;
        }
        let topology = Topology::new(&movers, &links, attachments)?;
        let drives = attachment::drives(&movers, attachments)?;
        let own = movers.iter().zip(attachments).filter(|(_, attachment)| attachment.mimic.is_none());
        let joints: Vec<Joint> = own.map(|(joint, _)| joint.clone()).collect();
        let drives = (joints.len() < movers.len()).then_some(drives);
        let axis_frames = movers.iter().map(AxisFrame::of).collect();
        let tensors = vec![[0.0; 6]; links.len()];
        Ok(Chain { base, joints, movers, links, tensors, topology, drives, cut_joints: Vec::new(), axis_frames })
    }

    /// One body that no joint moves: whoever uses it says how it stands. Its mover has no coordinate, and stands still.
    pub fn free_body(base: impl Into<String>, body: impl Into<String>) -> Chain {
        let link = Link { name: body.into(), inertia: None };
        let still = Joint {
            name: link.name.clone(),
            kind: JointKind::Prismatic,
            before: Transform::identity(),
            axis: [0.0, 0.0, 1.0],
            after: Transform::identity(),
            limits: None,
        };
        Chain {
            base: base.into(),
            joints: Vec::new(),
            axis_frames: Arc::from([AxisFrame::of(&still)]),
            movers: vec![still],
            links: vec![link],
            tensors: vec![[0.0; 6]],
            topology: Topology::single(),
            drives: None,
            cut_joints: Vec::new(),
        }
    }

    /// The same chain with every joint changed alike, but for name and kind; nothing is known of its links' masses.
    pub(crate) fn with_joints(&self, changed: impl Fn(&Joint) -> Joint) -> Chain {
        let links: Vec<Link> = self.links.iter().map(|link| Link { inertia: None, ..link.clone() }).collect();
        let tensors = vec![[0.0; 6]; links.len()];
        let movers: Vec<Joint> = self.movers.iter().map(&changed).collect();
        let axis_frames = movers.iter().map(AxisFrame::of).collect();
        let joints = self.joints.iter().map(changed).collect();
        Chain { joints, movers, links, tensors, axis_frames, ..self.clone() }
    }

    /// The same with what is known of another chain's links.
    pub(crate) fn with_links_of(self, other: &Chain) -> Chain {
        Chain { links: other.links.clone(), tensors: other.tensors.clone(), ..self }
    }

    /// Name of the base link, whose frame gravity is given in.
    pub fn base(&self) -> &str {
        &self.base
    }

    /// The joints that have a coordinate of their own, by branches, proximal first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The joint that moves each link on the one it hangs on; those that mimic others among them.
    pub fn movers(&self) -> &[Joint] {
        &self.movers
    }

    /// The links, by branches, proximal first.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Number of joints that have a coordinate of their own.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Number of links.
    pub fn link_count(&self) -> usize {
        self.links.len()
    }

    /// Index of the joint of that name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Index of the link of that name; the base is none.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Movable joints of the source file that hang on a last link and were cut off, with all they carry.
    ///
    /// Their masses are **not** part of the model (a gripper's fingers, say): a caller should tell the user. Empty
    /// unless the chain came from [`Chain::from_urdf`].
    pub fn cut_joints(&self) -> &[String] {
        &self.cut_joints
    }
}

#[cfg(test)]
mod tests {
    use crate::joint::JointKind;
    use crate::random_chain::{dh_row, standard_chain};

    #[test]
    fn finds_by_name() {
        let rows = [0, 1].map(|i| dh_row(i, JointKind::Revolute, [0.0; 4]));
        let chain = standard_chain(&rows);
        assert_eq!(chain.joint_index("joint1"), Some(1));
        assert_eq!(chain.joint_index("link1"), None);
        assert_eq!(chain.link_index("link0"), Some(0));
        assert_eq!(chain.link_index("base"), None);
        assert_eq!((chain.base(), chain.joint_count()), ("base", 2));
        assert!(chain.cut_joints().is_empty());
    }
}
