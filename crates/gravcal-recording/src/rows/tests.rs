//! Recordings written and read back, spread over topics, dirty and damaged.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::mcap::records::MessageHeader;
use ::mcap::{Compression, WriteOptions, Writer};
use proptest::prelude::*;

use super::joint_state::cdr;
use super::*;
use crate::error::ReadError;

/// A message to be written: topic, time of logging in s, joints, and positions; efforts are ten times as much.
type Sent<'a> = (&'a str, f64, &'a [&'a str], &'a [f64]);

/// What a test writes.
struct Bag {
    folder: tempfile::TempDir,
}

impl Bag {
    fn new() -> Bag {
        Bag { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), text).unwrap();
        self.path(name)
    }

    /// Chunks of three messages each.
    fn messages(&self, name: &str, compression: Option<Compression>, sent: &[Sent<'_>]) -> PathBuf {
        let options = WriteOptions::new().compression(compression).compression_threads(0).chunk_size(None);
        let mut writer = options.create(File::create(self.path(name)).unwrap()).unwrap();
        for (index, (topic, time, names, positions)) in sent.iter().enumerate() {
            let efforts: Vec<f64> = positions.iter().map(|position| 10.0 * position).collect();
            let nanoseconds = (time * 1e9) as u64;
            let stamp = ((nanoseconds / 1_000_000_000) as i32, (nanoseconds % 1_000_000_000) as u32);
            let mut data = Vec::new();
            cdr::write(&mut data, stamp, names, [positions, &[], &efforts]);
            send(&mut writer, topic, "sensor_msgs/msg/JointState", "cdr", nanoseconds, &data);
            if index % 3 == 2 {
                writer.flush().unwrap();
            }
        }
        writer.finish().unwrap();
        self.path(name)
    }
}

fn send(writer: &mut Writer<File>, topic: &str, kind: &str, encoding: &str, log_time: u64, data: &[u8]) {
    let schema = writer.add_schema(kind, "ros2msg", b"...").unwrap();
    let channel_id = writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
    let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
    writer.write_to_known_channel(&header, data).unwrap();
}

/// What a file says.
#[derive(Debug)]
struct Said {
    columns: Vec<String>,
    rows: Vec<Row>,
    remarks: Vec<String>,
    metadata: BTreeMap<String, String>,
}

fn notes() -> BTreeMap<String, String> {
    BTreeMap::from([("load".to_owned(), "plate-a".to_owned())])
}

fn read(path: &Path) -> Result<Said, ReadError> {
    said(open(path)?)
}

fn said(mut rows: Box<dyn Rows>) -> Result<Said, ReadError> {
    let mut said = Vec::new();
    let mut row = Row::default();
    let mut before = 0.0;
    while rows.read(&mut row)? {
        assert_eq!(row.cells.len(), rows.columns().len());
        assert!((before..=1.0).contains(&rows.progress()));
        before = rows.progress();
        said.push(row.clone());
    }
    Ok(Said { columns: rows.columns().to_vec(), rows: said, remarks: rows.remarks(), metadata: rows.metadata() })
}

impl Said {
    fn column(&self, name: &str) -> Vec<f64> {
        let index = self.columns.iter().position(|column| column == name).unwrap();
        self.rows.iter().map(|row| row.cells.get(index).copied().unwrap_or(f64::NAN)).collect()
    }
}

/// Numbers with NaN as `None`, so that they can be compared.
fn some(numbers: &[f64]) -> Vec<Option<f64>> {
    numbers.iter().map(|number| (!number.is_nan()).then_some(*number)).collect()
}

#[test]
fn what_is_written_is_read_back_to_the_bit() {
    let bag = Bag::new();
    let metadata = BTreeMap::from([("load".to_owned(), "plate-a".to_owned())]);
    let columns = ["time_s", "a.position", "/wrist:b.position", "a.effort"].map(str::to_owned).to_vec();
    let heading = Heading { columns: columns.clone(), metadata: metadata.clone() };
    let sent: Vec<[f64; 4]> = (0..20_000)
        .map(|row| {
            let row = f64::from(row);
            [row * 0.25, row.sin(), if row > 9.0 { row.cos() } else { f64::NAN }, row / 3.0]
        })
        .collect();
    for name in ["a.csv", "a.parquet", "a.mcap"] {
        let path = bag.path(name);
        let mut writer = create(&path, &heading, false).unwrap();
        sent.iter().for_each(|cells| writer.write(cells).unwrap());
        writer.finish().unwrap();
        let said = read(&path).unwrap();
        assert_eq!((&said.metadata, said.remarks.len()), (&metadata, 0), "{name}");
        // A row of two topics is two messages.
        let rows = if name == "a.mcap" { 40_000 - 10 } else { 20_000 };
        assert_eq!(said.rows.len(), rows, "{name}");
        for (index, column) in columns.iter().enumerate() {
            let name_read = if name == "a.mcap" { column.strip_prefix("/wrist:").unwrap_or(column) } else { column };
            let found: Vec<u64> =
                said.column(name_read).into_iter().filter(|cell| !cell.is_nan()).map(f64::to_bits).collect();
            let expected = sent.iter().flat_map(|cells| {
                let twice = index == 0 && name == "a.mcap" && !cells[2].is_nan();
                std::iter::repeat_n(cells[index], if twice { 2 } else { 1 })
            });
            let expected: Vec<u64> = expected.filter(|cell| !cell.is_nan()).map(f64::to_bits).collect();
            assert_eq!(found, expected, "{name}: {column}");
        }
    }
}

