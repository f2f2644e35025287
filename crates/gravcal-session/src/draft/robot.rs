//! The robot of a draft: its file, and where its chain begins and ends.

use std::path::{Path, PathBuf};

use gravcal_dynamics::{JointKind, UrdfEnds, urdf_moving_joints, urdf_sliding_joints};
use gravcal_robot_model::robot::Robot;

use super::joints::plain;
use crate::document::{FileError, read_text};
use crate::{read_robot, read_urdf};

/// The joints of a recording that have a torque, by their names.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecordedJoints<'a> {
    /// All of them.
    pub all: &'a [&'a str],
    /// Those that move: the chain goes to the last of these.
    pub moving: &'a [&'a str],
}

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
    /// Names of the joints that slide, of a URDF off the chain, too.
    sliding: Vec<String>,
}

impl DraftRobot {
    /// Names of all joints of a `robot.toml`, or of all that move in a URDF: columns may bear them
    /// ([`Inspection::with_joint_names`](gravcal_recording::Inspection::with_joint_names)).
    ///
    /// # Errors
    /// The file is no robot.
    pub fn joint_names(path: &Path) -> Result<Vec<String>, FileError> {
        if is_urdf(path) {
            return urdf_moving_joints(&read_text(path)?).map_err(|error| FileError::new(path, error));
        }
        Ok(read_robot(path)?.chain.joints().iter().map(|joint| joint.name.clone()).collect())
    }

    /// Reads a `robot.toml`, or a URDF from `base` to `tips`; where these are not said they are guessed from the names of the recorded
    /// joints that move, or the number of all.
    ///
    /// # Errors
    /// The file is no robot, or a URDF whose ends cannot be guessed.
    pub fn read(
        path: &Path,
        base: Option<&str>,
        tips: &[String],
        recorded: RecordedJoints<'_>,
    ) -> Result<DraftRobot, FileError> {
        if !is_urdf(path) {
            if base.is_some() || !tips.is_empty() {
                return Err(FileError::new(path, "only a URDF has links to choose as base and tip: leave them away"));
            }
            let robot = read_robot(path)?;
            let slides = robot.chain.joints().iter().filter(|joint| joint.kind == JointKind::Prismatic);
            let sliding = slides.map(|joint| joint.name.clone()).collect();
            return Ok(DraftRobot { robot, path: path.to_owned(), ends: None, guessed: false, sliding });
        }
        let guessed = base.is_none() || tips.is_empty();
        let ends = match base {
            Some(base) if !tips.is_empty() => UrdfEnds { base: base.to_owned(), tips: tips.to_vec() },
            Some(base) => UrdfEnds { base: base.to_owned(), ..guess(path, recorded)? },
            None if tips.is_empty() => guess(path, recorded)?,
            None => guess_base(path, tips)?,
        };
        let named: Vec<&str> = ends.tips.iter().map(String::as_str).collect();
        let robot = read_urdf(path, &ends.base, &named)?;
        let sliding = urdf_sliding_joints(&read_text(path)?).map_err(|error| FileError::new(path, error))?;
        Ok(DraftRobot { robot, path: path.to_owned(), ends: Some(ends), guessed, sliding })
    }

    /// Whether the joint of this name slides, as far as the robot's file knows it.
    pub fn slides(&self, joint: &str) -> bool {
        self.sliding.iter().any(|name| plain(name) == plain(joint))
    }
}

fn is_urdf(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"))
}

fn guess(path: &Path, recorded: RecordedJoints<'_>) -> Result<UrdfEnds, FileError> {
    let RecordedJoints { all: recorded, moving } = recorded;
    let ends = UrdfEnds::guess(&read_text(path)?, moving, recorded.len());
    let ends = ends.map_err(|error| FileError::new(path, error))?;
    ends.ok_or_else(|| {
        let message = format!(
            "where the chain begins and ends cannot be guessed: none of its joints has the name of one that is recorded with a torque \
             ({}), or a name that stands in just one of these, and their number, {}, does not tell it either; name the first link \
             (base) and the last (tip)",
            recorded.join(", "),
            recorded.len()
        );
        FileError::new(path, message)
    })
}

fn guess_base(path: &Path, tips: &[String]) -> Result<UrdfEnds, FileError> {
    let ends = UrdfEnds::guess_base(&read_text(path)?, tips).map_err(|error| FileError::new(path, error))?;
    ends.ok_or_else(|| FileError::new(path, format!("it has no link of such a name: {}", tips.join(", "))))
}
