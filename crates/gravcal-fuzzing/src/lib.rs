//! Every reader of files, as a function of the bytes that a file holds.
//!
//! Whatever they are, a reader ends with what they say or with an error: it neither panics nor hangs, and needs no more memory than
//! its documentation says. `cargo fuzz` looks for bytes that break this (`fuzz/`), and the test of this crate replays those that it
//! has found.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use gravcal_dynamics::Chain;
use gravcal_recording::{CsvWriting, Rewriting, Row, inspect, open, read_earlier, read_earlier_session, rewrite};
use gravcal_report::study::{StudyReport, StudySummary, report_files};
use gravcal_session::simulation::{Simulation, record};
use gravcal_session::{read_robot, read_session};
use gravcal_study::batch::{StudyFolder, merge};
use gravcal_study::measures::measure;
use gravcal_study::plan::Study;
use tempfile::TempDir;

/// Rows of a simulation that are made: it may ask for as many as fill a disk.
const ROWS: usize = 1000;

thread_local! {
    static FOLDER: OnceCell<TempDir> = const { OnceCell::new() };
}

/// Puts bytes into a file of this name, which lies beside a robot and a table of poses, and hands its path on.
#[allow(clippy::panic, reason = "without a folder for temporary files nothing can be tried")]
fn with_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path)) {
    FOLDER.with(|folder| {
        let folder = folder.get_or_init(|| {
            let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
            let files = [
                ("robot.toml", include_str!("../../../models/sarcos-dextrous-arm/robot.toml")),
                ("poses.csv", include_str!("../../../experiments/sarcos-shoulder/bias-1.csv")),
                ("arm.urdf", include_str!("arm.urdf")),
                ("simulation.toml", include_str!("simulation.toml")),
            ];
            for (name, text) in files {
                fs::write(folder.path().join(name), text).unwrap_or_else(|error| panic!("{error}"));
            }
            folder
        });
        let path: PathBuf = folder.path().join(name);
        let made = path.parent().map_or(Ok(()), fs::create_dir_all);
        made.unwrap_or_else(|error| panic!("{error}"));
        fs::write(&path, bytes).unwrap_or_else(|error| panic!("{error}"));
        read(&path);
    });
}

/// Reads a recording to its end, and looks at every reading.
fn recording(path: &Path) {
    let _ = inspect(path, &|share| assert!((0.0..=1.0).contains(&share))).map(|found| found.to_string());
}

/// A CSV file.
pub fn csv(bytes: &[u8]) {
    with_file("recording.csv", bytes, recording);
}

/// An MCAP file, which is read and written again.
pub fn mcap(bytes: &[u8]) {
    with_file("recording.mcap", bytes, |path| {
        recording(path);
        let (output, notes) = (path.with_file_name("again.mcap"), BTreeMap::new());
        let csv = &CsvWriting::default();
        let what = Rewriting { input: path, output: &output, overwrite: true, csv, notes: &notes };
        let mut change = |_: &[String], cells: &mut [f64]| cells.iter_mut().for_each(|cell| *cell *= 2.0);
        let _ = rewrite(&what, &mut change, &mut |_| true).map_err(|error| error.to_string());
    });
}

/// A Parquet file.
pub fn parquet(bytes: &[u8]) {
    with_file("recording.parquet", bytes, recording);
}

/// A bag of ROS 2 in SQLite.
pub fn sqlite(bytes: &[u8]) {
    with_file("recording.db3", bytes, recording);
}

/// A message of joint states, in an MCAP file that holds nothing else: in JSON where it begins with `{`, else in CDR.
pub fn joint_state(bytes: &[u8]) {
    let encoding = if bytes.first() == Some(&b'{') { "json" } else { "cdr" };
    with_file("message.mcap", &file_of(encoding, bytes), |path| {
        let Ok(mut rows) = open(path) else { return };
        let mut row = Row::default();
        while let Ok(true) = rows.read(&mut row) {
            assert_eq!(row.cells.len(), rows.columns().len());
        }
    });
}

