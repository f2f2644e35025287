//! A serial chain of joints and the links they move.

mod check;
mod error;

pub use error::ChainError;

use crate::axis_frame::AxisFrame;
use crate::joint::Joint;
use crate::link::Link;

/// A serial robot: `links[k]` is the body moved by `joints[k]`, in proximal to distal order.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    base: String,
    joints: Vec<Joint>,
    links: Vec<Link>,
    pub(crate) cut_joints: Vec<String>,
    /// The joints, re-cut for computing.
    pub(crate) axis_frames: Vec<AxisFrame>,
}

impl Chain {
    /// A chain from its parts.
    ///
    /// Axes are made exactly unit vectors.
    ///
    /// # Errors
    ///
    /// [`ChainError`] when there is no joint, when there are not as many links as joints, when a name occurs twice, an
    /// axis is not a unit vector (within 1e-5), limits are the wrong way round, a number is not finite, or a mass is
    /// negative.
    pub fn new(base: impl Into<String>, mut joints: Vec<Joint>, links: Vec<Link>) -> Result<Chain, ChainError> {
        let base = base.into();
        check::counts(&base, &joints, &links)?;
        check::names(&base, &joints, &links)?;
        links.iter().try_for_each(check::link)?;
        for joint in &mut joints {
            check::finite(joint)?;
            check::limits(joint)?;
            joint.axis = check::unit_axis(joint)?;
        }
        let axis_frames = joints.iter().map(AxisFrame::of).collect();
        Ok(Chain { base, joints, links, cut_joints: Vec::new(), axis_frames })
    }

    /// The same links moved by other joints: as many, with the same names.
    pub(crate) fn with_joints(&self, joints: Vec<Joint>) -> Chain {
        let links = self.links.iter().map(|link| Link { inertia: None, ..link.clone() }).collect();
        let axis_frames = joints.iter().map(AxisFrame::of).collect();
        Chain { joints, links, axis_frames, base: self.base.clone(), cut_joints: self.cut_joints.clone() }
    }

    /// Name of the base link, whose frame gravity is given in.
    pub fn base(&self) -> &str {
        &self.base
    }

    /// The joints, proximal first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The links, proximal first; `links()[k]` is moved by `joints()[k]`.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Number of joints, and of links.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Index of the joint of that name.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Index of the link of that name; the base is none.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Movable joints of the source file that hang on the last link and were cut off, with all they carry.
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