#[test]
fn joints_may_be_reordered_and_spread_over_topics() {
    let bag = Bag::new();
    let sent: [Sent<'_>; 4] = [
        ("/arm", 1.0, &["a", "b"], &[1.0, 2.0]),
        ("/hand", 1.5, &["c"], &[3.0]),
        ("/arm", 2.0, &["b", "a"], &[4.0, 5.0]),
        ("/arm", 3.0, &["b"], &[6.0]),
    ];
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        let said = read(&bag.messages("a.mcap", compression, &sent)).unwrap();
        let expected = ["time_s", "a.position", "b.position", "a.effort", "b.effort", "c.position", "c.effort"];
        assert_eq!(said.columns, expected);
        assert_eq!(said.column("time_s"), [1.0, 1.5, 2.0, 3.0]);
        assert_eq!(some(&said.column("a.position")), [Some(1.0), None, Some(5.0), None]);
        assert_eq!(some(&said.column("b.effort")), [Some(20.0), None, Some(40.0), Some(60.0)]);
        assert_eq!(some(&said.column("c.position")), [None, Some(3.0), None, None]);
        assert_eq!(said.rows.iter().map(|row| row.number).collect::<Vec<_>>(), [1, 2, 3, 4]);
    }
}

#[test]
fn a_joint_of_two_topics_has_columns_of_both() {
    let bag = Bag::new();
    let sent: [Sent<'_>; 2] = [("/a", 1.0, &["j", "k"], &[1.0, 2.0]), ("/b", 2.0, &["j"], &[3.0])];
    let said = read(&bag.messages("a.mcap", None, &sent)).unwrap();
    assert_eq!(said.columns[1..4], ["/a:j.position", "k.position", "/a:j.effort"]);
    assert_eq!(some(&said.column("/b:j.position")), [None, Some(3.0)]);
}

#[test]
fn joints_may_appear_midway() {
    let bag = Bag::new();
    let mut sent: Vec<Sent<'_>> = (0..10_500).map(|row| ("/a", f64::from(row), &["j"][..], &[1.0][..])).collect();
    sent.push(("/a", 20_000.0, &["j", "late"], &[2.0, 3.0]));
    sent.push(("/b", 20_001.0, &["j"], &[4.0]));
    let path = bag.messages("a.mcap", Some(Compression::Zstd), &sent);
    let rows = open(&path).unwrap();
    assert_eq!(rows.columns(), ["time_s", "j.position", "j.effort"]);
    let said = said(rows).unwrap();
    assert_eq!(said.columns[3..], ["late.position", "late.effort", "/b:j.position", "/b:j.effort"]);
    assert_eq!(said.rows[10_500].cells[..5], [20_000.0, 2.0, 20.0, 3.0, 30.0]);
    assert_eq!(said.rows[10_501].cells[5..], [4.0, 40.0]);
    assert_eq!(said.remarks.len(), 2, "{:?}", said.remarks);
    assert!(said.remarks[0].starts_with("/b speaks of joint `j` too, long after /a: its column is `/b:j.position`"));
}

#[test]
fn json_is_read_like_cdr() {
    let bag = Bag::new();
    let path = bag.path("a.mcap");
    let mut writer = Writer::new(File::create(&path).unwrap()).unwrap();
    let good = br#"{"header":{"stamp":{"sec":7,"nanosec":500000000},"frame_id":"x"},"name":["a","b"],
                    "position":[1.5,null],"velocity":[],"effort":[3,4]}"#;
    for data in [&good[..], b"{", br#"{"name":["a"],"position":[1.0,2.0]}"#, br#"{"name":["a"],"position":[2.0]}"#] {
        send(&mut writer, "/js", "sensor_msgs/msg/JointState", "json", 9_000_000_000, data);
    }
    send(&mut writer, "/other", "std_msgs/msg/String", "cdr", 9, b"");
    writer.finish().unwrap();
    let said = read(&path).unwrap();
    assert_eq!(said.columns, ["time_s", "a.position", "b.position", "a.effort", "b.effort"]);
    assert_eq!(some(&said.rows[0].cells), [Some(7.5), Some(1.5), None, Some(3.0), Some(4.0)]);
    assert_eq!(some(&said.rows[1].cells), [Some(9.0), Some(2.0), None, None, None]);
    let expected = [
        "/js: 1 of 4 messages are damaged and left out (no such message in JSON), the first is message 2",
        "/js: 1 of 4 messages are damaged and left out (not as many numbers of position as names), the first is message 3",
        "readings that are no finite numbers count as missing: 1 of `b.position`",
    ];
    assert_eq!(said.remarks, expected);
}

