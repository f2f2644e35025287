//! The robot of a draft: its file, and where its chain begins and ends.

use std::path::{Path, PathBuf};

use gravcal_kinematics::UrdfEnds;

use crate::document::{FileError, read_text};
use crate::robot::Robot;

/// A robot with what a session must say to name it.
#[derive(Clone, Debug)]
pub struct DraftRobot {
    /// The robot.
    pub robot: Robot,
    pub(super) path: PathBuf,
    /// Of a URDF.
    pub(super) ends: Option<UrdfEnds>,
    /// Whether base and tips were guessed.
    pub(super) guessed: bool,
}

impl DraftRobot {
    /// Reads a `robot.toml`, or a URDF from `base` to `tips`; where these are not said they are guessed from the names of the recorded
    /// joints, or their number.
    ///
    /// # Errors
    /// The file is no robot, or a URDF whose ends cannot be guessed.
    pub fn read(path: &Path, base: Option<&str>, tips: &[String], recorded: &[&str]) -> Result<DraftRobot, FileError> {
        let is_urdf = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"));
        if !is_urdf {
            if base.is_some() || !tips.is_empty() {
                return Err(FileError::new(path, "only a URDF has links to choose as base and tip: leave them away"));
            }
            return Ok(DraftRobot { robot: Robot::read(path)?, path: path.to_owned(), ends: None, guessed: false });
        }
        let guessed = base.is_none() || tips.is_empty();
        let ends = if guessed { guess(path, recorded)? } else { UrdfEnds { base: String::new(), tips: Vec::new() } };
        let ends = UrdfEnds {
            base: base.map_or(ends.base, str::to_owned),
            tips: if tips.is_empty() { ends.tips } else { tips.to_vec() },
        };
        let named: Vec<&str> = ends.tips.iter().map(String::as_str).collect();
        let robot = Robot::from_urdf_file(path, &ends.base, &named)?;
        Ok(DraftRobot { robot, path: path.to_owned(), ends: Some(ends), guessed })
    }
}

fn guess(path: &Path, recorded: &[&str]) -> Result<UrdfEnds, FileError> {
    let ends = UrdfEnds::guess(&read_text(path)?, recorded).map_err(|error| FileError::new(path, error))?;
    ends.ok_or_else(|| {
        let message = format!(
            "where the chain begins and ends cannot be guessed: its joints have other names than those recorded ({}), and their \
             number does not tell it either; name the first link (base) and the last (tip)",
            recorded.join(", ")
        );
        FileError::new(path, message)
    })
}
