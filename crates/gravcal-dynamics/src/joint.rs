//! A joint: one degree of freedom between two fixed transforms.
//!
//! ```text
//!     X_parent,child(q) = before · motion(axis, q) · after
//! ```
//!
//! `motion` is a rotation by q about the axis, or a translation by q along it.

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
