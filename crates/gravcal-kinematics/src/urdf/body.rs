//! What one moving link carries rigidly.

use nalgebra::Vector3;
use urdf_rs::{JointType, Link};

use super::error::UrdfError;
use super::joint;
use super::tree::Tree;
use crate::link::LinkInertia;
use crate::transform::Transform;

/// A link with everything that fixed joints attach to it.
pub(super) struct RigidBody {
    mass: f64,
    /// In the frame of the link it was gathered from, kg·m.
    first_moment: Vector3<f64>,
    /// The joints on any of its links that are not fixed, in the URDF's order.
    pub movable_joints: Vec<usize>,
}

impl RigidBody {
    /// Gathers from `link` outward; all in that link's frame.
    pub fn gather(tree: &Tree, link: usize) -> Result<Self, UrdfError> {
        let mut body = RigidBody { mass: 0.0, first_moment: Vector3::zeros(), movable_joints: Vec::new() };
        let mut open = vec![(link, Transform::identity())];
        while let Some((link, pose)) = open.pop() {
            body.add(&tree.robot.links[link], &pose)?;
            for &index in tree.child_joints(link) {
                let joint = &tree.robot.joints[index];
                if joint.joint_type == JointType::Fixed {
                    open.push((tree.child(index), pose * joint::origin(joint)?));
                } else {
                    body.movable_joints.push(index);
                }
            }
        }
        body.movable_joints.sort_unstable();
        Ok(body)
    }

    fn add(&mut self, link: &Link, pose: &Transform) -> Result<(), UrdfError> {
        let mass = link.inertial.mass.value;
        let center = Vector3::from(link.inertial.origin.xyz.0);
        if !mass.is_finite() || !center.iter().all(|value| value.is_finite()) {
            let what = format!("mass or centre of mass of link `{}`", link.name);
            return Err(UrdfError::NotFinite { what });
        }
        if mass < 0.0 {
            return Err(UrdfError::NegativeMass { link: link.name.clone(), mass });
        }
        self.mass += mass;
        self.first_moment += (pose.rotation * center + pose.translation) * mass;
        Ok(())
    }

    /// The inertia seen from a frame whose pose in the gathering link's frame is `frame`; none where no mass is stated.
    pub fn inertia_in(&self, frame: &Transform) -> Option<LinkInertia> {
        let about_frame = self.first_moment - frame.translation * self.mass;
        let first_moment = frame.rotation.tr_mul(&about_frame).into();
        (self.mass > 0.0).then_some(LinkInertia { mass: self.mass, first_moment })
    }
}
