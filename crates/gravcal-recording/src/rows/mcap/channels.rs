//! The channels of an MCAP file: which topics hold joint states, and in which encoding.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use mcap::parse_record;
use mcap::records::{Metadata, Record, op};

use super::summary::{LARGEST, Summary};
use crate::rows;
use crate::rows::write::mcap::METADATA;

/// How a message is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Common Data Representation.
    Cdr,
    /// JSON.
    Json,
}

/// The names under which schemas of joint states go.
const JOINT_STATE: [&str; 3] =
    ["sensor_msgs/msg/JointState", "sensor_msgs/JointState", "sensor_msgs::msg::dds_::JointState_"];

/// The channels of the present file, and the topics of all.
#[derive(Default)]
pub(crate) struct Channels {
    /// Of the present file, by identifier: names of schemas, and channels.
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    summary: Option<Summary>,
    /// Names of topics in the order of their first appearance.
    names: Vec<String>,
    topics: Vec<Topic>,
    /// The channel of the last message.
    last: Option<(u16, usize, Encoding)>,
    /// Messages of channels that nothing describes.
    unknown: u64,
}

struct Channel {
    topic: usize,
    encoding: Option<Encoding>,
}

/// What is known of a topic.
#[derive(Default)]
struct Topic {
    kind: String,
    encoding: String,
    messages: u64,
    /// Why messages could not be read, how many of each, and the first.
    malformed: BTreeMap<String, (u64, u64)>,
}

impl Channels {
    /// Those that the summary of a file names, if it has one. Mostly the records before the messages name them too, but not where
    /// these are in a chunk that is lost.
    pub(crate) fn of(path: &Path) -> Channels {
        Channels { summary: Summary::of(path), ..Channels::default() }
    }

    /// Goes on to another file, whose channels are others.
    pub(crate) fn next_file(&mut self, path: &Path) {
        self.schemas.clear();
        self.channels.clear();
        self.last = None;
        self.summary = Summary::of(path);
    }

    /// Names of all topics so far.
    pub(crate) fn topics(&self) -> &[String] {
        &self.names
    }

    /// What is said of the recording in records that the summary points to.
    pub(crate) fn metadata(&self, path: &Path) -> BTreeMap<String, String> {
        let indexes = self.summary.iter().flat_map(|summary| &summary.metadata);
        let mut said = BTreeMap::new();
        for index in indexes.filter(|index| index.name == METADATA && index.length < LARGEST) {
            let mut record = Vec::new();
            let read = File::open(path).and_then(|mut file| {
                file.seek(SeekFrom::Start(index.offset))?;
                file.take(index.length).read_to_end(&mut record)
            });
            if read.is_ok() && record.first() == Some(&op::METADATA) {
                said.extend(said_in(record.get(9..).unwrap_or_default()));
            }
        }
        said
    }

    /// Takes a schema or a channel; other records are passed over, and so are damaged ones.
    pub(crate) fn take(&mut self, opcode: u8, body: &[u8]) {
        if !matches!(opcode, op::SCHEMA | op::CHANNEL) {
            return;
        }
        match parse_record(opcode, body) {
            Ok(Record::Schema { header, .. }) => {
                self.schemas.insert(header.id, header.name);
            }
            Ok(Record::Channel(channel)) => {
                let kind = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                self.add(channel.id, &channel.topic, kind, &channel.message_encoding);
            }
            _ => {}
        }
    }

    fn add(&mut self, id: u16, topic: &str, kind: String, encoding: &str) {
        let read = match encoding {
            "cdr" => Some(Encoding::Cdr),
            "json" => Some(Encoding::Json),
            _ => None,
        };
        let is_joint_state = JOINT_STATE.contains(&kind.as_str());
        let index = self.names.iter().position(|name| name == topic).unwrap_or_else(|| {
            self.names.push(topic.to_owned());
            self.topics.push(Topic::default());
            self.names.len() - 1
        });
        self.topics[index].kind = kind;
        self.topics[index].encoding = encoding.to_owned();
        self.channels.insert(id, Channel { topic: index, encoding: read.filter(|_| is_joint_state) });
        self.last = None;
    }

