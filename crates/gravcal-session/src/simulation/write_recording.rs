//! Writes a simulated session whose tables are recordings in motion.

use std::path::{Path, PathBuf};

use gravcal_recording::{Heading, NewFiles, RowWriter, create};

use super::experiment::Simulation;
use super::motion::Motion;
use super::recording::record;
use super::write::{self, SimulateError, position_column, torque_column};

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

    use gravcal_robot_model::session::{Pose, Session};

    use crate::read_session;
    use crate::simulation::{Motion, Simulation, record, write_session};
    use crate::testing::TWO_JOINTS;

    /// Joints ring by 0.24 mrad, ten times what one of 150 positions is uncertain by: too little to turn their friction.
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
std = 2e-6
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
        simulation_with(folder, "").unwrap()
    }

    /// `more`: further lines of `[recording]`.
    fn simulation_with(folder: &Path, more: &str) -> Result<Simulation, String> {
        fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
        fs::write(
            folder.join("simulation.toml"),
            SIMULATION.replace("touched = 1\n", &format!("touched = 1\n{more}\n")),
        )
        .unwrap();
        Simulation::read(&folder.join("simulation.toml")).map_err(|error| error.to_string())
    }

    fn recorded(simulation: &Simulation) -> Vec<Vec<f64>> {
        let mut rows = Vec::new();
        let mut keep = |_: usize, cells: &[f64]| {
            rows.push(cells.to_vec());
            Ok::<(), ()>(())
        };
        record(simulation, simulation.motion.as_ref().unwrap(), 0, &mut keep).unwrap();
        rows
    }

    /// Friction at rest and the walk of a zero add to a recording, whose noise stays what it was; the truth tells of both, the session
    /// of neither.
    #[test]
    fn friction_at_rest_and_walks_add_to_the_same_noise() {
        let folder = tempfile::tempdir().unwrap();
        let clean = recorded(&simulation(folder.path()));
        let more = "friction = { coulomb_newton_metre = [0.2, 0.0] }\nwalk_per_root_s = [0.0, 0.01]";
        let rough = simulation_with(folder.path(), more).unwrap();
        let with = recorded(&rough);
        assert_eq!(with, recorded(&rough));
        assert_eq!(with.len(), clean.len());
        // Columns: time, two positions, two torques; the robot's torque gains are 1.
        let moved = with.iter().zip(&clean).map(|(with, clean)| (with[3] - clean[3]).abs()).fold(0.0, f64::max);
        assert!((0.19..0.23).contains(&moved), "{moved}");
        let walk = |rows: &[Vec<f64>], k: usize| rows[k][4] - clean[k][4];
        let steps: Vec<f64> = (1..clean.len()).map(|k| walk(&with, k) - walk(&with, k - 1)).collect();
        let step = (steps.iter().map(|step| step * step).sum::<f64>() / steps.len() as f64).sqrt();
        // Friction moves positions by what the arm goes too far, which gravity feels.
        assert!((step / (0.01 / 500f64.sqrt()) - 1.0).abs() < 0.1, "{step}");
        let files = write_session(&rough, 0, folder.path(), false).unwrap();
        let [session, truth] = [&files[0], files.last().unwrap()].map(|file| fs::read_to_string(file).unwrap());
        assert!(truth.contains("[friction_at_rest]\ncoulomb_newton_metre = [0.2, 0.0]"), "{truth}");
        assert!(truth.contains("walk_per_root_s = [0.0, 0.01]"), "{truth}");
        assert!(!session.contains("newton_metre") && !session.contains("walk"), "{session}");
    }

    /// Once the joints have turned far enough each lacks half of its loop, the elbow a tenth of what the shoulder does; what creeps is gone where the arm has
    /// stood; the truth tells of both, the session of neither.
    #[test]
    fn what_torque_sensors_keep_is_in_the_readings_and_not_in_the_session() {
        let folder = tempfile::tempdir().unwrap();
        let clean = recorded(&simulation(folder.path()));
        let more = "hysteresis = { share = 0.1, over = [0.5, 0.05] }\ncreep = { share = 0.01, time_constant_s = 0.05 }";
        let rough = simulation_with(folder.path(), more).unwrap();
        let with = recorded(&rough);
        // Columns: time, two positions, two torques; of all samples the last of a standstill of 150.
        let lacks =
            |channel: usize| with.iter().zip(&clean).map(move |(with, clean)| (clean[channel] - with[channel]).abs());
        let most = |channel: usize| lacks(channel).fold(0.0, f64::max);
        assert!((0.05..0.25).contains(&most(3)) && most(4) > 1e-3, "{} {}", most(3), most(4));
        let (shoulder, elbow) = (lacks(3).next_back().unwrap(), lacks(4).next_back().unwrap());
        assert!((shoulder - 0.05).abs() < 5e-3 && (elbow - 0.005).abs() < 1e-3, "{shoulder} {elbow}");
        let files = write_session(&rough, 0, folder.path(), false).unwrap();
        let [session, truth] = [&files[0], files.last().unwrap()].map(|file| fs::read_to_string(file).unwrap());
        assert!(truth.contains("[hysteresis]\nshare = 0.1\nover = [0.5, 0.05]"), "{truth}");
        assert!(truth.contains("[creep]\nshare = 0.01\ntime_constant_s = 0.05"), "{truth}");
        assert!(!session.contains("hysteresis") && !session.contains("creep"), "{session}");
    }

    /// What a joint is said to do without the session: a drift and a ripple are in the readings and in the truth only.
    #[test]
    fn what_is_not_modelled_is_in_the_readings_and_not_in_the_session() {
        let folder = tempfile::tempdir().unwrap();
        let clean = simulation(folder.path());
        let unmodelled = "unmodelled = [{ kind = \"torque-bias-in-time\", parameters = { torque_bias_drift = { value = 0.01, unit = \"Nm/s\" } } }]";
        let text = SIMULATION.replace("name = \"elbow\"\n", &format!("name = \"elbow\"\n{unmodelled}\n"));
        fs::write(folder.path().join("simulation.toml"), &text).unwrap();
        let drifting = Simulation::read(&folder.path().join("simulation.toml")).unwrap();
        for (with, without) in recorded(&drifting).iter().zip(&recorded(&clean)) {
            assert_eq!(with[..4], without[..4]);
            assert!((with[4] - without[4] - 0.01 * with[0]).abs() < 1e-9, "{with:?} {without:?}");
        }
        let files = write_session(&drifting, 0, folder.path(), false).unwrap();
        let [session, truth] = [&files[0], files.last().unwrap()].map(|file| fs::read_to_string(file).unwrap());
        assert!(!session.contains("drift") && session.contains("coulomb-friction"), "{session}");
        assert!(truth.contains("[[unmodelled]]\nname = \"elbow.torque_bias_drift\"\nvalue = 0.01"), "{truth}");
        fs::write(
            folder.path().join("simulation.toml"),
            text.replace("parameters = { torque_bias_drift", "parameters = { other"),
        )
        .unwrap();
        let refused = Simulation::read(&folder.path().join("simulation.toml")).unwrap_err().to_string();
        assert!(refused.contains("joint[0].unmodelled[0].parameters.other"), "{refused}");
    }

    #[test]
    fn joints_come_from_the_side_that_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let directions = |approach: &str| {
            let simulation = simulation_with(folder.path(), approach).unwrap();
            let recorded =
                record::<()>(&simulation, simulation.motion.as_ref().unwrap(), 0, &mut |_, _| Ok(())).unwrap();
            let directions = recorded.session.poses.iter().map(|pose| pose.conditions.direction[1]);
            (directions.collect::<Vec<f64>>(), recorded.session.poses)
        };
        let (rising, _) = directions("approach = \"one-way\"");
        assert!(rising[1..12].iter().all(|side| *side == 1.0), "{rising:?}");
        let (both, poses) = directions("approach = \"both-ways\"");
        assert_eq!(both.len(), 40);
        for pair in 1..12 {
            let [first, second] = [&poses[2 * pair], &poses[2 * pair + 1]];
            assert_eq!([both[2 * pair], both[2 * pair + 1]], [1.0, -1.0]);
            assert!((first.position[1] - second.position[1]).abs() < 1e-4);
        }
    }

    #[test]
    fn friction_that_cannot_be_is_refused_by_its_field() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |more: &str| simulation_with(folder.path(), more).unwrap_err();
        let friction = |rest: &str| format!("friction = {{ coulomb_newton_metre = 0.1, {rest} }}");
        assert!(refused(&friction("lean = 2")).contains("recording.friction.lean: 2 is no share"));
        assert!(refused(&friction("presliding_rad = 0")).contains("recording.friction.presliding_rad: "));
        assert!(refused(&friction("spread = -1")).contains("recording.friction.spread: -1 is negative"));
        assert!(refused("friction = { coulomb_newton_metre = -1 }").contains("coulomb_newton_metre: -1 is negative"));
        let hysteresis = refused("hysteresis = { share = 0.1, over = -1 }");
        assert!(hysteresis.contains("recording.hysteresis.over: -1 is negative"), "{hysteresis}");
        let creep = refused("creep = { share = 2, time_constant_s = 3 }");
        assert!(creep.contains("recording.creep.share: 2 is no share"), "{creep}");
        assert!(refused("creep = { share = 0.1, time_constant_s = 0 }").contains("recording.creep.time_constant_s"));
        assert!(refused("walk_per_root_s = [1, 2, 3]").contains("recording.walk_per_root_s"));
        assert!(refused("approach = \"left\"").contains("expected `any`, `one-way` or `both-ways`"));
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
        let read = read_session(&files[0]).unwrap();
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
        // So the elbow, whose friction is estimated, says nothing there; the shoulder does.
        let first_loaded = read.poses.iter().position(|pose| pose.table == 1).unwrap();
        for (place, pose) in read.poses.iter().enumerate() {
            let counts: Vec<bool> = pose.torque.iter().map(Option::is_some).collect();
            assert_eq!(counts, [true, ![0, first_loaded].contains(&place)], "{place}");
        }
        let notes: Vec<String> = read.searched.iter().flat_map(|searched| searched.notes(&read.readings)).collect();
        assert!(notes.iter().any(|note| note.contains("as if the arm were touched")), "{notes:?}");
        assert!(notes[0].starts_with("bare.mcap: "), "{notes:?}");
        let left_out = "bare.mcap: 1 readings of `elbow.effort` are left out: it is not known from which side";
        assert!(notes.iter().any(|note| note.starts_with(left_out)), "{notes:?}");
    }

    /// A slow sweep, with noise of a mean of 100 samples.
    const SWEEP: &str = r#"
