//! A recording as messages `sensor_msgs/JointState` in an MCAP file, as rosbag2 writes it: CDR, chunks compressed by zstd.
//!
//! A row is one message on each topic that it says anything of. In a message stand the joints of which the row says anything; where
//! it says nothing of a quantity for any of them the quantity is left out, and for some of them it is NaN.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions};

use super::{Heading, RowWriter, check_cells};
use crate::rows::joint_state::{ColumnName, Quantity, TIME, cdr};
use crate::write::{NewFile, WriteError};

/// Name of the metadata record with what is said of the recording.
pub(crate) const METADATA: &str = "gravcal";
/// Where joints are of no other topic.
const TOPIC: &str = "/joint_states";
/// The type of the messages.
const TYPE: &str = "sensor_msgs/msg/JointState";
const DEFINITION: &str = include_str!("../joint_state/definition.msg");

/// Writes MCAP.
pub(super) struct McapWriter {
    path: PathBuf,
    columns: Vec<String>,
    time: Option<usize>,
    topics: Vec<Topic>,
    file: mcap::Writer<NewFile>,
    rows: usize,
    message: Vec<u8>,
}

/// A topic with its joints.
struct Topic {
    name: String,
    messages: u32,
    channel: u16,
    joints: Vec<Joint>,
}

struct Joint {
    name: String,
    /// Of each quantity.
    columns: [Option<usize>; 3],
}

impl McapWriter {
    pub(super) fn create(path: &Path, heading: &Heading, overwrite: bool) -> Result<McapWriter, WriteError> {
        let (time, mut topics) = places(path, &heading.columns)?;
        let file = NewFile::create(path, overwrite)?;
        let failed = |error| failed(path, error);
        let mut file = options().create(file).map_err(failed)?;
        if !heading.metadata.is_empty() {
            let record = Metadata { name: METADATA.to_owned(), metadata: heading.metadata.clone() };
            file.write_metadata(&record).map_err(failed)?;
        }
        let schema = file.add_schema(TYPE, "ros2msg", DEFINITION.as_bytes()).map_err(failed)?;
        for topic in &mut topics {
            topic.channel = file.add_channel(schema, &topic.name, "cdr", &BTreeMap::new()).map_err(failed)?;
        }
        let (path, columns) = (path.to_owned(), heading.columns.clone());
        Ok(McapWriter { path, columns, time, topics, file, rows: 0, message: Vec::new() })
    }

    /// Time of a row in whole nanoseconds: its stamp, and as one number.
    fn time(&self, cells: &[f64]) -> Result<((i32, u32), u64), WriteError> {
        let found = self.time.map_or(f64::NAN, |column| cells[column]);
        if !(0.0..=f64::from(i32::MAX)).contains(&found) {
            return Err(WriteError::Time { path: self.path.clone(), row: self.rows, found });
        }
        let whole = found.floor();
        let nanoseconds = whole as u64 * 1_000_000_000 + ((found - whole) * 1e9).round() as u64;
        Ok((((nanoseconds / 1_000_000_000) as i32, (nanoseconds % 1_000_000_000) as u32), nanoseconds))
    }
}

impl RowWriter for McapWriter {
    fn write(&mut self, cells: &[f64]) -> Result<(), WriteError> {
        self.rows += 1;
        check_cells(&self.path, &self.columns, self.rows, cells)?;
        let (stamp, time) = self.time(cells)?;
        for topic in &mut self.topics {
            if !topic.message(&mut self.message, stamp, cells) {
                continue;
            }
            let sequence = topic.messages;
            let header = MessageHeader { channel_id: topic.channel, sequence, log_time: time, publish_time: time };
            let written = self.file.write_to_known_channel(&header, &self.message);
            written.map_err(|error| failed(&self.path, error))?;
            topic.messages = topic.messages.wrapping_add(1);
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        let McapWriter { path, mut file, .. } = *self;
        file.finish().map_err(|error| failed(&path, error))?;
        file.into_inner().finish()
    }
}

impl Topic {
    /// Makes the message of a row; false where the row says nothing of the topic.
    fn message(&self, bytes: &mut Vec<u8>, stamp: (i32, u32), cells: &[f64]) -> bool {
        let cell = |column: Option<usize>| column.map_or(f64::NAN, |column| cells[column]);
        let joints: Vec<(&str, [f64; 3])> =
            self.joints.iter().map(|joint| (joint.name.as_str(), joint.columns.map(cell))).collect();
        let said: Vec<&(&str, [f64; 3])> =
            joints.iter().filter(|(_, cells)| cells.iter().any(|cell| !cell.is_nan())).collect();
        let names: Vec<&str> = said.iter().map(|(name, _)| *name).collect();
        let numbers = Quantity::ALL.map(|quantity| -> Vec<f64> {
            let numbers: Vec<f64> = said.iter().map(|(_, cells)| cells[quantity as usize]).collect();
            if numbers.iter().all(|number| number.is_nan()) { Vec::new() } else { numbers }
        });
        cdr::write(bytes, stamp, &names, [&numbers[0], &numbers[1], &numbers[2]]);
        !names.is_empty()
    }
}

/// What each column is: the time, or a number of a joint of a topic.
fn places(path: &Path, columns: &[String]) -> Result<(Option<usize>, Vec<Topic>), WriteError> {
    let mut time = None;
    let mut topics: Vec<Topic> = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        if column == TIME {
            time = Some(index);
            continue;
        }
        let no_place = || WriteError::NoPlace { path: path.to_owned(), column: column.clone() };
        let name = ColumnName::parse(column).ok_or_else(no_place)?;
        let joints = joints_of(&mut topics, name.topic.unwrap_or(TOPIC));
        let joint = match joints.iter().position(|joint| joint.name == name.joint) {
            Some(joint) => joint,
            None => {
                joints.push(Joint { name: name.joint.to_owned(), columns: [None; 3] });
                joints.len() - 1
            }
        };
        joints[joint].columns[name.quantity as usize] = Some(index);
    }
    Ok((time, topics))
}

/// The joints of a topic, which is made where it does not exist.
fn joints_of<'a>(topics: &'a mut Vec<Topic>, name: &str) -> &'a mut Vec<Joint> {
    let index = topics.iter().position(|topic| topic.name == name).unwrap_or_else(|| {
        topics.push(Topic { name: name.to_owned(), messages: 0, channel: 0, joints: Vec::new() });
        topics.len() - 1
    });
    &mut topics[index].joints
}

/// One thread only: with more, the bytes would depend on the machine.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library(concat!("gravcal ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
}

/// The crate's words for what the operating system refuses.
pub(crate) fn failed(path: &Path, error: McapError) -> WriteError {
    let cause = match error {
        McapError::Io(cause) => cause,
        other => std::io::Error::other(other),
    };
    WriteError::Io { path: path.to_owned(), cause }
}
