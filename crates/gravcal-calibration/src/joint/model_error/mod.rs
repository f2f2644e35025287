//! What the model does not say of the readings, beside their noise.

pub(super) mod at_rest;
pub(super) mod bending;
pub(super) mod bending_in_motion;
pub(super) mod block_correlation;
mod contradicted_description;
pub(super) mod contradicted_priors;
pub(super) mod displaced_joints;
mod farthest_from_earlier;
pub(super) mod friction_by_load;
pub(super) mod growing_friction;
pub(super) mod heavy_tails;
pub(super) mod in_tables;
pub(super) mod lasting;
pub(super) mod pose_errors;
pub(super) mod settling;
mod shifted_readings;
pub(super) mod sides_by_order;
mod slopes;
mod turned_instruments;
mod uneven_sweeps;
pub(super) mod unexplained;
pub(super) mod unexplained_size;
