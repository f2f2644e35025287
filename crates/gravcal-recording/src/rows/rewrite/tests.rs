//! Recordings written again: what changes and what stays.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::{Attachment, MessageStream, Summary, Writer};

use super::*;
use crate::rows::joint_state::cdr;
use crate::rows::{Row, open};

fn notes() -> BTreeMap<String, String> {
    BTreeMap::from([("calibrated".to_owned(), "a.json".to_owned())])
}

/// Doubles the column of this name.
fn doubled(name: &'static str) -> impl FnMut(&[String], &mut [f64]) {
    move |columns, cells| {
        let column = columns.iter().position(|column| column == name);
        column.into_iter().for_each(|column| cells[column] *= 2.0);
    }
}

fn again(input: &Path, output: &Path, change: &mut Change<'_>) -> Result<Vec<String>, String> {
    let what = Rewriting { input, output, overwrite: false, csv: &CsvWriting::default(), notes: &notes() };
    rewrite(&what, change, &mut |_| true).map_err(|error| error.to_string())
}

#[test]
fn of_a_csv_file_only_changed_cells_change() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.csv", "out.csv"].map(|name| folder.path().join(name));
    let text = "# load = plate-a\n# by hand; on a Monday\n\nt;tau;\"la;bel\"\n1,50;2,25;x\n# a break\n\n1,60;;\"y;z\"\n1,70;1e1;#\n\n# the end\n";
    fs::write(&input, text).unwrap();
    let remarks = again(&input, &output, &mut doubled("tau")).unwrap();
    let expected = "# calibrated = a.json\n# load = plate-a\n# by hand; on a Monday\n\nt;tau;\"la;bel\"\n1,50;4,5;x\n# a break\n\n1,60;;\"y;z\"\n1,70;20;\"#\"\n\n# the end\n";
    assert_eq!(fs::read_to_string(&output).unwrap(), expected);
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    assert_eq!(fs::read_to_string(&input).unwrap(), text);
}

/// A file with two topics of joint states, another topic, an attachment and metadata.
fn rich(path: &Path) {
    let mut writer = Writer::new(File::create(path).unwrap()).unwrap();
    writer.write_metadata(&Metadata { name: "who".into(), metadata: [("a".into(), "b".into())].into() }).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", b"...").unwrap();
    let other = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data").unwrap();
    let qos = BTreeMap::from([("offered_qos_profiles".to_owned(), "x".to_owned())]);
    let js = writer.add_channel(schema, "/js", "cdr", &qos).unwrap();
    let json = writer.add_channel(schema, "/json", "json", &BTreeMap::new()).unwrap();
    let chatter = writer.add_channel(other, "/chatter", "cdr", &BTreeMap::new()).unwrap();
    for time in 0..10 {
        let header = |channel_id| MessageHeader { channel_id, sequence: time, log_time: time.into(), publish_time: 7 };
        let mut data = Vec::new();
        cdr::write(&mut data, (5, time), &["a", "b"], [&[1.0, 2.0], &[3.0, 4.0], &[f64::from(time), 6.0]]);
        data.extend(b"tail");
        writer.write_to_known_channel(&header(js), &data).unwrap();
        writer.write_to_known_channel(&header(chatter), b"hello").unwrap();
        writer.write_to_known_channel(&header(json), br#"{"name":["c"],"effort":[1.5],"more":[1]}"#).unwrap();
    }
    let attachment = Attachment {
        log_time: 1,
        create_time: 2,
        name: "photo".into(),
        media_type: "image/png".into(),
        data: vec![9_u8; 200_000].into(),
    };
    writer.attach(&attachment).unwrap();
    writer.finish().unwrap();
}

/// Everything in a file, but for what it is to change.
fn contents(path: &Path) -> (Vec<String>, usize, Vec<String>) {
    let bytes = fs::read(path).unwrap();
    let messages = MessageStream::new(&bytes).unwrap().map(|message| {
        let message = message.unwrap();
        let channel = &message.channel;
        format!("{} {:?} {} {} {}", channel.id, channel, message.sequence, message.log_time, message.publish_time)
    });
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let attachment = ::mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).unwrap();
    let metadata = summary.metadata_indexes.iter().map(|index| {
        let Metadata { name, metadata } = ::mcap::read::metadata(&bytes, index).unwrap();
        format!("{name} {metadata:?}")
    });
    (messages.collect(), attachment.data.len() + attachment.name.len(), metadata.collect())
}

#[test]
fn of_an_mcap_file_only_changed_numbers_change() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.mcap", "out.mcap"].map(|name| folder.path().join(name));
    rich(&input);
    let mut both = |columns: &[String], cells: &mut [f64]| {
        doubled("a.effort")(columns, cells);
        doubled("c.effort")(columns, cells);
    };
    assert_eq!(again(&input, &output, &mut both).unwrap(), Vec::<String>::new());
    let (old, new) = (contents(&input), contents(&output));
    assert_eq!((&old.0, old.1), (&new.0, new.1));
    assert_eq!(new.2, ["gravcal {\"calibrated\": \"a.json\"}".to_owned(), old.2[0].clone()]);

    let [old, new] = [&input, &output].map(|path| fs::read(path).unwrap());
    let data = |bytes: &[u8]| -> Vec<Vec<u8>> {
        MessageStream::new(bytes).unwrap().map(|message| message.unwrap().data.into_owned()).collect()
    };
    for (message, (old, new)) in data(&old).iter().zip(&data(&new)).enumerate() {
        let expected = match message % 3 {
            0 => {
                let mut expected = old.clone();
                let at =
                    cdr::Message::read(old).unwrap().place(crate::rows::joint_state::Quantity::Effort, 0).unwrap().0;
                expected[at..at + 8].copy_from_slice(&(2.0 * (message / 3) as f64).to_le_bytes());
                expected
            }
            1 => old.clone(),
            _ => br#"{"effort":[3.0],"more":[1],"name":["c"]}"#.to_vec(),
        };
        assert_eq!(*new, expected, "message {message}");
    }
}