#[test]
fn a_bag_without_joint_states_tells_its_topics() {
    let bag = Bag::new();
    let path = bag.path("a.mcap");
    let mut writer = Writer::new(File::create(&path).unwrap()).unwrap();
    send(&mut writer, "/scan", "sensor_msgs/msg/LaserScan", "cdr", 1, b"abc");
    send(&mut writer, "/js", "sensor_msgs/msg/JointState", "ros1", 2, b"abc");
    writer.finish().unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "it has no messages of joint states (sensor_msgs/JointState) that can be read; its topics are /scan \
             (sensor_msgs/msg/LaserScan in cdr), /js (sensor_msgs/msg/JointState in ros1); /js: joint states in the \
             encoding `ros1` are not read, only cdr and json"
        ),
        "{error}"
    );
}

#[test]
fn the_files_of_a_folder_are_read_in_the_order_of_their_times() {
    let bag = Bag::new();
    let folder = bag.path("bag");
    fs::create_dir(&folder).unwrap();
    let later = bag.messages("bag/a_0.mcap", None, &[("/js", 5.0, &["a"], &[2.0])]);
    bag.messages("bag/a_1.mcap", Some(Compression::Zstd), &[("/js", 1.0, &["a"], &[1.0])]);
    let said = read(&folder).unwrap();
    assert_eq!((said.column("time_s"), said.column("a.position")), (vec![1.0, 5.0], vec![1.0, 2.0]));
    fs::write(folder.join("metadata.yaml"), "files:\n  relative_file_paths:\n    - a_0.mcap\n    - \"a_2.mcap\"\n")
        .unwrap();
    let said = read(&folder).unwrap();
    let left_out = "metadata.yaml does not list a_1.mcap, which is left out: list it there, or give it by itself";
    assert_eq!(said.remarks, ["metadata.yaml names a_2.mcap, which is not there", left_out]);
    assert_eq!(said.column("a.position"), [2.0]);
    assert_eq!(open(&folder).unwrap().lost(), said.remarks);
    let text = "files:\n  - path: a_0.mcap\n    message_count: 1\nrelative_file_paths:\n  - a_0.mcap\n  - a_1.mcap\n";
    fs::write(folder.join("metadata.yaml"), text).unwrap();
    assert_eq!(read(&folder).unwrap().remarks, [""; 0]);
    fs::remove_file(folder.join("metadata.yaml")).unwrap();
    let empty = folder.join("a_3.mcap");
    fs::write(&empty, "").unwrap();
    let said = read(&folder).unwrap();
    assert_eq!(
        (said.column("a.position"), said.remarks),
        (vec![1.0, 2.0], vec!["a_3.mcap is empty and left out".to_owned()])
    );
    fs::remove_file(empty).unwrap();
    for file in [later, folder.join("a_1.mcap")] {
        fs::remove_file(file).unwrap();
    }
    assert!(read(&folder).unwrap_err().to_string().contains("no .mcap file and no .db3 file"));
}

#[test]
fn readings_that_are_no_finite_numbers_are_missing_and_counted() {
    let bag = Bag::new();
    let sent: [Sent<'_>; 3] =
        [("/a", 1.0, &["j"], &[f64::NAN]), ("/a", 2.0, &["j"], &[f64::INFINITY]), ("/a", 2.0, &["j"], &[1.0])];
    let said = read(&bag.messages("a.mcap", None, &sent)).unwrap();
    assert_eq!(some(&said.column("j.position")), [None, None, Some(1.0)]);
    assert_eq!(
        said.remarks[0],
        "readings that are no finite numbers count as missing: 2 of `j.position`, 2 of `j.effort`"
    );
    let said = read(&bag.text("a.csv", "q,tau\n1,2\n-inf,nan\n3,x\n")).unwrap();
    assert_eq!(some(&said.column("q")), [Some(1.0), None, Some(3.0)]);
    let reported = "cells that are no finite numbers count as missing: 1 of `q`, 2 of `tau`; the first is on line 3";
    assert_eq!(said.remarks, [reported], "once for all columns");
}

/// Nine messages in three chunks, of a file with a summary.
fn nine(bag: &Bag, compression: Option<Compression>) -> PathBuf {
    let positions: Vec<[f64; 1]> = (0..9).map(|row| [f64::from(row)]).collect();
    let sent: Vec<Sent<'_>> =
        positions.iter().enumerate().map(|(row, position)| ("/js", row as f64, &["j"][..], &position[..])).collect();
    bag.messages("nine.mcap", compression, &sent)
}

#[test]
fn of_a_file_that_is_cut_all_whole_messages_are_read_and_the_loss_is_said() {
    let bag = Bag::new();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        let whole = fs::read(nine(&bag, compression)).unwrap();
        let mut most = 0;
        for cut in 8..whole.len() {
            let path = bag.text("cut.mcap", &whole[..cut]);
            let said = match read(&path) {
                Ok(said) => said,
                Err(ReadError::NoJointStates { .. }) if most == 0 => continue,
                Err(error) => panic!("cut at {cut}: {error}"),
            };
            let positions: Vec<f64> = (0..said.rows.len()).map(|row| row as f64).collect();
            assert_eq!(said.column("j.position"), positions, "cut at {cut}");
            assert!(said.rows.len() >= most, "cut at {cut}");
            most = said.rows.len();
            // Once the data section has ended, nothing that is read is missing.
            let lost = said.remarks.iter().any(|remark| remark.starts_with("the file is cut"));
            assert!(lost || said.rows.len() == 9, "cut at {cut}: {:?}", said.remarks);
        }
        assert_eq!(most, 9);
    }
}

