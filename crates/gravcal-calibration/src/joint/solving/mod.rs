//! From a start to its end, with noise that no reading states, and from several starts to the likeliest end.

pub(super) mod fit;
pub(super) mod groups;
pub(super) mod in_order;
pub(super) mod noise;
pub(super) mod other_starts;
pub(super) mod robust;
pub(super) mod solve_from;
