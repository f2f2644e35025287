//! What a reader must know before any number: one file a finding, and the verdict that they come to (`verdict.rs`).

mod blocks;
mod contradicted_earlier;
mod contradicted_noise;
mod contradicted_validation;
mod contradictions;
mod gravity_upwards;
mod heavy_tails;
mod hemisphere;
mod instruments;
mod large_errors;
mod mirrored_gains;
mod noise;
mod other_unit;
mod passed_constraints;
mod pose_errors;
mod residual_shape;
#[cfg(test)]
mod testing;
pub(super) mod verdict;