#[test]
fn the_messages_of_an_uncompressed_chunk_are_read_one_by_one_up_to_the_cut() {
    let bag = Bag::new();
    let whole = fs::read(nine(&bag, None)).unwrap();
    let mut counts: Vec<usize> = (8..whole.len())
        .filter_map(|cut| read(&bag.text("cut.mcap", &whole[..cut])).ok())
        .map(|said| said.rows.len())
        .collect();
    counts.dedup();
    assert_eq!(counts, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
}

#[test]
fn a_damaged_chunk_is_lost_and_said_and_the_others_are_read() {
    let bag = Bag::new();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        let whole = fs::read(nine(&bag, compression)).unwrap();
        let summary = ::mcap::Summary::read(&whole).unwrap().unwrap();
        let mut losses = 0;
        for (lost, chunk) in summary.chunk_indexes.iter().enumerate() {
            let start = chunk.compressed_data_offset().unwrap() as usize;
            for at in start..start + chunk.compressed_size as usize {
                let mut bytes = whole.clone();
                bytes[at] ^= 0x40;
                let said = read(&bag.text("bad.mcap", &bytes)).unwrap();
                let is_lost = said.rows.len() < 9;
                let expected: Vec<f64> =
                    (0..9).filter(|row| !is_lost || row / 3 != lost).map(|row| row as f64).collect();
                assert_eq!(said.column("j.position"), expected);
                let times = format!("with the messages from {}.000 s to {}.000 s is damaged", 3 * lost, 3 * lost + 2);
                assert_eq!(said.remarks.iter().filter(|remark| remark.contains(&times)).count(), usize::from(is_lost));
                losses += usize::from(is_lost);
                // A compressor has bits that say nothing.
                assert!(is_lost || compression.is_some(), "at {at}");
            }
        }
        assert!(losses > 100);
    }
}

#[test]
fn a_bag_of_damaged_chunks_says_so() {
    let bag = Bag::new();
    let mut bytes = fs::read(nine(&bag, None)).unwrap();
    for chunk in ::mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes {
        bytes[chunk.compressed_data_offset().unwrap() as usize] ^= 0x40;
    }
    let error = read(&bag.text("bad.mcap", bytes)).unwrap_err().to_string();
    let expected = "; of it is lost: the chunk at byte";
    assert!(error.contains(expected) && error.ends_with("; and 2 more parts"), "{error}");
}

#[test]
fn records_that_announce_more_than_there_is_are_lost_and_said() {
    let bag = Bag::new();
    let path = bag.path("a.mcap");
    let mut writer = WriteOptions::new().use_chunks(false).create(File::create(&path).unwrap()).unwrap();
    let mut data = Vec::new();
    cdr::write(&mut data, (1, 0), &["j"], [&[1.0], &[], &[]]);
    send(&mut writer, "/js", "sensor_msgs/JointState", "cdr", 1, &data);
    send(&mut writer, "/other", "std_msgs/String", "cdr", 1, b"");
    let metadata = ::mcap::records::Metadata { name: "who".into(), metadata: BTreeMap::new() };
    writer.write_metadata(&metadata).unwrap();
    writer.finish().unwrap();
    let whole = fs::read(&path).unwrap();
    for (find, what) in [
        ("std_msgs/String", "the schema at byte"),
        ("/other", "the description of a channel at byte"),
        ("who", "the metadata record at byte"),
    ] {
        let mut bytes = whole.clone();
        let at = bytes.windows(find.len()).position(|window| window == find.as_bytes()).unwrap();
        bytes[at - 4..at].fill(0xFF);
        let said = read(&bag.text("bad.mcap", bytes)).unwrap();
        assert_eq!(said.column("j.position"), [1.0]);
        assert!(said.remarks[0].starts_with(what), "{:?}", said.remarks);
    }
}

