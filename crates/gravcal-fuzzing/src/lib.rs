//! Every reader of files, as a function of the bytes that a file holds.
//!
//! Whatever they are, a reader ends with what they say or with an error: it neither panics nor hangs, and needs no more memory than
//! its documentation says. `cargo fuzz` looks for bytes that break this (`fuzz/`), and the test of this crate replays those that it
//! has found.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use gravcal_calibration::{Robot, Session};
use gravcal_kinematics::Chain;
use gravcal_recording::{CsvWriting, Rewriting, Row, inspect, open, read_earlier, read_earlier_session, rewrite};
use tempfile::TempDir;

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
            ];
            for (name, text) in files {
                fs::write(folder.path().join(name), text).unwrap_or_else(|error| panic!("{error}"));
            }
            folder
        });
        let path: PathBuf = folder.path().join(name);
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
        let _ = Session::read(path).map_err(|error| error.to_string());
    });
}

/// A robot.
pub fn robot(bytes: &[u8]) {
    with_file("other.toml", bytes, |path| {
        let _ = Robot::read(path).map_err(|error| error.to_string());
    });
}

/// What an earlier calibration found.
pub fn calibration(bytes: &[u8]) {
    with_file("calibration.json", bytes, |path| {
        let _ = read_earlier(path, "joint").map_err(|error| error.to_string());
        let _ = read_earlier_session(path).map_err(|error| error.to_string());
    });
}
