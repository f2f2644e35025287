//! The arm as a MuJoCo model (MJCF): joint frames, identified inertias, gravity in base coordinates.
//!
//! A body's frame is that of its link. In gravcal a link's pose in that of its parent is `before · motion(axis, θ) · after`; MuJoCo puts the
//! pose at zero into the body and names the axis in the body's frame:
//!
//! ```text
//!     body  = before · motion(axis, o) · after      o: position offset, so that the joint's value is position_gain · reading
//!     axis' = R_afterᵀ axis,     pos' = −R_afterᵀ t_after
//! ```

use std::fmt::Write;

use gravcal_dynamics::{Chain, Joint, JointKind, Transform};
use gravcal_recording::EarlierInertia;
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

use super::numbers::one_line;

pub(super) const CONVENTION: [&str; 4] = [
    "Convention: the joint's value in this model is position_gain * reading, in rad or m; frames are moved by the position offsets.",
    "The world is the base's frame; gravity is as it was identified there. Inertias are those of rigid bodies nearest to the readings",
    "and to the robot's file, without loads. The model has no shapes, motors, friction nor rotor inertias: inverse dynamics gives the",
    "torque that a joint exerts on its links.",
];

/// The arm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arm<'a> {
    /// Name of the robot.
    pub name: &'a str,
    pub chain: &'a Chain,
    pub inertias: &'a [EarlierInertia],
    /// Of each joint's position sensor, by name.
    pub offsets: &'a [(String, f64)],
    /// In the frame of the base, m/s².
    pub gravity: [f64; 3],
}

/// A link without an inertia.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoInertia {
    pub link: String,
}

impl Arm<'_> {
    /// The file; `head`: lines of its comment.
    pub fn text(&self, head: &[String]) -> Result<String, NoInertia> {
        let mut text = String::from("<!--\n");
        head.iter().for_each(|line| text += &format!("  {}\n", line.replace("--", "- -")));
        text += "-->\n";
        text += &format!("<mujoco model=\"{}\">\n", escaped(self.name));
        text += "  <compiler angle=\"radian\" autolimits=\"true\"/>\n";
        text += &format!("  <option gravity=\"{}\"/>\n  <worldbody>\n", numbers(&self.gravity));
        for link in (0..self.chain.link_count()).filter(|link| self.chain.parent(*link).is_none()) {
            self.write(&mut text, link, 2)?;
        }
        Ok(text + "  </worldbody>\n</mujoco>\n")
    }

    /// A link with everything that hangs on it.
    fn write(&self, text: &mut String, link: usize, depth: usize) -> Result<(), NoInertia> {
        let (joint, name) = (&self.chain.movers()[link], &self.chain.links()[link].name);
        let inertia = self.inertias.iter().find(|inertia| inertia.link == *name);
        let inertia = inertia.ok_or_else(|| NoInertia { link: name.clone() })?;
        let offset = self.offsets.iter().find(|(own, _)| *own == joint.name).map_or(0.0, |(_, offset)| *offset);
        let pose = joint.before.compose(&motion(joint, offset)).compose(&joint.after);
        let space = "  ".repeat(depth);
        let [xx, xy, yy, xz, yz, zz] = inertia.tensor_kg_m2;
        let lines = [
            format!("{space}<body name=\"{}\"{}>", escaped(name), placed(&pose)),
            format!("{space}  {}", joint_element(joint, offset)),
            format!(
                "{space}  <inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
                numbers(&inertia.center_of_mass_m),
                inertia.mass_kg,
                numbers(&[xx, yy, zz, xy, xz, yz])
            ),
        ];
        lines.iter().for_each(|line| *text += &format!("{line}\n"));
        for child in (0..self.chain.link_count()).filter(|child| self.chain.parent(*child) == Some(link)) {
            self.write(text, child, depth + 1)?;
        }
        *text += &format!("{space}</body>\n");
        Ok(())
    }
}

fn motion(joint: &Joint, coordinate: f64) -> Transform {
    let axis = Vector3::from(joint.axis);
    match joint.kind {
        JointKind::Prismatic => Transform::along((axis * coordinate).into()),
        JointKind::Revolute => {
            let turned = Rotation3::from_axis_angle(&Unit::new_normalize(axis), coordinate);
            Transform::from_xyz_rpy([0.0; 3], turned.euler_angles().into())
        }
    }
}

fn joint_element(joint: &Joint, offset: f64) -> String {
    let back = joint.after.inverse();
    let kind = match joint.kind {
        JointKind::Revolute => "hinge",
        JointKind::Prismatic => "slide",
    };
    let mut text = format!(
        "<joint name=\"{}\" type=\"{kind}\" axis=\"{}\" pos=\"{}\"",
        escaped(&joint.name),
        numbers(&back.rotate_vector(joint.axis)),
        numbers(&back.translation())
    );
    if let Some(limits) = joint.limits.filter(|[low, high]| low < high) {
        let _ = write!(text, " range=\"{}\"", numbers(&limits.map(|limit| limit - offset)));
    }
    text + "/>"
}

/// Attributes of a pose.
fn placed(pose: &Transform) -> String {
    let [a, b, c] = pose.rotation();
    let rotation = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_row_slice(&[a, b, c].concat()));
    let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
    let [x, y, z] = [quaternion.i, quaternion.j, quaternion.k];
    format!(" pos=\"{}\" quat=\"{}\"", numbers(&pose.translation()), numbers(&[quaternion.w, x, y, z]))
}

/// Separated by blanks, zero without a sign.
fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| format!("{}", value + 0.0)).collect::<Vec<_>>().join(" ")
}

fn escaped(name: &str) -> String {
    let mut text = String::new();
    for c in one_line(name).chars() {
        match c {
            '<' => text += "&lt;",
            '>' => text += "&gt;",
            '&' => text += "&amp;",
            '"' => text += "&quot;",
            other => text.push(other),
        }
    }
    text
}
