//! The channels of an MCAP file: which of them hold joint states, and in which encoding.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use mcap::records::{Metadata, Record, op};

use super::parsed::parsed;
use super::summary::{LARGEST, Summary};
use crate::file::opened;
use crate::rows::messages::{Encoding, Topics};
use crate::rows::write::mcap::METADATA;

/// The channels of the present file.
#[derive(Default)]
pub(crate) struct Channels {
    /// By identifier: names of schemas, and channels.
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    summary: Option<Summary>,
    /// The channel of the last message.
    last: Option<(u16, usize, Encoding)>,
    /// Messages of channels that nothing describes.
    unknown: u64,
}

struct Channel {
    topic: usize,
    encoding: Option<Encoding>,
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

    /// What is said of the recording in records that the summary points to.
    pub(crate) fn metadata(&self, path: &Path) -> BTreeMap<String, String> {
        let indexes = self.summary.iter().flat_map(|summary| &summary.metadata);
        let mut said = BTreeMap::new();
        for index in indexes.filter(|index| index.name == METADATA && index.length < LARGEST) {
            let mut record = Vec::new();
            let read = opened(path).and_then(|mut file| {
                file.seek(SeekFrom::Start(index.offset))?;
                file.take(index.length).read_to_end(&mut record)
            });
            if read.is_ok() && record.first() == Some(&op::METADATA) {
                said.extend(said_in(record.get(9..).unwrap_or_default()).unwrap_or_default());
            }
        }
        said
    }

    /// Takes a schema or a channel; false where it is damaged.
    pub(crate) fn take(&mut self, opcode: u8, body: &[u8], topics: &mut Topics) -> bool {
        match parsed(opcode, body) {
            Some(Record::Schema { header, .. }) => {
                self.schemas.insert(header.id, header.name);
            }
            Some(Record::Channel(channel)) => {
                let kind = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                self.add(channel.id, topics.add(&channel.topic, kind, &channel.message_encoding));
            }
            _ => return false,
        }
        true
    }

    fn add(&mut self, id: u16, (topic, encoding): (usize, Option<Encoding>)) {
        self.channels.insert(id, Channel { topic, encoding });
        self.last = None;
    }

    /// Counts a message of a channel; its topic and encoding if it is one of joint states that can be read.
    pub(crate) fn count(&mut self, id: u16, topics: &mut Topics) -> Option<(usize, Encoding)> {
        if let Some((last, topic, encoding)) = self.last
            && last == id
        {
            topics.count(topic);
            return Some((topic, encoding));
        }
        if !self.channels.contains_key(&id) && !self.add_from_summary(id, topics) {
            self.unknown += 1;
            return None;
        }
        let channel = self.channels.get(&id)?;
        topics.count(channel.topic);
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

    fn add_from_summary(&mut self, id: u16, topics: &mut Topics) -> bool {
        let Some(channel) = self.in_summary(id) else { return false };
        let kind = channel.schema.as_ref().map_or_else(String::new, |schema| schema.name.clone());
        self.add(id, topics.add(&channel.topic, kind, &channel.message_encoding));
        true
    }

    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let unknown = (self.unknown > 0).then(|| {
            format!("{} messages are left out, because the record that describes their channel is lost", self.unknown)
        });
        unknown.into_iter()
    }
}

/// What a metadata record says of the recording, nothing if it is another; none where it is damaged.
pub(crate) fn said_in(body: &[u8]) -> Option<BTreeMap<String, String>> {
    match parsed(op::METADATA, body)? {
        Record::Metadata(Metadata { name, metadata }) if name == METADATA => Some(metadata),
        _ => Some(BTreeMap::new()),
    }
}
