//! A file that was read for a session.

use std::path::PathBuf;

use gravcal_recording::InputRole;

/// A file that was read for a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// What it is for.
    pub role: InputRole,
    /// Where it is.
    pub path: PathBuf,
}

impl InputFile {
    /// A file for `role`.
    pub fn new(role: InputRole, path: impl Into<PathBuf>) -> InputFile {
        InputFile { role, path: path.into() }
    }
}
