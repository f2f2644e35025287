//! In which order readings enter: see [`groups`](super::groups).

use std::collections::BTreeSet;

/// In which order readings enter.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// All at once.
    Together,
    /// Pose and joint of the readings of one step after the other.
    StepByStep(Vec<BTreeSet<(usize, usize)>>),
    /// All poses of the session before this one at once, then one after the other.
    PoseByPose {
        /// Index in the session.
        from: usize,
    },
}