/// The smallest MCAP file with one message.
fn file_of(encoding: &str, message: &[u8]) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let record = |opcode: u8, body: &[&[u8]]| {
        let body = body.concat();
        [&[opcode][..], &(body.len() as u64).to_le_bytes(), &body].concat()
    };
    [
        b"\x89MCAP0\r\n".to_vec(),
        record(3, &[&[1, 0], &text("sensor_msgs/msg/JointState"), &text("ros2msg"), &text("")]),
        record(4, &[&[1, 0, 1, 0], &text("/joint_states"), &text(encoding), &text("")]),
        record(5, &[&[1, 0], &[0; 20], message]),
        record(15, &[&[0; 4]]),
    ]
    .concat()
}

/// A URDF, read as text and as a file.
pub fn urdf(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Chain::from_urdf(text, "base", &["tip"]).map_err(|error| error.to_string());
    }
}

/// A session that may name `robot.toml`, `arm.urdf` and `poses.csv`.
pub fn session(bytes: &[u8]) {
    with_file("session.toml", bytes, |path| {
        let _ = read_session(path).map_err(|error| error.to_string());
    });
}

/// A robot.
pub fn robot(bytes: &[u8]) {
    with_file("other.toml", bytes, |path| {
        let _ = read_robot(path).map_err(|error| error.to_string());
    });
}

/// What an earlier calibration found.
pub fn calibration(bytes: &[u8]) {
    with_file("calibration.json", bytes, |path| {
        let _ = read_earlier(path, "joint").map_err(|error| error.to_string());
        let _ = read_earlier_session(path).map_err(|error| error.to_string());
    });
}

/// A simulation that may name `robot.toml` and `arm.urdf`, and the first rows of what it simulates.
pub fn simulation(bytes: &[u8]) {
    with_file("other-simulation.toml", bytes, |path| {
        let Ok(simulation) = Simulation::read(path).map_err(|error| error.to_string()) else { return };
        if simulation.runs.iter().map(|run| run.poses()).sum::<usize>() > ROWS {
            return;
        }
        match &simulation.motion {
            None => drop(simulation.session(0)),
            Some(motion) => {
                let mut rows = 0..ROWS;
                let _ = record(&simulation, motion, 0, &mut |_, _| rows.next().map(|_| ()).ok_or(()));
            }
        }
    });
}

/// A study of `simulation.toml`.
pub fn study(bytes: &[u8]) {
    with_file("study.toml", bytes, |path| {
        let _ = Study::read(path).map_err(|error| error.to_string());
    });
}

/// The `study.json` of a folder with the results of a study.
pub fn study_folder(bytes: &[u8]) {
    results(bytes, include_bytes!("../trials.parquet"));
}

/// The table of all trials in a folder with the results of a study, or of a part of them.
pub fn study_table(bytes: &[u8]) {
    results(include_bytes!("study.json"), bytes);
}

/// Reports of results, and puts them together from parts.
fn results(study: &[u8], trials: &[u8]) {
    with_file("results/study.json", study, |path| {
        let folder = path.with_file_name("");
        let Ok(opened) = StudyFolder::open(&folder).map_err(|error| error.to_string()) else { return };
        with_file("results/trials.parquet", trials, |table| {
            if let Ok(series) = measure(&opened).map_err(|error| error.to_string()) {
                let report = StudyReport { manifest: &opened.manifest, series: &series };
                let _ = report_files(&report).map_err(|error| error.to_string());
                assert!(!report.to_string().is_empty() && !StudySummary(report).to_string().is_empty());
            }
            let _ = fs::remove_file(table);
        });
        with_file("results/parts/00000000.parquet", trials, |_| {
            let _ = merge(&opened, &[]).map_err(|error| error.to_string());
        });
    });
}
