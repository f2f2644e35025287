//! What several programs that measure share.

pub mod clock;
pub mod population;
pub mod program;
pub mod seven_joints;