#[test]
fn more_columns_than_any_recording_has_are_refused() {
    let bag = Bag::new();
    let names: Vec<String> = (0..4097).map(|joint| format!("j{joint}")).collect();
    let row = vec!["0"; names.len()].join(",");
    let expected = "it has 4097 columns, and no more than 4096 are read";
    for text in [format!("{}\n{row}\n", names.join(",")), format!("{row}\n{row}\n")] {
        let path = bag.text("a.csv", text);
        for error in [read(&path).unwrap_err(), crate::Table::read(&path).unwrap_err()] {
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
    let names: Vec<&str> = names[..1366].iter().map(String::as_str).collect();
    let most = [0.0; 1366];
    let few = bag.messages("few.mcap", None, &[("/js", 1.0, &names[..1365], &most[..1365])]);
    assert_eq!(read(&few).unwrap().columns.len(), 1 + 2 * 1365);
    let error = read(&bag.messages("many.mcap", None, &[("/js", 1.0, &names, &most)])).unwrap_err().to_string();
    assert!(error.contains("a message of /js names 1366 joints, and no more than 1365 are read"), "{error}");
}

/// Which of its numbers holds, nobody can tell.
#[test]
fn a_message_that_names_a_joint_twice_is_damaged() {
    let bag = Bag::new();
    let sent: [Sent<'_>; 3] = [
        ("/js", 1.0, &["a", "b"], &[1.0, 2.0]),
        ("/js", 2.0, &["a", "b", "a"], &[3.0, 4.0, 5.0]),
        ("/js", 3.0, &["b", "a"], &[6.0, 7.0]),
    ];
    let path = bag.messages("a.mcap", None, &sent);
    let said = read(&path).unwrap();
    assert_eq!(said.column("a.position"), [1.0, 7.0]);
    let remark = "/js: 1 of 3 messages are damaged and left out (it names joint `a` twice), the first is message 2";
    assert_eq!(said.remarks, [remark]);
    let mut rows = open(&path).unwrap();
    while rows.read(&mut Row::default()).unwrap() {}
    assert_eq!(rows.lost(), [remark]);
}

#[test]
fn nodes_that_take_turns_on_a_topic_have_their_columns() {
    let bag = Bag::new();
    let turns: [Sent<'_>; 2] = [("/js", 1.0, &["a", "b"], &[1.0, 2.0]), ("/js", 2.0, &["c", "a"], &[3.0, 4.0])];
    let sent: Vec<Sent<'_>> = turns.into_iter().cycle().take(6).collect();
    let said = read(&bag.messages("a.mcap", None, &sent)).unwrap();
    assert_eq!(said.columns, ["time_s", "a.position", "b.position", "a.effort", "b.effort", "c.position", "c.effort"]);
    assert_eq!(said.column("a.position"), [1.0, 4.0].repeat(3));
    assert_eq!(some(&said.column("c.position")), [None, Some(3.0)].repeat(3));
}

#[test]
fn any_damaged_byte_of_a_parquet_file_ends_in_rows_or_an_error() {
    let bag = Bag::new();
    let path = bag.path("a.parquet");
    let heading = Heading { columns: vec!["time_s".into(), "q".into()], metadata: notes() };
    let mut writer = create(&path, &heading, false).unwrap();
    (0..50).for_each(|row| writer.write(&[f64::from(row), f64::from(row % 3)]).unwrap());
    writer.finish().unwrap();
    let whole = fs::read(&path).unwrap();
    let mut refused = 0;
    for at in 0..whole.len() {
        for change in [0xFF, 0x01, 0x80, 0x10] {
            let mut bytes = whole.clone();
            bytes[at] ^= change;
            // Of what cannot be read the error says that it is damaged; other first bytes are of another kind.
            if let Err(error) = read(&bag.text("bad.parquet", bytes))
                && at >= 4
            {
                assert!(error.to_string().contains("bad.parquet: "), "{error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 100);
}

/// Found by fuzzing: the reader of the `mcap` crate counts on records not going on over the end of theirs.
#[test]
fn a_chunk_that_is_longer_than_its_records_is_lost() {
    let bag = Bag::new();
    let mut bytes = fs::read(nine(&bag, None)).unwrap();
    let first = &::mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes[0];
    let at = first.chunk_start_offset as usize + 9 + 32;
    assert_eq!(bytes[at..at + 8], first.compressed_size.to_le_bytes());
    bytes[at..at + 8].copy_from_slice(&(first.compressed_size - 1).to_le_bytes());
    let said = read(&bag.text("bad.mcap", &bytes)).unwrap();
    assert_eq!(said.column("j.position"), [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert!(
        said.remarks[0].ends_with("is damaged and left out: Chunk ended in the middle of a record"),
        "{:?}",
        said.remarks
    );
}

#[test]
fn any_damaged_byte_ends_in_rows_or_an_error() {
    let bag = Bag::new();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        let whole = fs::read(nine(&bag, compression)).unwrap();
        for at in 8..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] = !bytes[at];
            if let Ok(said) = read(&bag.text("bad.mcap", &bytes)) {
                assert!(said.rows.len() <= 9, "at {at}");
            }
        }
    }
}

#[test]
fn a_file_without_summary_is_read_in_full() {
    let bag = Bag::new();
    let path = bag.path("bare.mcap");
    let options = WriteOptions::new().use_chunks(false).emit_summary_records(false).emit_summary_offsets(false);
    let mut writer = options.create(File::create(&path).unwrap()).unwrap();
    let mut data = Vec::new();
    cdr::write(&mut data, (0, 0), &["j"], [&[1.0], &[], &[]]);
    (1..4).for_each(|time| send(&mut writer, "/js", "sensor_msgs/JointState", "cdr", time * 1_000_000_000, &data));
    writer.finish().unwrap();
    let said = read(&path).unwrap();
    assert_eq!((said.column("time_s"), said.remarks.len()), (vec![1.0, 2.0, 3.0], 0));
    assert_eq!(said.columns, ["time_s", "j.position"]);
}

#[test]
fn a_csv_file_tells_how_it_is_written() {
    let bag = Bag::new();
    let expected = [vec![0.5, -1.25], vec![1e-3, 7.0]];
    for (text, columns) in [
        ("q,tau\n0.5,-1.25\n0.001,7\n", ["q", "tau"]),
        ("\u{feff}# load = plate-a\r\n\r\nq;tau\r\n0,5;-1,25\r\n1e-3;7\r\n", ["q", "tau"]),
        ("q\ttau\n0.5\t-1.25\n\"1e-3\"\t7", ["q", "tau"]),
        ("0,5\t-1,25\n0,001\t7", ["column1", "column2"]),
        ("0.5,-1.25\n# why not\n0.001,7", ["column1", "column2"]),
        ("\"q\";\"tau\"\n0.5;-1.25\n0.001;7\n", ["q", "tau"]),
    ] {
        let said = read(&bag.text("a.csv", text)).unwrap();
        assert_eq!(said.columns, columns, "{text}");
        assert_eq!(said.rows.iter().map(|row| row.cells.clone()).collect::<Vec<_>>(), expected, "{text}");
        assert_eq!(said.metadata.get("load").map(String::as_str), text.contains("load").then_some("plate-a"));
    }
}

/// A robot that rests first says nothing of how its numbers are written.
#[test]
fn a_comma_that_comes_late_is_one_of_decimals() {
    let bag = Bag::new();
    let rest = "0;0;0\n".repeat(50);
    let read_text = |rows: &str| read(&bag.text("a.csv", format!("t;q;y\n{rest}{rows}"))).unwrap();
    let said = read_text("1;0,5;-1,25\n2;1;-2\n");
    assert_eq!((&said.column("q")[50..], &said.column("y")[50..]), (&[0.5, 1.0][..], &[-1.25, -2.0][..]));
    assert!(said.remarks.is_empty(), "{:?}", said.remarks);
    // A comma before three digits may stand between thousands.
    let said = read_text("1;1,000;1\n2;1,001;2\n");
    assert_eq!(some(&said.column("q")[50..]), [None, None]);
    // Where a point came before, it is no number.
    let said = read_text("1;0.5;1\n2;0,5;2\n");
    assert_eq!(some(&said.column("q")[50..]), [Some(0.5), None]);
}

/// As numpy's `savetxt` writes it. A comment that is none of names stays a comment, and who says that there is no header means that.
#[test]
fn a_comment_with_a_name_for_each_cell_is_the_header() {
    let bag = Bag::new();
    let columns = |text: &str| read(&bag.text("a.csv", text)).unwrap().columns;
    assert_eq!(columns("# made by hand\n# time_s,q, tau\n0,1,2\n"), ["time_s", "q", "tau"]);
    for text in
        ["# q,tau\n0,1,2\n", "# q,q,tau\n0,1,2\n", "# 1,q,tau\n0,1,2\n", "# a,b,c\n\n0,1,2\n", "# q, ,tau\n0,1,2\n"]
    {
        assert_eq!(columns(text), ["column1", "column2", "column3"], "{text}");
    }
    assert_eq!(columns("# a,b\nq,tau\n1,2\n"), ["q", "tau"]);
    let path = bag.text("a.csv", "# time_s,q,tau\n0,1,2\n");
    let said = crate::CsvWriting { header: Some(false), ..Default::default() };
    assert_eq!(open_as(&path, &said).unwrap().columns()[0], "column1");
    let found = inspect(&path, &|_| {}).unwrap();
    assert!(found.to_string().contains("header in a comment"), "{found}");
    assert_eq!(crate::Table::read(&path).unwrap().columns(), ["time_s", "q", "tau"]);
}

/// As messages of ROS have it.
#[test]
fn seconds_and_nanoseconds_in_two_columns_are_one_clock() {
    let bag = Bag::new();
    let path = bag.text("a.csv", "sec,nanosec,q\n1764144000,990000000,1\n1764144001,0,2\n1764144001,10000000,3\n");
    let said = read(&path).unwrap();
    assert_eq!(said.columns, ["sec", "nanosec", "q", "time_s"]);
    assert!(said.column("time_s").windows(2).all(|pair| (pair[1] - pair[0] - 0.01).abs() < 1e-6), "{:?}", said.rows);
    let time = inspect(&path, &|_| {}).unwrap().time.unwrap();
    assert!(time.column == "time_s" && (time.interval_s - 0.01).abs() < 1e-6, "{time:?}");
    assert_eq!(inspect(&path, &|_| {}).unwrap().columns.len(), 1, "seconds and nanoseconds are the clock");
    let table = crate::Table::read(&path).unwrap();
    assert_eq!(table.number(1, table.column("time_s").unwrap()).unwrap(), Some(1_764_144_001.0));
}

/// A Parquet file with these columns.
fn parquet(
    bag: &Bag,
    columns: Vec<(&str, arrow_array::ArrayRef)>,
    compression: ::parquet::basic::Compression,
) -> PathBuf {
    let batch = arrow_array::RecordBatch::try_from_iter(columns).unwrap();
    let properties = ::parquet::file::properties::WriterProperties::builder().set_compression(compression).build();
    let file = File::create(bag.path("a.parquet")).unwrap();
    let mut writer = ::parquet::arrow::ArrowWriter::try_new(file, batch.schema(), Some(properties)).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    bag.path("a.parquet")
}

#[test]
fn texts_of_dates_in_parquet_are_seconds_and_gzip_is_read() {
    use arrow_array::{ArrayRef, Float64Array, StringArray};
    let bag = Bag::new();
    let times = [Some("2024-05-01T12:00:00Z"), Some("2024-05-01T12:00:00.010Z"), Some("soon"), None];
    let times: ArrayRef = Arc::new(StringArray::from(times.to_vec()));
    let label: ArrayRef = Arc::new(StringArray::from(vec!["a", "b", "c", "d"]));
    let q: ArrayRef = Arc::new(Float64Array::from(vec![1.0, 2.0, 3.0, 4.0]));
    let columns = vec![("q1", q), ("label", label), ("when", times)];
    let path = parquet(&bag, columns, ::parquet::basic::Compression::GZIP(Default::default()));
    let found = inspect(&path, &|_| {}).unwrap();
    let time = found.time.unwrap();
    assert_eq!((time.column.as_str(), time.unit, time.from_s, time.missing), ("when", "ISO 8601", 1_714_564_800.0, 2));
    assert!((time.interval_s - 0.01).abs() < 1e-6);
    let expected = [
        "column `label` is left out: it holds no numbers",
        "cells that are no dates with times (ISO 8601) count as missing: 1 of `when`",
    ];
    assert_eq!(found.remarks, expected);
}

#[test]
fn seconds_and_nanoseconds_of_parquet_are_one_clock() {
    use arrow_array::{ArrayRef, Float64Array, Int32Array, UInt32Array};
    let bag = Bag::new();
    let seconds: ArrayRef = Arc::new(Int32Array::from(vec![10, 11]));
    let nanoseconds: ArrayRef = Arc::new(UInt32Array::from(vec![500_000_000, 0]));
    let q: ArrayRef = Arc::new(Float64Array::from(vec![1.0, 2.0]));
    let columns = vec![("stamp.sec", seconds), ("stamp.nanosec", nanoseconds), ("q1", q)];
    let said = read(&parquet(&bag, columns, ::parquet::basic::Compression::UNCOMPRESSED)).unwrap();
    assert_eq!(said.column("time_s"), [10.5, 11.0]);
}

/// Whatever the name of the column.
#[test]
fn times_of_parquet_are_seconds() {
    use arrow_array::{ArrayRef, Float64Array, RecordBatch, TimestampNanosecondArray};
    let bag = Bag::new();
    let times: ArrayRef =
        Arc::new(TimestampNanosecondArray::from(vec![1_714_564_800_000_000_000, 1_714_564_800_010_000_000]));
    let q: ArrayRef = Arc::new(Float64Array::from(vec![1.0, 2.0]));
    let batch = RecordBatch::try_from_iter([("stamp_ns", times), ("q1", q)]).unwrap();
    let file = File::create(bag.path("a.parquet")).unwrap();
    let mut writer = ::parquet::arrow::ArrowWriter::try_new(file, batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    let time = inspect(&bag.path("a.parquet"), &|_| {}).unwrap().time.unwrap();
    assert_eq!((time.unit, time.from_s), ("ISO 8601", 1_714_564_800.0));
    assert!((time.interval_s - 0.01).abs() < 1e-6);
}

#[test]
fn numbers_of_every_type_in_parquet_are_read() {
    use arrow_array::types::{ArrowPrimitiveType, Decimal256Type, Float16Type};
    use arrow_array::{
        ArrayRef, BooleanArray, Decimal128Array, Decimal256Array, DurationMillisecondArray, Float16Array, Float32Array,
        Int8Array, Int64Array, RecordBatch, TimestampMicrosecondArray, TimestampSecondArray, UInt16Array, UInt64Array,
    };
    type Half = <Float16Type as ArrowPrimitiveType>::Native;
    type Wide = <Decimal256Type as ArrowPrimitiveType>::Native;
    let decimals = Decimal128Array::from(vec![Some(-12_345), None]).with_precision_and_scale(30, 3).unwrap();
    let wide = Decimal256Array::from(vec![Some(Wide::from_i128(-25)), None]).with_precision_and_scale(60, 1).unwrap();
    let columns: [(&str, ArrayRef, f64); 13] = [
        ("boolean", Arc::new(BooleanArray::from(vec![Some(true), None])), 1.0),
        ("int8", Arc::new(Int8Array::from(vec![Some(-128), None])), -128.0),
        ("int64", Arc::new(Int64Array::from(vec![Some(-(1 << 53)), None])), -9_007_199_254_740_992.0),
        ("uint16", Arc::new(UInt16Array::from(vec![Some(65_535), None])), 65_535.0),
        ("uint64", Arc::new(UInt64Array::from(vec![Some(1 << 63), None])), 9_223_372_036_854_775_808.0),
        ("float16", Arc::new(Float16Array::from(vec![Some(Half::from_f32(1.5)), None])), 1.5),
        ("float32", Arc::new(Float32Array::from(vec![Some(0.1), None])), f64::from(0.1f32)),
        ("decimal128", Arc::new(decimals), -12.345),
        ("decimal256", Arc::new(wide), -2.5),
        ("seconds", Arc::new(TimestampSecondArray::from(vec![Some(1_714_564_800), None])), 1_714_564_800.0),
        ("microseconds", Arc::new(TimestampMicrosecondArray::from(vec![Some(1_500_000), None])), 1.5),
        ("in UTC", Arc::new(TimestampMicrosecondArray::from(vec![Some(-500_000), None]).with_timezone("UTC")), -0.5),
        ("duration", Arc::new(DurationMillisecondArray::from(vec![Some(250), None])), 0.25),
    ];
    let bag = Bag::new();
    let batch = RecordBatch::try_from_iter(columns.iter().map(|(name, column, _)| (*name, column.clone()))).unwrap();
    let file = File::create(bag.path("a.parquet")).unwrap();
    let mut writer = ::parquet::arrow::ArrowWriter::try_new(file, batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();

    let said = read(&bag.path("a.parquet")).unwrap();
    assert_eq!(said.columns, columns.each_ref().map(|(name, ..)| *name));
    assert_eq!(said.rows[0].cells, columns.each_ref().map(|(.., number)| *number));
    assert!(said.rows[1].cells.iter().all(|cell| cell.is_nan()), "{:?}", said.rows[1]);
}

#[test]
fn lines_that_are_no_rows_are_left_out_and_said() {
    let bag = Bag::new();
    let said = read(&bag.text("a.csv", b"q,tau\n1,2\n1\n3,\xe4\n3,\"4\n5,6\n7,8,9\n5,")).unwrap();
    assert_eq!(said.rows.iter().map(|row| row.number).collect::<Vec<_>>(), [2, 6, 8]);
    let path = bag.path("a.csv");
    let expected = [
        "line 5 is left out (a quote is not closed)",
        "2 lines are left out (more or fewer cells than columns), the first is line 3",
        "line 4 is left out (no UTF-8 text)",
    ];
    assert_eq!(said.remarks, expected.map(|remark| format!("{}: {remark}", path.display())));
}

#[test]
fn what_is_no_recording_is_distinguished() {
    let bag = Bag::new();
    for (bytes, expected) in [
        (&b"SQLite format 3\0..."[..], "this SQLite file cannot be read"),
        (b"#ROSBAG V2.0\n", "a bag of ROS 1: `rosbags-convert` makes MCAP of it"),
        (b"\x28\xb5\x2f\xfd", "compressed: unpack it (unzstd) first"),
        (b"\x1f\x8b\x08", "compressed"),
        (b"\x89MCAP1\r\n", "it does not begin as an MCAP file does"),
        (b"PAR1....", "this Parquet file cannot be read, it seems to be damaged"),
        (b"", "the file is empty"),
        (b"q,tau\n", "the file has a header but no rows"),
        (b"q,tau,load\n1,2\n3,4,5,6\n7,\"8\n", "2: expected 3 cells, as in the header, found 2"),
    ] {
        let error = read(&bag.text("a", bytes)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let long = vec![b'1'; 2_000_000];
    assert!(matches!(read(&bag.text("a", long)), Err(ReadError::LongLine { line: 1, .. })));
    assert!(matches!(read(&bag.path("absent")), Err(ReadError::NoFile { .. })));
}

proptest! {
    #[test]
    fn arbitrary_text_does_not_panic(text in "[q1,;\t\"#\n\r \u{feff}é.e-]{0,80}") {
        let bag = Bag::new();
        let _ = read(&bag.text("a.csv", text));
    }
}
