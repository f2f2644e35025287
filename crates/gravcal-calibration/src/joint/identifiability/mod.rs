//! What is determined at a solution, and how well.

pub(super) mod judged;
pub(super) mod model_tests;
pub(super) mod pose_blocks;
pub(super) mod uncertainty;
pub(super) mod untold_noise;
mod widening;
