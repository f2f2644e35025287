//! Why no session can be drawn up.

use crate::document::FileError;

/// Why no session can be drawn up.
#[derive(Debug, thiserror::Error)]
pub enum DraftError {
    /// The robot's file cannot be read.
    #[error(transparent)]
    Robot(#[from] FileError),
    /// It cannot be told which columns are positions.
    #[error(
        "which columns are the joints' positions and torques is not told by their names: expected such as \
         `shoulder.position` and `shoulder.effort`, or `q1_deg` and `tau1_Nm`; or, of a wrist sensor that is turned without joints, \
         `qx`, `qy`, `qz`, `qw` and `fx`, `fy`, `fz`, `tx`, `ty`, `tz`; the columns are {columns}"
    )]
    NoJoints {
        /// Names of the columns.
        columns: String,
    },
    /// No joint has a torque.
    #[error(
        "no column is a torque reading, as far as names tell, and without torque there is nothing to calibrate; the columns are {columns}"
    )]
    NoTorques {
        /// Names of the columns.
        columns: String,
    },
    /// Names of columns tell some joints and not others, and the columns stand in another order than the joints.
    #[error(
        "the names of columns tell which joint of the robot is which, but for {missing}; the columns {columns} name no joint of the \
         robot, and those that do stand in another order than its joints, so that the order does not tell it either; give these columns \
         the names of the joints, or write the session by hand"
    )]
    HalfNamed {
        /// Names of the robot's joints that no column bears.
        missing: String,
        /// Columns of positions that name none of the robot's joints.
        columns: String,
    },
    /// The robot has joints that the recording has not.
    #[error(
        "of the robot's {joints} joints these are not in the recording: {missing}; the joints whose positions are recorded are \
         {recorded}, and their number does not tell either which is which"
    )]
    OtherJoints {
        /// Names of the robot's joints that are not recorded.
        missing: String,
        /// How many joints the robot has.
        joints: usize,
        /// Names of the recorded ones.
        recorded: String,
    },
}
