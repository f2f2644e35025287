//! What a reader is told of a solution.

pub(super) mod answer;
pub(super) mod conclusion;
pub(super) mod consistent;
pub(super) mod estimate;
pub(super) mod findings;
pub(super) mod held_out;
pub(super) mod payloads;
pub(super) mod report;
pub(super) mod smaller_models;