    /// Counts a message of a channel; its topic and encoding if it is one of joint states that can be read.
    pub(crate) fn count(&mut self, id: u16) -> Option<(usize, Encoding)> {
        if let Some((last, topic, encoding)) = self.last
            && last == id
        {
            self.topics[topic].messages += 1;
            return Some((topic, encoding));
        }
        if !self.channels.contains_key(&id) && !self.add_from_summary(id) {
            self.unknown += 1;
            return None;
        }
        let channel = self.channels.get(&id)?;
        self.topics[channel.topic].messages += 1;
        let encoding = channel.encoding?;
        self.last = Some((id, channel.topic, encoding));
        Some((channel.topic, encoding))
    }

    /// Topic and encoding of a channel of joint states that can be read.
    pub(crate) fn joint_states(&self, id: u16) -> Option<(usize, Encoding)> {
        let channel = self.channels.get(&id)?;
        Some((channel.topic, channel.encoding?))
    }

    /// What the summary says of a channel.
    pub(crate) fn in_summary(&self, id: u16) -> Option<Arc<mcap::Channel<'static>>> {
        self.summary.as_ref()?.channel(id)
    }

    fn add_from_summary(&mut self, id: u16) -> bool {
        let Some(channel) = self.in_summary(id) else { return false };
        let kind = channel.schema.as_ref().map_or_else(String::new, |schema| schema.name.clone());
        self.add(id, &channel.topic, kind, &channel.message_encoding);
        true
    }

    /// Notes a message that could not be read.
    pub(crate) fn malformed(&mut self, topic: usize, what: String, message: u64) {
        self.topics[topic].malformed.entry(what).or_insert((0, message)).0 += 1;
    }

    /// The topics in the order of their first appearance.
    pub(crate) fn found(&self) -> Vec<rows::Topic> {
        let found = self.names.iter().zip(&self.topics).map(|(name, topic)| rows::Topic {
            name: name.clone(),
            kind: topic.kind.clone(),
            encoding: topic.encoding.clone(),
            messages: topic.messages,
        });
        found.collect()
    }

    /// The topics with their types.
    pub(crate) fn described(&self) -> Vec<String> {
        let described = |(name, topic): (&String, &Topic)| match (topic.kind.as_str(), topic.encoding.as_str()) {
            ("", "") => name.clone(),
            ("", encoding) => format!("{name} ({encoding})"),
            (kind, "") => format!("{name} ({kind})"),
            (kind, encoding) => format!("{name} ({kind} in {encoding})"),
        };
        self.names.iter().zip(&self.topics).map(described).collect()
    }

    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let unknown = (self.unknown > 0).then(|| {
            format!("{} messages are left out, because the record that describes their channel is lost", self.unknown)
        });
        let unread = self.names.iter().zip(&self.topics).filter(|(_, topic)| {
            JOINT_STATE.contains(&topic.kind.as_str()) && !["cdr", "json"].contains(&topic.encoding.as_str())
        });
        let unread = unread.map(|(name, topic)| {
            format!("{name}: joint states in the encoding `{}` are not read, only cdr and json", topic.encoding)
        });
        let malformed = self.names.iter().zip(&self.topics).flat_map(|(name, topic)| {
            topic.malformed.iter().map(move |(what, (count, first))| {
                format!("{name}: {count} messages are damaged and left out ({what}), the first is message {first}")
            })
        });
        unknown.into_iter().chain(unread).chain(malformed)
    }
}

/// What a metadata record says of the recording; nothing if it is another.
pub(crate) fn said_in(body: &[u8]) -> BTreeMap<String, String> {
    match parse_record(op::METADATA, body) {
        Ok(Record::Metadata(Metadata { name, metadata })) if name == METADATA => metadata,
        _ => BTreeMap::new(),
    }
}
