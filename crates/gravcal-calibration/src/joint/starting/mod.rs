//! Where a solve starts.

pub(super) mod any_gravity;
pub(super) mod at_distances;
pub(super) mod directions;
pub(super) mod gravity_free;
pub(super) mod linear_part;
pub(super) mod sample;
pub(super) mod start;
