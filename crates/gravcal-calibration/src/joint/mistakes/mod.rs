//! What a session may have got wrong: sensors that read the other way, exchanged columns, a load that was taken off or put on, single
//! readings that are bad. To add one, implement `Hypothesis` in a file of its own and list it in `search.rs`.

mod assumed_masses;
pub(super) mod bad_readings;
mod changed_load;
pub(super) mod evident;
mod exchanged_axes;
mod exchanged_load;
pub(super) mod hypothesis;
mod likelihood;
mod mislabelled_poses;
mod other_hemisphere;
mod other_link;
mod other_unit;
pub(super) mod reversed;
mod reversed_in_table;
pub(super) mod search;
mod swapped_columns;
mod turned_orientations;
mod turned_sensors;