robot = "robot.toml"
seed = 5
[gravity]
direction = [0, 1, -3]
magnitude_m_per_s2 = 9.81
[torque]
unit = "N·m"
std = 2.4e-2
[position]
unit = "rad"
[recording]
rate_hz = 500
samples = 100
move_s = 0.4
sweep_deg_per_s = 10
[[sweep]]
file = "shoulder.csv"
joint = "shoulder"
range_deg = [-40, 40]
poses = 2
held_deg = { elbow = 40 }
"#;

    /// The session of a slow sweep, and by how much what the standing elbow reads differs from what gravity makes it read.
    fn swept(folder: &Path, text: &str) -> (Session, Vec<f64>) {
        fs::write(folder.join("robot.toml"), TWO_JOINTS).unwrap();
        fs::write(folder.join("simulation.toml"), text).unwrap();
        let simulation = Simulation::read(&folder.join("simulation.toml")).unwrap();
        let session = read_session(&write_session(&simulation, 0, folder, true).unwrap()[0]).unwrap();
        let masses: Vec<f64> = simulation.truth.inertia.iter().flatten().copied().collect();
        let difference = |pose: &Pose| {
            let mut torque = [0.0; 2];
            session.robot.chain.gravity_torque(&pose.position, simulation.truth.gravity, &masses, &mut torque);
            Some(pose.torque[1]?.value - torque[1])
        };
        let differences = session.poses.iter().filter_map(difference).collect();
        (session, differences)
    }

    /// What the speed of the shoulder makes the elbow read is the same both ways; it is subtracted, or the reading left out where
    /// a third of it exceeds a quarter of what noise leaves in the mean.
    #[test]
    fn a_sweep_is_recorded_slowly_and_its_speed_is_subtracted() {
        let folder = tempfile::tempdir().unwrap();
        let mean = |differences: &[f64]| differences.iter().sum::<f64>() / differences.len() as f64;
        let (session, differences) = swept(folder.path(), SWEEP);
        assert!(session.poses.len() > 60 && differences.len() == session.poses.len(), "{}", differences.len());
        assert!(session.poses.iter().all(|pose| pose.torque[0].is_some()));
        // What noise leaves in the mean is 2.8e-3.
        assert!(mean(&differences).abs() < 8e-3, "{}", mean(&differences));
        // Without masses nothing is subtracted; the readings are the same.
        let robot =
            TWO_JOINTS.lines().filter(|line| !line.starts_with("mass_kg") && !line.starts_with("center_of_mass"));
        fs::write(folder.path().join("robot.toml"), robot.collect::<Vec<_>>().join("\n")).unwrap();
        let bare = read_session(&folder.path().join("session.toml")).unwrap();
        let readings =
            |session: &Session| session.poses.iter().map(|pose| pose.torque[1].unwrap().value).collect::<Vec<_>>();
        let made = mean(&readings(&bare)) - mean(&readings(&session));
        // By hand: the forearm is 1 kg at r = 0.4 cos q + 0.1 sin q from the shoulder's axis, and τ = −m ω² r dr/dq.
        let (speed, (sin, cos)) = (10f64.to_radians(), 40f64.to_radians().sin_cos());
        let expected = -speed.powi(2) * (0.4 * cos + 0.1 * sin) * (0.1 * cos - 0.4 * sin);
        assert!((made / expected - 1.0).abs() < 0.03, "{made} {expected}");
        let (session, differences) = swept(folder.path(), &SWEEP.replace("std = 2.4e-2", "std = 6e-5"));
        assert!(differences.len() < session.poses.len() / 4, "{} of {}", differences.len(), session.poses.len());
        let notes = session.searched[0].notes(&session.readings).concat();
        assert!(notes.contains("predict only within 0.00"), "{notes}");
        let refused = SWEEP.replace("sweep_deg_per_s = 10", "sweep_deg_per_s = 0");
        fs::write(folder.path().join("simulation.toml"), refused).unwrap();
        let refused = Simulation::read(&folder.path().join("simulation.toml")).unwrap_err().to_string();
        assert!(refused.contains("recording.sweep_deg_per_s"), "{refused}");
    }

    /// A load of which nobody states where it is may move otherwise than one in the origin of its link's frame.
    #[test]
    fn what_a_load_does_at_speed_is_known_where_its_place_is() {
        let folder = tempfile::tempdir().unwrap();
        let loaded = format!(
            "{SWEEP}load = \"disc\"\n[[load]]\nname = \"disc\"\nmass_kg = 0.5\nlink = \"forearm\"\nposition_m = [0.02, 0.0, 0.0]\n"
        );
        let read = |session: &Session| session.poses.iter().filter(|pose| pose.torque[1].is_some()).count();
        let (unknown, _) = swept(folder.path(), &loaded);
        let path = folder.path().join("session.toml");
        let text = fs::read_to_string(&path).unwrap();
        let stated = text.replacen("mass_kg = 0.5", "position_m = [0.02, 0.0, 0.0]\nmass_kg = 0.5", 1);
        assert_ne!(stated, text, "{text}");
        fs::write(&path, stated).unwrap();
        let known = read_session(&path).unwrap();
        assert_eq!(unknown.poses.len(), known.poses.len());
        assert!(read(&unknown) < read(&known), "{} {}", read(&unknown), read(&known));
    }

    #[test]
    fn a_session_of_recordings_says_nothing_twice_and_takes_parts() {
        let folder = tempfile::tempdir().unwrap();
        let files = write_session(&simulation(folder.path()), 0, folder.path(), false).unwrap();
        let session = fs::read_to_string(&files[0]).unwrap();
        let with = |old: &str, new: &str| {
            assert!(session.contains(old), "{session}");
            fs::write(&files[0], session.replacen(old, new, 1)).unwrap();
            read_session(&files[0]).map_err(|error| error.to_string())
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
        assert!(
            short.contains("by its clock `time_s` rows come at ") && short.contains(" Hz; let the arm stand for 0.5 s"),
            "{short}"
        );
        let other =
            with("load = \"plate\"", "").map(|session| session.poses.iter().filter(|p| p.load.is_some()).count());
        assert!(other.is_ok_and(|loaded| loaded > 5), "the recording names its load itself");
    }
}
