//! How joints hang together where they do not simply follow each other, as `robot.toml` says it.

use gravcal_dynamics::{DhRow, JointKind, Mimic, Transform};
use serde::Deserialize;

use crate::document::{Document, Field, FileError};

/// A frame in a link's: `mounting`.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub(crate) struct MountingTable {
    /// Origin.
    ///
    /// Default: `[0, 0, 0]`.
    /// Example: `position_m = [0, 0.2, 0.4]`
    position_m: [f64; 3],
    /// Roll, pitch and yaw, as in a URDF.
    ///
    /// Default: `[0, 0, 0]`.
    /// Example: `rpy_deg = [-90, 0, 0]`
    rpy_deg: [f64; 3],
}

impl MountingTable {
    /// Pose of the frame in the link's.
    pub fn transform(&self) -> Transform {
        Transform::from_xyz_rpy(self.position_m, self.rpy_deg.map(f64::to_radians))
    }
}

/// `mimic`: a joint that follows another.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct MimicTable {
    /// Name of the leader.
    ///
    /// Example: `joint = "joint2"`
    pub joint: String,
    /// `coordinate = multiplier · leader's coordinate + offset`.
    ///
    /// Unit: 1.
    /// Default: 1.
    /// Example: `multiplier = -1`
    multiplier: Option<f64>,
    /// Offset of a joint that turns.
    ///
    /// Default: 0.
    /// Example: `offset_deg = 0`
    offset_deg: Option<f64>,
    /// The same in radians.
    ///
    /// Default: 0.
    /// Example: `offset_rad = 0`
    offset_rad: Option<f64>,
    /// Offset of a joint that slides.
    ///
    /// Default: 0.
    /// Example: `offset_m = 0.02`
    offset_m: Option<f64>,
}

/// The rows that joints may name.
pub(super) struct Branches<'a> {
    pub document: &'a Document,
    /// Name of the base.
    pub base: &'a str,
    /// Names of the joints.
    pub names: Vec<&'a str>,
    pub rows: &'a [DhRow],
}

impl Branches<'_> {
    /// The link that row `index` hangs on: by default that of the row before, the base for the first.
    pub fn parent(&self, joint: &Field, index: usize, written: Option<&str>) -> Result<Option<usize>, FileError> {
        match written {
            None => Ok(index.checked_sub(1)),
            Some(parent) if parent == self.base => Ok(None),
            Some(parent) => {
                let before: Vec<&str> = self.rows[..index].iter().map(|row| row.link.name.as_str()).collect();
                let known: Vec<&str> = before.iter().copied().chain([self.base]).collect();
                self.document.lookup(&joint.key("parent"), "link in the rows before", parent, &known).map(Some)
            }
        }
    }

    /// Whom a joint of this kind follows, and how.
    pub fn mimic(&self, field: &Field, kind: JointKind, table: &MimicTable) -> Result<Mimic, FileError> {
        let leader = self.document.lookup(&field.key("joint"), "joint", &table.joint, &self.names)?;
        let offsets = [
            ("offset_deg", table.offset_deg.map(f64::to_radians), JointKind::Revolute),
            ("offset_rad", table.offset_rad, JointKind::Revolute),
            ("offset_m", table.offset_m, JointKind::Prismatic),
        ];
        let mut written = offsets.into_iter().filter_map(|(key, offset, of)| Some((key, offset?, of)));
        let offset = written.next();
        if let Some((key, ..)) = offset.filter(|(_, _, of)| *of != kind) {
            let message =
                "the offset of a revolute joint is offset_deg or offset_rad, that of a prismatic one offset_m";
            return Err(self.document.error(&field.key(key), message));
        }
        if let Some((key, ..)) = written.next() {
            return Err(self.document.error(&field.key(key), "the offset is given twice: keep one"));
        }
        let multiplier = table.multiplier.unwrap_or(1.0);
        Ok(Mimic { leader, multiplier, offset: offset.map_or(0.0, |(_, offset, _)| offset) })
    }
}
