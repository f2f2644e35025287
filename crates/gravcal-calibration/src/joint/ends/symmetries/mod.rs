//! Images of a solution, of which a start may have found the wrong one: one list, which [`gravcal_identification::settle`] goes through.
//!
//! | file | image |
//! |---|---|
//! | `upside_down.rs` | gravity the other way up, where no hemisphere is declared |
//! | `hemisphere.rs` | the same, or a joint half a turn on, where the end lies in the other hemisphere than the declared one |
//! | `mirrored.rs` | the vector between two placements, reversed along an axis |
//! | `axes.rs` | axes counted from their other ends, with gains of the other sign than declared or offsets half a turn on |
//!
//! Where the readings say little, an end that is not as declared has no exact image; `hemisphere.rs` and `axes.rs` then follow a start from the
//! declared values, too.
//!
//! They are solutions of the problem that the session states. What the session itself may have got wrong (`joint/mistakes/`) is another problem.

mod axes;
mod hemisphere;
mod mirrored;
mod settled;
mod upside_down;

pub(in crate::joint) use axes::{far_offsets, not_as_declared, turned_gains};
pub(in crate::joint) use hemisphere::in_hemisphere;
pub(in crate::joint) use settled::settled;
pub(crate) use upside_down::with_gains_known;
