//! What every section of a session's file is read against, and why it cannot be read.

use std::path::Path;

use gravcal_recording::ReadError;
use gravcal_robot_model::robot::Robot;

use crate::document::{Document, FileError};

/// Why a session cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// Something is wrong with the session's file or the robot's.
    #[error(transparent)]
    File(#[from] FileError),
    /// Something is wrong with a table of poses.
    #[error("{error}\n  {named_by}")]
    Table {
        /// What, and where in the table.
        error: ReadError,
        /// The place in the session that named the table.
        named_by: String,
    },
}

/// What every section is read against.
pub(super) struct Context<'a> {
    pub document: &'a Document,
    pub robot: &'a Robot,
    /// Where the robot was read from, for messages.
    pub robot_path: &'a Path,
    pub joint_names: Vec<&'a str>,
    pub link_names: Vec<&'a str>,
}

impl<'a> Context<'a> {
    pub fn new(document: &'a Document, robot: &'a Robot, robot_path: &'a Path) -> Self {
        let joint_names = robot.chain.joints().iter().map(|joint| joint.name.as_str()).collect();
        let link_names = robot.chain.links().iter().map(|link| link.name.as_str()).collect();
        Context { document, robot, robot_path, joint_names, link_names }
    }
}
