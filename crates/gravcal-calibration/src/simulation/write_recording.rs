//! Writes a simulated session whose tables are recordings in motion.

use std::path::{Path, PathBuf};

use gravcal_recording::{Heading, NewFiles, RowWriter, create};

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
    let mut new = NewFiles::begin(folder)?;
    let mut writers: Vec<Box<dyn RowWriter>> = Vec::new();
    for (table, path) in recordings.iter().enumerate() {
        let place = new.place(&simulation.template.tables[table].path)?;
        writers.push(create(&place, &heading(simulation, table), false).map_err(|error| error.at(path))?);
    }
    let mut sink =
        |table: usize, cells: &[f64]| writers[table].write(cells).map_err(|error| error.at(&recordings[table]));
    record(simulation, motion, trial, &mut sink)?;
    for (writer, path) in writers.into_iter().zip(&recordings) {
        writer.finish().map_err(|error| error.at(path))?;
    }
    texts.iter().try_for_each(|(name, bytes)| new.write(name, bytes))?;
    new.finish()?;
    Ok(write::session_files(simulation, folder))
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

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::session::Session;
    use crate::simulation::{Motion, Simulation, record, write_session};
    use crate::testing::TWO_JOINTS;

    const SIMULATION: &str = r#"
robot = "robot.toml"
seed = 3
[gravity]
direction = [0, 1, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 0.001
[position]
unit = "rad"
std = 1e-5
[recording]
rate_hz = 500
samples = 150
move_s = 0.4
settling_s = 0.2
vibration = 10
settling_time_constant_s = 0.03
touched = 1
[[load]]
name = "plate"
mass_kg = 1
link = "forearm"
position_m = [0.1, 0, 0]
[[joint]]
name = "elbow"
sensor_models = [{ kind = "coulomb-friction", parameters = { coulomb_friction = { value = 0.1, unit = "Nm" } } }]
[[random]]
file = "bare.mcap"
poses = 12
[[random]]
file = "loaded.csv"
poses = 8
load = "plate"
"#;

    fn simulation(folder: &Path) -> Simulation {
        fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
        fs::write(folder.join("simulation.toml"), SIMULATION).unwrap();
        Simulation::read(&folder.join("simulation.toml")).unwrap()
    }

    /// What is read from the files is what stood there, with the sides from which joints came and without the touched pose; the
    /// load that only the MCAP file's metadata would name stands in the session.
    #[test]
    fn recordings_are_written_and_their_standstills_read() {
        let folder = tempfile::tempdir().unwrap();
        let simulation = simulation(folder.path());
        let motion: &Motion = simulation.motion.as_ref().unwrap();
        let perfect = record::<()>(&simulation, motion, 0, &mut |_, _| Ok(())).unwrap();
        let files = write_session(&simulation, 0, folder.path(), false).unwrap();
        assert!(write_session(&simulation, 0, folder.path(), false).unwrap_err().to_string().contains("--overwrite"));
        let read = Session::read(&files[0]).unwrap();
        let expected: Vec<_> = perfect
            .session
            .poses
            .iter()
            .zip(&perfect.standstills)
            .filter(|(_, s)| !s.touched)
            .map(|(p, _)| p)
            .collect();
        assert_eq!((read.poses.len(), expected.len()), (19, 19), "{:?}", read.searched);
        for (pose, expected) in read.poses.iter().zip(expected) {
            assert_eq!((pose.table, pose.load), (expected.table, expected.load));
            for (reading, expected) in pose.torque.iter().flatten().zip(expected.torque.iter().flatten()) {
                let std = expected.std.unwrap();
                assert!((reading.value - expected.value).abs() < 5.0 * std, "{reading:?} {expected:?}");
                assert!((0.5 * std..1.5 * std).contains(&reading.std.unwrap()));
            }
        }
        // The first pose of a recording comes from nowhere.
        assert_eq!(read.poses[0].conditions.direction, [0.0, 0.0]);
        assert_eq!(read.poses[1].conditions.direction, perfect.session.poses[1].conditions.direction);
        let notes: Vec<String> = read.searched.iter().flat_map(|searched| searched.notes(&read.readings)).collect();
        assert!(notes.iter().any(|note| note.contains("as if the arm were touched")), "{notes:?}");
        assert!(notes[0].starts_with("bare.mcap: "), "{notes:?}");
    }

    #[test]
    fn a_session_of_recordings_says_nothing_twice_and_takes_parts() {
        let folder = tempfile::tempdir().unwrap();
        let files = write_session(&simulation(folder.path()), 0, folder.path(), false).unwrap();
        let session = fs::read_to_string(&files[0]).unwrap();
        let with = |old: &str, new: &str| {
            assert!(session.contains(old), "{session}");
            fs::write(&files[0], session.replacen(old, new, 1)).unwrap();
            Session::read(&files[0]).map_err(|error| error.to_string())
        };
        let part = "file = \"bare.mcap\"";
        let halves = with(part, "file = \"bare.mcap\"\nuntil_s = 5.0\n[[poses]]\nfile = \"bare.mcap\"\nfrom_s = 5.0");
        assert_eq!(halves.unwrap().tables.len(), 3);
        let twice = with(part, "file = \"bare.mcap\"\nuntil_s = 5.0\n[[poses]]\nfile = \"bare.mcap\"\nfrom_s = 4.0");
        assert!(twice.unwrap_err().contains("every reading may enter once only"));
        let empty = with(part, "file = \"bare.mcap\"\nfrom_s = 5.0\nuntil_s = 5.0").unwrap_err();
        assert!(empty.contains("expected a time after from_s"), "{empty}");
        let noise = with("[readings.torque]", "[readings.torque]\nstd = 0.1").unwrap_err();
        assert!(noise.contains("readings.still: poses are found in the recordings, and so is the noise"), "{noise}");
        let short = with("[readings.still]", "[readings.still]\nleast_duration_s = 100").unwrap_err();
        assert!(short.contains("bare.mcap: no standstill and no slow sweep is found in it"), "{short}");
        let other =
            with("load = \"plate\"", "").map(|session| session.poses.iter().filter(|p| p.load.is_some()).count());
        assert!(other.is_ok_and(|loaded| loaded > 5), "the recording names its load itself");
    }
}