#[test]
fn what_is_read_again_is_what_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.mcap", "out.mcap"].map(|name| folder.path().join(name));
    rich(&input);
    again(&input, &output, &mut doubled("b.position")).unwrap();
    let mut rows = open(&output).unwrap();
    let column = rows.columns().iter().position(|column| column == "b.position").unwrap();
    let (mut row, mut count) = (Row::default(), 0);
    while rows.read(&mut row).unwrap() {
        count += usize::from(row.cells[column] == 4.0);
    }
    assert_eq!((count, rows.metadata()), (10, notes()));
}

#[test]
fn nothing_is_lost_by_what_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output, table] = ["in.mcap", "out.mcap", "in.csv"].map(|name| folder.path().join(name));
    rich(&input);
    fs::write(&table, "q,tau\n1,2\n").unwrap();
    let database = folder.path().join("in.db3");
    fs::write(&database, b"SQLite format 3\0").unwrap();
    let (mut keep, mut count) = (|_: &[String], _: &mut [f64]| {}, 0);
    let old = fs::read(&input).unwrap();
    for (from, to, expected) in [
        (&input, &table, "there is such a file already, and it is not overwritten unless told"),
        (&input, &input, "this is the recording itself"),
        (&input, &folder.path().join("a.csv"), "this is an MCAP file, and becomes one"),
        (&table, &folder.path().join("a.mcap"), "this is a CSV file, and becomes one"),
        (
            &database,
            &folder.path().join("out.db3"),
            "make MCAP of it first, and take that. `mcap convert in.db3 out.mcap`",
        ),
        (&folder.path().to_owned(), &output, "this is a folder; write the files in it again one by one"),
    ] {
        let error = again(from, to, &mut keep).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let rows = "1,2\n".repeat(5000);
    fs::write(&table, format!("q,tau\n{rows}")).unwrap();
    let output = folder.path().join("a.csv");
    let what =
        Rewriting { input: &table, output: &output, overwrite: false, csv: &CsvWriting::default(), notes: &notes() };
    let stopped = rewrite(&what, &mut keep, &mut |progress| {
        count += 1;
        progress < 0.5
    });
    assert!(matches!(stopped, Err(RewriteError::Stopped)) && count > 1);
    assert_eq!((fs::read(&input).unwrap(), fs::read_dir(folder.path()).unwrap().count()), (old, 3));
}

/// The bytes of a file with what `find` stands for found in them and the byte so far after it changed.
fn damage(path: &Path, find: &[u8], after: usize) {
    let mut bytes = fs::read(path).unwrap();
    let at = bytes.windows(find.len()).position(|window| window == find).unwrap() + find.len() + after;
    bytes[at] ^= 0x20;
    fs::write(path, bytes).unwrap();
}

#[test]
fn what_is_damaged_beside_the_messages_is_left_out_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.mcap", "out.mcap"].map(|name| folder.path().join(name));
    let type_and_length = b"image/png".len();
    for (find, after, expected) in [
        (
            &b"photo"[..],
            4 + type_and_length + 8 + 100,
            "is damaged and left out: its check sum is not that of its bytes",
        ),
        (b"photo", 4 + type_and_length + 5, "is damaged and left out: it is shorter than it says"),
        (b"photo", 3, "is damaged and left out: it is shorter than it says"),
        (b"\x03\0\0\0who", 2, "is damaged and left out: it cannot be taken apart"),
    ] {
        rich(&input);
        damage(&input, find, after);
        let remarks = again(&input, &output, &mut doubled("a.effort")).unwrap();
        let what = if find == b"photo" { "the attachment at byte " } else { "the metadata record at byte " };
        assert!(matches!(&remarks[..], [only] if only.starts_with(what) && only.ends_with(expected)), "{remarks:?}");
        let summary = Summary::read(&fs::read(&output).unwrap()).unwrap().unwrap();
        let left = (summary.attachment_indexes.len(), summary.metadata_indexes.len());
        assert_eq!(left, if find == b"photo" { (0, 2) } else { (1, 1) });
        assert_eq!(summary.stats.unwrap().message_count, 30);
        fs::remove_file(&output).unwrap();
    }
}

#[test]
fn an_attachment_whose_check_sum_nobody_computed_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.mcap", "out.mcap"].map(|name| folder.path().join(name));
    rich(&input);
    let mut bytes = fs::read(&input).unwrap();
    let last = bytes.windows(9).position(|window| window == [9; 9]).unwrap() + 200_000;
    bytes[last..last + 4].fill(0);
    fs::write(&input, bytes).unwrap();
    assert_eq!(again(&input, &output, &mut doubled("a.effort")).unwrap(), Vec::<String>::new());
    assert_eq!(contents(&output).1, 200_005);
}

#[test]
fn a_file_that_begins_without_a_header_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.mcap", "out.mcap"].map(|name| folder.path().join(name));
    rich(&input);
    let bytes = fs::read(&input).unwrap();
    let header = 9 + u64::from_le_bytes(bytes[9..17].try_into().unwrap()) as usize;
    fs::write(&input, [&bytes[..8], &bytes[8 + header..]].concat()).unwrap();
    again(&input, &output, &mut doubled("a.effort")).unwrap();
    assert_eq!(contents(&output).2.len(), 2);
}
