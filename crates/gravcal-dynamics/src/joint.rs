//! A joint: one degree of freedom between two fixed transforms.
//!
//! ```text
//!     X_parent,child(q) = before · motion(axis, q) · after
//! ```
//!
//! `motion` is a rotation by q about the axis, or a translation by q along it.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::transform::Transform;

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// Turns about its axis: coordinate in rad, holding torque in N·m.
    Revolute,
    /// Slides along its axis: coordinate in m, holding force in N.
    Prismatic,
}

/// One joint of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, unique in the chain.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Pose of the joint frame in the parent link's frame (the base, for the first joint).
    pub before: Transform,
    /// Unit vector of the axis in the joint frame; positive coordinates turn right-handed about it or slide along it.
    pub axis: [f64; 3],
    /// Pose of the child link's frame in the joint frame after the motion.
    pub after: Transform,
    /// Lower and upper bound of the true coordinate, rad or m; `None` where there is none.
    pub limits: Option<[f64; 2]>,
}

impl Joint {
    /// The first moment nearest to one, both kg·m in the child link's frame, with which the centre of a mass (kg) lies on the joint's axis.
    pub fn moment_on_axis(&self, mass: f64, moment: Vector3<f64>) -> Vector3<f64> {
        let Transform { rotation, translation } = &self.after;
        let axis = Vector3::from(self.axis);
        let about_axis = rotation * moment + translation * mass;
        let off = about_axis - axis * axis.dot(&about_axis);
        moment - rotation.transpose() * off
    }

    /// What the child link's mass (kg) and first moment (kg·m, in its frame) add to the first moment of the link that the joint hangs on, in that
    /// link's frame, with the joint at zero. Where the centre of mass lies on the joint's axis it is so at any angle.
    pub fn moment_on_parent(&self, mass: f64, moment: Vector3<f64>) -> Vector3<f64> {
        let Transform { rotation, translation } = self.before.compose(&self.after);
        rotation * moment + translation * mass
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::{Joint, JointKind};
    use crate::transform::Transform;

    #[test]
    fn a_moment_on_the_axis_leaves_the_mass_where_the_axis_is() {
        let rotation = *Rotation3::from_euler_angles(0.3, -0.7, 1.1).matrix();
        let after = Transform { rotation, translation: Vector3::new(0.2, -0.1, 0.05) };
        let joint = Joint {
            name: "wrist".into(),
            kind: JointKind::Revolute,
            before: Transform::identity(),
            axis: [0.0, 0.6, 0.8],
            after,
            limits: None,
        };
        let (mass, moment) = (2.0, Vector3::new(0.1, 0.3, -0.2));
        let balanced = joint.moment_on_axis(mass, moment);
        // The centre of mass in the joint frame, whose origin lies on the axis.
        let centre = rotation * balanced / mass + joint.after.translation;
        assert!(centre.cross(&Vector3::from(joint.axis)).norm() < 1e-15);
        // Nothing moves along the axis.
        assert!((rotation * (balanced - moment)).dot(&Vector3::from(joint.axis)).abs() < 1e-15);
    }

    #[test]
    fn a_mass_on_the_axis_is_carried_alike_at_any_angle() {
        let before = Transform {
            rotation: *Rotation3::from_euler_angles(1.0, 0.4, -0.2).matrix(),
            translation: Vector3::new(0.1, 0.2, -0.3),
        };
        let after = Transform {
            rotation: *Rotation3::from_euler_angles(0.3, -0.7, 1.1).matrix(),
            translation: Vector3::new(0.2, -0.1, 0.05),
        };
        let axis = [0.0, 0.0, 1.0];
        let mut joint = Joint { name: "wrist".into(), kind: JointKind::Revolute, before, axis, after, limits: None };
        let mass = 2.0;
        let moment = joint.moment_on_axis(mass, Vector3::new(0.1, 0.3, -0.2));
        let at_zero = joint.moment_on_parent(mass, moment);
        // The centre of mass in the parent's frame.
        let centre = before.transform_point(after.transform_point((moment / mass).into()));
        assert!((at_zero - mass * Vector3::from(centre)).norm() < 1e-15);
        joint.after = Transform::about_z(0.8).compose(&after);
        assert!((joint.moment_on_parent(mass, moment) - at_zero).norm() < 1e-15);
    }
}
