//! `[[poses]]` that are recordings in motion: their standstills become poses.

use gravcal_recording::{PoseMapping, ReadError, Rejected, Stillness, open, static_poses};

use super::SessionError;
use super::poses::{PosesTable, ReadPoses, count_time_from_first, field, in_table};
use crate::document::{Document, FileError};
use crate::session::{Load, PoseTable, Searched};

/// The recordings of a session, and what they may carry.
pub(super) struct Recordings<'a> {
    pub document: &'a Document,
    pub written: &'a [PosesTable],
    pub loads: &'a [Load],
}

impl Recordings<'_> {
    /// Reads all of them. A load that only a recording names is entered in its table.
    pub fn read(
        &self,
        tables: &mut [PoseTable],
        mapping: &PoseMapping,
        still: &Stillness,
    ) -> Result<ReadPoses, SessionError> {
        let mut all = ReadPoses::none(mapping.torques.len());
        for (index, (written, table)) in self.written.iter().zip(tables).enumerate() {
            let wrong = |error| in_table(self.document, index, written, error);
            let stillness = Stillness { from: written.from_s, until: written.until_s, ..*still };
            let mut rows = open(&table.path).map_err(wrong)?;
            let standstills = static_poses(&table.path, rows.as_mut(), mapping, &stillness).map_err(wrong)?;
            if standstills.found.is_empty() {
                let rejected = standstills.rejected.iter().map(Rejected::to_string).collect();
                return Err(wrong(ReadError::NoStandstill { path: table.path.clone(), rejected }));
            }
            if let Some(name) = rows.metadata().get("load") {
                table.load = Some(self.load(index, name, table.load)?);
            }
            all.take(index, table.load, standstills.found.iter().map(|found| found.pose.clone()));
            let (path, remarks) = (table.path.clone(), rows.remarks());
            all.searched.push(Searched { path, standstills: Some(standstills), remarks });
        }
        count_time_from_first(&mut all.poses);
        Ok(all)
    }

    /// The load that a recording names, which must be the one that the session says, if it says any.
    fn load(&self, index: usize, name: &str, said: Option<usize>) -> Result<usize, FileError> {
        let known: Vec<&str> = self.loads.iter().map(|load| load.name.as_str()).collect();
        let field = field(index).key("load");
        match said {
            Some(said) if known[said] != name => {
                let message = format!("the recording says that it carries `{name}`, not `{}`", known[said]);
                Err(self.document.error(&field, message))
            }
            _ => self.document.lookup(&field, "load", name, &known),
        }
    }
}
