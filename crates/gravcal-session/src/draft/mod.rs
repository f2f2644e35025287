//! A session to start from, drawn up from a recording and a robot: whatever names, ranges and rates tell, each guess told as one.
//!
//! ```text
//! Inspection ─┬─► joints and their columns ─► PoseMapping ─► standstills ─┬─► text of a session
//! robot file ─┘                                                           │    (what is missing: comments)
//!                          path of the recording ─────────────────────────┘
//! ```

mod body;
mod error;
mod joints;
mod poses;
mod quoting;
mod recorded;
mod robot;
mod sense;
#[cfg(test)]
mod tests;
mod text;

pub use error::DraftError;
pub use recorded::{Draft, DraftPoses};
pub use robot::{DraftRobot, RecordedJoints};
