//! What a session may have got wrong: sensors that read the other way, exchanged columns, a load that was taken off or put on, single
//! readings that are bad.

pub(super) mod bad_readings;
pub(super) mod changed_load;
pub(super) mod exchanged_axes;
pub(super) mod hypotheses;
pub(super) mod other_link;
pub(super) mod reversed;
