//! The poses: sweeps, and random ones.

use std::path::Path;

use gravcal_robot_model::session::{Load, PoseTable};

use super::reader::Reader;
use super::tables::SweepTable;
use crate::document::{Field, FileError};
use crate::simulation::Run;

/// Poses of one table at most: a day of standing still for a second each.
const MOST_POSES: usize = 100_000;

impl Reader<'_> {
    pub fn runs(&self, loads: &[Load]) -> Result<(Vec<PoseTable>, Vec<Run>), FileError> {
        let mut runs = Vec::new();
        for (index, sweep) in self.table.sweep.iter().enumerate() {
            let field = Field::new("sweep").at(index);
            let table = self.pose_table(&field, &sweep.file, sweep.load.as_deref(), loads)?;
            runs.push((PoseTable { step: sweep.step, ..table }, self.sweep(&field, sweep)?));
        }
        for (index, random) in self.table.random.iter().enumerate() {
            let field = Field::new("random").at(index);
            let table = self.pose_table(&field, &random.file, random.load.as_deref(), loads)?;
            self.enough(&field, random.poses)?;
            if random.moving.is_some_and(|moving| !(1..=self.names().len()).contains(&moving)) {
                let message = format!("expected 1 to {} joints that move", self.names().len());
                return Err(self.document.error(&field.key("moving"), message));
            }
            runs.push((table, Run::Random { poses: random.poses, moving: random.moving }));
        }
        if runs.is_empty() {
            let message = "nothing to simulate: add [[sweep]] or [[random]]";
            return Err(self.document.error(&Field::new("sweep"), message));
        }
        let files: Vec<String> = runs.iter().map(|(table, _)| table.path.to_string_lossy().into_owned()).collect();
        let sweeps = self.table.sweep.len();
        self.document.check_names(files.iter().map(String::as_str), |i| {
            let (key, index) = if i < sweeps { ("sweep", i) } else { ("random", i - sweeps) };
            Field::new(key).at(index).key("file")
        })?;
        Ok(runs.into_iter().unzip())
    }

    fn enough(&self, field: &Field, poses: usize) -> Result<(), FileError> {
        let message = match poses {
            0 => "0 poses identify nothing: expected 2 at least".to_owned(),
            1 => "1 pose identifies nothing: expected 2 at least".to_owned(),
            _ if poses > MOST_POSES => format!("{poses} poses are too many: expected {MOST_POSES} at most"),
            _ => return Ok(()),
        };
        Err(self.document.error(&field.key("poses"), message))
    }

    fn pose_table(
        &self,
        field: &Field,
        file: &Path,
        load: Option<&str>,
        loads: &[Load],
    ) -> Result<PoseTable, FileError> {
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let (known, what) = match self.table.recording {
            None => (&["csv"][..], "a CSV file in the session's own folder, such as \"poses.csv\""),
            Some(_) => (
                &["mcap", "csv", "parquet"][..],
                "a recording in the session's own folder, such as \"poses.mcap\" (or .csv, .parquet)",
            ),
        };
        if file.components().count() != 1 || !known.contains(&ending) {
            return Err(self.document.error(&field.key("file"), format!("expected the name of {what}")));
        }
        let load = load.map(|name| self.load(&field.key("load"), name, loads)).transpose()?;
        Ok(PoseTable { path: file.to_owned(), load, swept: None, step: None })
    }

    fn sweep(&self, field: &Field, sweep: &SweepTable) -> Result<Run, FileError> {
        self.enough(field, sweep.poses)?;
        if let Some(step) = sweep.step.filter(|step| !(1..=3).contains(step)) {
            return Err(self.document.error(&field.key("step"), format!("{step} is no step: expected 1, 2 or 3")));
        }
        let names = self.names();
        let swept = self.document.lookup(&field.key("joint"), "joint", &sweep.joint, &names)?;
        let mut held = vec![None; names.len()];
        for (key, table, to_rad) in
            [("held_deg", &sweep.held_deg, 1f64.to_radians()), ("held_rad", &sweep.held_rad, 1.0)]
        {
            for (name, value) in table.iter().flatten() {
                let joint = self.document.lookup(&field.key(key).key(name), "joint", name, &names)?;
                if joint == swept || held[joint].is_some() {
                    let message = format!("{name} is swept, or given twice");
                    return Err(self.document.error(&field.key(key).key(name), message));
                }
                held[joint] = Some(value * to_rad);
            }
        }
        if let Some(joint) = (0..names.len()).find(|joint| *joint != swept && held[*joint].is_none()) {
            let message = format!("where does {} stand? add it to held_deg or held_rad", names[joint]);
            return Err(self.document.error(field, message));
        }
        Ok(Run::Sweep {
            swept,
            range: sweep.range_deg.map(f64::to_radians),
            poses: sweep.poses,
            held: held.into_iter().map(|position| position.unwrap_or(0.0)).collect(),
        })
    }
}
