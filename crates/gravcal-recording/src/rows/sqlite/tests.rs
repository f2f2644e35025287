//! Bags in SQLite, written here as rosbag2 writes them, whole and damaged.

use std::fs;
use std::path::{Path, PathBuf};

use rusqlite::{Connection, params};

use super::*;
use crate::rows::joint_state::cdr;
use crate::rows::open;

const TABLES: &str = "
    CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
        offered_qos_profiles TEXT NOT NULL);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
    CREATE INDEX timestamp_idx ON messages (timestamp ASC);
    INSERT INTO topics VALUES (1, '/chatter', 'std_msgs/msg/String', 'cdr', ''),
        (2, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr', '');";

fn message(position: f64) -> Vec<u8> {
    let mut data = Vec::new();
    cdr::write(&mut data, (0, 0), &["a", "b"], [&[position, 2.0], &[], &[3.0, 4.0]]);
    data
}

/// A bag with so many messages of joint states, one a second, and as many of another topic.
fn write(path: &Path, count: u32, first: u32, data: impl Fn(Vec<u8>) -> Vec<u8>) -> Connection {
    let mut database = Connection::open(path).unwrap();
    database.execute_batch(TABLES).unwrap();
    let transaction = database.transaction().unwrap();
    for second in first..first + count {
        let time = i64::from(second) * 1_000_000_000;
        let sql = "INSERT INTO messages (topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        transaction.execute(sql, params![1, time, b"hello"]).unwrap();
        transaction.execute(sql, params![2, time, data(message(f64::from(second)))]).unwrap();
    }
    transaction.commit().unwrap();
    database
}

struct Said {
    columns: Vec<String>,
    times: Vec<f64>,
    positions: Vec<f64>,
    remarks: Vec<String>,
}

fn read(path: &Path) -> Result<Said, String> {
    let mut rows = open(path).map_err(|error| error.to_string())?;
    let (mut row, mut times, mut positions) = (Row::default(), Vec::new(), Vec::new());
    while rows.read(&mut row).map_err(|error| error.to_string())? {
        assert!((0.0..=1.0).contains(&rows.progress()));
        times.push(row.cells[0]);
        positions.push(row.cells[1]);
    }
    Ok(Said { columns: rows.columns().to_vec(), times, positions, remarks: rows.remarks() })
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

fn seconds(range: std::ops::Range<u32>) -> Vec<f64> {
    range.map(f64::from).collect()
}

#[test]
fn messages_are_rows_and_nothing_is_left_beside_the_file() {
    let folder = Folder::new();
    let path = folder.path("a bag?%41#.db3");
    write(&path, 10_000, 5, |data| data).close().unwrap();
    let said = read(&path).unwrap();
    assert_eq!(said.columns, ["time_s", "a.position", "b.position", "a.effort", "b.effort"]);
    assert_eq!((said.times, said.positions), (seconds(5..10_005), seconds(5..10_005)));
    assert_eq!(said.remarks, Vec::<String>::new());
    let topics = open(&path).unwrap().source();
    assert_eq!((topics.kind.as_str(), topics.topics.len()), ("ROS 2 bag in SQLite", 2));
    assert_eq!(fs::read_dir(folder.0.path()).unwrap().count(), 1);
}

#[test]
fn what_the_recorder_has_not_moved_into_the_file_yet_is_read_too() {
    let folder = Folder::new();
    let path = folder.path("a.db3");
    Connection::open(&path).unwrap().execute_batch("PRAGMA journal_mode = WAL").unwrap();
    let recorder = write(&path, 20, 0, |data| data);
    assert!(fs::metadata(folder.path("a.db3-wal")).unwrap().len() > 0);
    assert_eq!(read(&path).unwrap().times, seconds(0..20));
    recorder.close().unwrap();
    assert_eq!(read(&path).unwrap().times, seconds(0..20));
}

#[test]
fn compressed_messages_are_read() {
    let folder = Folder::new();
    let path = folder.path("a.db3");
    let compress = |data: Vec<u8>| zstd::bulk::compress(&data, 1).unwrap();
    write(&path, 20, 0, |data| if data[40] % 2 == 0 { compress(data) } else { data }).close().unwrap();
    assert_eq!(read(&path).unwrap().positions, seconds(0..20));
    let cut = folder.path("cut.db3");
    write(&cut, 20, 0, |data| if data == message(7.0) { compress(data)[..20].to_vec() } else { compress(data) });
    let said = read(&cut).unwrap();
    assert_eq!(said.positions.len(), 19);
    let expected = "/joint_states: 1 of 20 messages are damaged and left out (its compressed bytes are damaged), the first is message 8";
    assert_eq!(said.remarks, [expected]);
}

#[test]
fn the_files_of_a_folder_are_read_in_the_order_of_their_times() {
    let folder = Folder::new();
    let bag = folder.path("bag");
    fs::create_dir(&bag).unwrap();
    write(&bag.join("b_0.db3"), 5, 10, |data| data).close().unwrap();
    write(&bag.join("b_1.db3"), 5, 0, |data| data).close().unwrap();
    let expected = [seconds(0..5), seconds(10..15)].concat();
    assert_eq!(read(&bag).unwrap().times, expected);
    fs::write(bag.join("metadata.yaml"), "  relative_file_paths:\n    - b_0.db3\n    - b_2.db3\n    - b_1.db3.zstd\n")
        .unwrap();
    let said = read(&bag).unwrap();
    assert_eq!(
        (said.times, said.remarks),
        (expected, vec!["metadata.yaml names b_2.db3, which is not there".to_owned()])
    );
    fs::rename(bag.join("b_1.db3"), bag.join("b_1.db3.zstd")).unwrap();
    let remarks = read(&bag).unwrap().remarks;
    assert!(
        remarks[1].starts_with("b_1.db3.zstd is compressed as a whole and left out: unpack it first"),
        "{remarks:?}"
    );
    fs::remove_file(bag.join("b_0.db3")).unwrap();
    let error = read(&bag).err().unwrap();
    assert!(error.contains("the files of this bag are compressed as a whole: unpack them first"), "{error}");
}

#[test]
fn other_databases_are_refused() {
    let folder = Folder::new();
    let path = folder.path("a.db3");
    let database = Connection::open(&path).unwrap();
    database.execute_batch("CREATE TABLE topics(id, name, type, serialization_format)").unwrap();
    let error = read(&path).err().unwrap();
    assert!(error.contains("it is a SQLite file, but no bag of ROS 2: it has no table `messages`"), "{error}");
    // A view without end.
    let view = "CREATE VIEW messages AS WITH RECURSIVE m(rowid) AS (SELECT 1 UNION ALL SELECT rowid + 1 FROM m)
                SELECT rowid, 2 AS topic_id, 0 AS timestamp, '' AS data FROM m";
    database.execute_batch(view).unwrap();
    assert!(read(&path).err().unwrap().contains("it has no table `messages`"));
    let path = folder.path("b.db3");
    write(&path, 0, 0, |data| data).close().unwrap();
    let error = read(&path).err().unwrap();
    assert!(
        error.contains("it has no messages of joint states") && error.contains("/chatter (std_msgs/msg/String in cdr)")
    );
}

#[test]
fn of_a_file_that_is_cut_the_first_messages_are_read() {
    let folder = Folder::new();
    let [path, cut] = ["a.db3", "cut.db3"].map(|name| folder.path(name));
    write(&path, 3000, 0, |data| data).close().unwrap();
    let whole = fs::read(&path).unwrap();
    let mut most = 0;
    for pages in [20, 40, 60] {
        fs::write(&cut, &whole[..pages * 4096 + 100]).unwrap();
        let said = read(&cut).unwrap();
        assert!(said.times.len() > most, "{pages} pages: {}", said.times.len());
        most = said.times.len();
        assert_eq!(said.times, seconds(0..most as u32));
        assert!(said.remarks[0].starts_with("the SQLite file is damaged"), "{:?}", said.remarks);
    }
}

#[test]
fn a_damaged_page_is_lost_and_said_and_the_others_are_read() {
    let folder = Folder::new();
    let [path, bad] = ["a.db3", "bad.db3"].map(|name| folder.path(name));
    write(&path, 3000, 0, |data| data).close().unwrap();
    let whole = fs::read(&path).unwrap();
    let leaf =
        |page: &&usize| whole[**page * 4096] == 13 && whole[**page * 4096..][..4096].windows(5).any(|w| w == b"hello");
    let pages: Vec<usize> = (0..whole.len() / 4096).collect();
    let leaves: Vec<usize> = pages.iter().filter(leaf).copied().collect();
    let damaged = leaves[leaves.len() / 2];
    let mut bytes = whole.clone();
    bytes[damaged * 4096..][..100].fill(0xAA);
    fs::write(&bad, bytes).unwrap();
    let said = read(&bad).unwrap();
    let lost = 3000 - said.times.len();
    assert!((1..100).contains(&lost), "{lost}");
    assert!(said.times.windows(2).all(|pair| pair[0] < pair[1]) && said.times.ends_with(&[2999.0]));
    assert!(said.remarks[0].contains("1 times messages are lost, the first time after number"), "{:?}", said.remarks);
}

#[test]
fn any_damaged_byte_ends_in_rows_or_an_error() {
    let folder = Folder::new();
    let [path, bad] = ["a.db3", "bad.db3"].map(|name| folder.path(name));
    write(&path, 30, 0, |data| data).close().unwrap();
    let whole = fs::read(&path).unwrap();
    for at in (16..whole.len()).filter(|at| whole[*at] != 0 || at % 97 == 0) {
        let mut bytes = whole.clone();
        bytes[at] = !bytes[at];
        fs::write(&bad, bytes).unwrap();
        if let Ok(said) = read(&bad) {
            assert!(said.times.len() <= 60, "at {at}");
        }
    }
}
