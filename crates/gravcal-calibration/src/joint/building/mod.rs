//! The readings as one problem: every reading once, the unknowns it depends on, and what is known of these beforehand.

pub(super) mod axes;
mod bent_joints;
pub(super) mod blocks;
pub(super) mod build;
pub(super) mod constraints;
pub(super) mod displacements;
pub(super) mod earlier;
pub(super) mod factors;
pub(super) mod inertia_priors;
pub(super) mod lengths;
pub(super) mod modelled;
pub(super) mod placements;
pub(super) mod position_unknowns;
pub(super) mod reference;
pub(super) mod static_friction;
pub(super) mod sweep_moments;
pub(super) mod torques;
