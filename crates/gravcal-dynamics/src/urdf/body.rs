//! What one moving link carries rigidly.

use nalgebra::{Matrix3, Vector3};
use urdf_rs::{JointType, Link};

use super::error::UrdfError;
use super::joint;
use super::tree::Tree;
use crate::body_inertia::{BodyInertia, six};
use crate::transform::Transform;

/// A link with everything that fixed joints attach to it.
pub(super) struct RigidBody {
    /// In the frame of the link it was gathered from.
    inertia: BodyInertia,
    /// The joints on any of its links that are not fixed, in the URDF's order.
    pub movable_joints: Vec<usize>,
}

impl RigidBody {
    /// Gathers from `link` outward; all in that link's frame.
    pub fn gather(tree: &Tree, link: usize) -> Result<Self, UrdfError> {
        let mut body = RigidBody { inertia: BodyInertia::default(), movable_joints: Vec::new() };
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
        let center = pose.rotation * center + pose.translation;
        self.inertia = self.inertia + BodyInertia::about_center(mass, center.into(), tensor(link, pose));
        Ok(())
    }

    /// The inertia seen from a frame whose pose in the gathering link's frame is `frame`.
    pub fn inertia_in(&self, frame: &Transform) -> BodyInertia {
        self.inertia.in_frame(frame)
    }
}

/// The tensor about the link's centre of mass, along the axes of the frame in which the link has this pose.
///
/// A URDF states it along the axes of the inertial frame, which `rpy` turns in the link's.
fn tensor(link: &Link, pose: &Transform) -> [f64; 6] {
    let stated = &link.inertial.inertia;
    let own = Matrix3::new(
        stated.ixx, stated.ixy, stated.ixz, stated.ixy, stated.iyy, stated.iyz, stated.ixz, stated.iyz, stated.izz,
    );
    let turned = (*pose * Transform::from_xyz_rpy([0.0; 3], link.inertial.origin.rpy.0)).rotation;
    six(&(turned * own * turned.transpose()))
}
