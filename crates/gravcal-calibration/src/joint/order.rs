//! In which order readings enter: see [`groups`](super::groups).

use std::collections::BTreeSet;

use gravcal_robot_model::session::ReadingId;

/// In which order readings enter.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// All at once.
    Together,
    /// The readings of one step after the other.
    StepByStep(Vec<BTreeSet<ReadingId>>),
    /// All poses of the session before this one at once, then one after the other.
    PoseByPose {
        /// Index in the session.
        from: usize,
    },
}
