//! Writes a simulated session whose tables are recordings in motion.

use std::path::{Path, PathBuf};

use gravcal_recording::{Heading, RowWriter, create};

use super::write::{self, SimulateError, position_column, torque_column};
use super::{Motion, Simulation, record};

/// Writes the recordings, then what names them. Gives the files, `session.toml` first.
pub(super) fn write(
    simulation: &Simulation,
    motion: &Motion,
    trial: u64,
    folder: &Path,
    overwrite: bool,
) -> Result<Vec<PathBuf>, SimulateError> {
    let texts = write::texts_of_recording(simulation, folder)?;
    write::refuse_others(&texts, folder, overwrite)?;
    let recordings: Vec<PathBuf> = simulation.template.tables.iter().map(|table| folder.join(&table.path)).collect();
    if let Some(path) = recordings.iter().find(|path| !overwrite && path.exists()) {
        return Err(SimulateError::Exists(path.clone()));
    }
    let headings = (0..recordings.len()).map(|table| heading(simulation, table));
    let mut writers: Vec<Box<dyn RowWriter>> = recordings
        .iter()
        .zip(headings)
        .map(|(path, heading)| create(path, &heading, overwrite))
        .collect::<Result<_, _>>()?;
    record(simulation, motion, trial, &mut |table, cells| writers[table].write(cells))?;
    writers.into_iter().try_for_each(RowWriter::finish)?;
    let mut files = write::write_all(&texts, folder, overwrite)?;
    files.splice(1..1, recordings);
    Ok(files)
}

fn heading(simulation: &Simulation, table: usize) -> Heading {
    let joints = 0..simulation.template.joints.len();
    let positions = joints.clone().map(|joint| position_column(simulation, joint));
    let torques = joints.map(|joint| torque_column(simulation, joint));
    let load = simulation.template.tables[table].load;
    let load = load.map(|load| ("load".to_owned(), simulation.template.loads[load].name.clone()));
    Heading {
        columns: ["time_s".to_owned()].into_iter().chain(positions).chain(torques).collect(),
        metadata: load.into_iter().collect(),
    }
}
