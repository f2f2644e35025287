//! Where else the truth may be than where a solve ended.
//!
//! | list | what is on it |
//! |---|---|
//! | `symmetries/settled.rs` | images of a solution, one of which takes its place |
//! | `other_ends.rs` | other starts, whose ends may take the solution's place, or are kept beside it |
//! | `of_judge.rs` | the end of the method that judges, where another found a solution that leaves something open |
//! | `nearby.rs` | places near the solution at which readings say less: these widen intervals, or deny what is told |
//!
//! Beside them stand where a solution rests of which much is open (`resting.rs`), how wide profiles are (`profiles.rs`), and the vector between two
//! placements, of which only the length is known (`displaced.rs`).

mod aligned;
pub(super) mod displaced;
mod mirrored_standing;
mod near_declared;
mod nearby;
mod nearer_to_nominal;
mod of_judge;
pub(super) mod other_ends;
mod other_start;
mod profiles;
mod resting;
mod surroundings;
pub(super) mod symmetries;
