//! Robots as chains of joints: forward kinematics, gravity torque and inverse dynamics with analytic derivatives.
//!
//! A [`Chain`] is made of joints, each with a fixed transform before and after it, and one body ("link") beyond
//! each joint; it is serial, or branches, and joints may mimic others. It is built from Denavit-Hartenberg rows
//! ([`chain_from_dh`]), from a URDF ([`Chain::from_urdf`]) or by hand ([`Chain::new`], [`Chain::branched`]), and answers
//! questions about a static pose:
//!
//! - where is every link? [`Chain::forward`]
//! - which torque does every joint exert to hold the arm against gravity? [`Chain::gravity_torque`]
//! - how does that torque change with the joint coordinates, with gravity, and with the masses and first moments
//!   of the links? [`Chain::linearize_gravity_torque`]
//!
//! and about an arm in motion:
//!
//! - which torque does every joint exert? [`Chain::inverse_dynamics`]
//! - how does it change with the ten inertial parameters of each link ([`BodyInertia`])? [`Chain::inverse_dynamics_regressor`]
//! - and with coordinates, velocities, accelerations and gravity? [`Chain::linearize_inverse_dynamics`]
//!
//! of one sample ([`Single`]) or of four at once ([`Vectorized`]).
//!
//! # Conventions
//!
//! SI units and radians throughout. A transform `X_AB` takes coordinates in frame B to coordinates in frame A and
//! rotation matrices are row-major. Gravity is the acceleration vector in base coordinates, (0, 0, −9.81) m/s² for an
//! upright base with z up. Torque is what the joint **exerts** to hold the arm, the derivative of the potential energy
//! with respect to the joint coordinate (the same sign as Pinocchio's generalized gravity); in motion, to move it so (as Pinocchio's `rnea`).
//!
//! ```
//! use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};
//!
//! // A pendulum: one horizontal axis, 2 kg at 0.5 m along the link's x.
//! let row = DhRow {
//!     name: "shoulder".into(),
//!     kind: JointKind::Revolute,
//!     a: 0.5,
//!     alpha: 0.0,
//!     d: 0.0,
//!     theta: 0.0,
//!     limits: None,
//!     link: Link { name: "arm".into(), inertia: None },
//! };
//! let chain = chain_from_dh("base", DhConvention::Standard, &[row])?;
//! let mut torque = [0.0];
//! // The axis is the base's z, so "down" is −y of the base; the mass sits in the link's origin.
//! chain.gravity_torque(&[0.0], [0.0, -9.81, 0.0], &[2.0, 0.0, 0.0, 0.0], &mut torque);
//! assert!((torque[0] - 2.0 * 9.81 * 0.5).abs() < 1e-12);
//! # Ok::<(), gravcal_dynamics::ChainError>(())
//! ```
//!
//! # What this crate does not do
//!
//! No closed loops, no friction, no sensors; no forward dynamics.
//!
//! # Features
//!
//! `urdf` (the default) reads URDFs. Without it a third fewer packages are compiled.

mod arithmetic;
mod axis_frame;
mod axis_rotations;
mod body_inertia;
mod chain;
mod coupled;
mod dh;
mod dynamics;
mod forward;
mod frame;
mod gravity;
mod joint;
mod link;
mod link_frame;
mod link_gravity;
#[cfg(feature = "urdf")]
mod nearest;
mod pseudo_inertia;
mod transform;
mod turned;
#[cfg(feature = "urdf")]
mod urdf;
mod without_lengths;

#[cfg(test)]
mod random_chain;

pub use arithmetic::{Arithmetic, LANES, Lanes, Number, Single, Stored, Vectorized};
pub use body_inertia::BodyInertia;
pub use chain::{Attachment, Chain, ChainError, Mimic};
pub use dh::{DhConvention, DhRow, chain_from_dh, joint_from_dh};
pub use dynamics::{DynamicParameters, InverseDynamics, JointMotion};
pub use gravity::{Bodies, GravityTorque, GravityTorqueRow, GravityTorqueRows};
pub use joint::{Joint, JointKind};
pub use link::{Link, LinkInertia};
pub use link_frame::LinkFrame;
pub use link_gravity::LinkGravity;
pub use pseudo_inertia::parameters_of_pseudo_inertia;
pub use transform::{NotARotation, Transform};
#[cfg(feature = "urdf")]
pub use urdf::{UPRIGHT_LINK, UrdfCorrection, UrdfEnds, UrdfError, urdf_moving_joints, urdf_sliding_joints};
