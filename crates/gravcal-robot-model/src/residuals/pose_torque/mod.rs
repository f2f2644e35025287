//! All torque readings of one static pose.
//!
//! ```text
//!     y_i = k_i τ_i(θ; g, moments, load) + b_i,     θ_j = s_j q_j + o_j
//! ```
//!
//! `τ_i = z_{i−1} · (g × M_i)` is the chain's gravity torque (see `gravcal-dynamics`). A load of mass `m_L` at
//! `r_L` adds `(m_L, m_L r_L)` to the mass and first moment of the link that carries it. Joints without a usable
//! reading have no row. What sensors do beyond this is in [`crate::sensors`]; where all are affine it costs nothing.
//! Joints that give way under their torque are where `compliance.rs` finds them.

mod affine;
mod batch;
mod batch_terms;
mod by_terms;
mod compliance;
mod instructions;
mod means;
mod model;
mod moments;
mod motion;
mod regressors;
mod residual;
mod terms;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use model::LoadState;
pub(crate) use model::joined;
pub use model::{CarriedLoad, LoadMass, PoseTorqueBlocks, PoseTorqueModel};
pub use motion::{MotionTorque, MotionTorqueModel};
pub use residual::PoseTorque;
