//! Where a session or a simulation says its robot comes from: `robot = …`.

use std::fmt;
use std::path::{Path, PathBuf};

use gravcal_robot_model::robot::Robot;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use super::file::{read_robot, read_urdf};
use crate::document::{Document, Field, FileError, OneOrMany};

/// `robot = "robot.toml"`, or `robot = { urdf = "robot.urdf", base = "base_link", tip = "tool0" }`; of a robot that
/// branches `tip = ["left_hand", "right_hand"]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RobotSource {
    /// Path of a `robot.toml`.
    Toml(String),
    /// A chain within a URDF.
    Urdf(UrdfSource),
}

/// A chain within a URDF.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct UrdfSource {
    /// Path of the file.
    ///
    /// Example: `urdf = "arm.urdf"`
    urdf: String,
    /// The link whose frame gravity is given in.
    ///
    /// Example: `base = "link_0"`
    base: String,
    /// The last link, or that of each branch.
    ///
    /// Example: `tip = ["left_hand", "right_hand"]`
    tip: OneOrMany<String>,
}

/// Reads the robot that a field names. Gives the path of its file as well.
///
/// # Errors
/// The file cannot be read, or is no robot; the error tells which field named it.
pub(crate) fn resolve_robot(
    document: &Document,
    field: &Field,
    source: &RobotSource,
) -> Result<(Robot, PathBuf), FileError> {
    match source {
        RobotSource::Toml(written) if is_urdf(written) => Err(document.error(
            field,
            format!(
                "of a URDF one must also know where the chain begins and ends: write robot = {{ urdf = \"{written}\", \
                 base = \"<base link>\", tip = \"<last link>\" }}"
            ),
        )),
        RobotSource::Toml(written) => read_named(document, field, written, read_robot),
        RobotSource::Urdf(UrdfSource { urdf, base, tip }) => {
            let tips: Vec<&str> = match tip {
                OneOrMany::One(tip) => vec![tip],
                OneOrMany::Many(tips) => tips.iter().map(String::as_str).collect(),
            };
            read_named(document, &field.key("urdf"), urdf, |path| read_urdf(path, base, &tips))
        }
    }
}

fn is_urdf(written: &str) -> bool {
    Path::new(written).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"))
}

fn read_named(
    document: &Document,
    field: &Field,
    written: &str,
    read: impl Fn(&Path) -> Result<Robot, FileError>,
) -> Result<(Robot, PathBuf), FileError> {
    let path = document.resolve_path(field, written)?;
    let robot = read(&path).map_err(|error| error.with_note(document.named_by(field, written)))?;
    Ok((robot, path))
}

// By hand and not as an untagged enum, whose errors neither say what was found nor where.
impl<'de> Deserialize<'de> for RobotSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SourceVisitor)
    }
}

struct SourceVisitor;

impl<'de> Visitor<'de> for SourceVisitor {
    type Value = RobotSource;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the path of a robot.toml, or { urdf = \"…\", base = \"…\", tip = \"…\" }")
    }

    fn visit_str<E: Error>(self, path: &str) -> Result<RobotSource, E> {
        Ok(RobotSource::Toml(path.to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<RobotSource, A::Error> {
        UrdfSource::deserialize(MapAccessDeserializer::new(table)).map(RobotSource::Urdf)
    }
}
