//! What a reader is told of a solution.

pub(super) mod answer;
pub(super) mod conclusion;
pub(super) mod consistent;
pub(super) mod estimate;
mod findings;
pub(super) mod held_out;
mod notes;
pub(super) mod payloads;
pub(super) mod report;
pub(super) mod session_notes;
pub(super) mod smaller_models;
pub(super) mod undetermined;
