//! Messages `sensor_msgs/JointState` of MCAP files as rows.

mod channels;
mod edit;
pub(crate) mod parsed;
pub(crate) mod records;
mod summary;

use std::collections::{BTreeMap, VecDeque};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::Channel;

use self::channels::Channels;
use self::records::{Next, Records};
use super::joint_state::Quantity;
use super::messages::{Encoding, Message, Messages};
use super::{Row, Rows, Source};
use crate::error::ReadError;

/// What stands before the data of a message: channel, sequence, time of logging, time of publishing.
pub(crate) const HEADER: usize = 2 + 4 + 8 + 8;

/// Rows of one or more MCAP files, one after another.
pub(crate) struct McapRows {
    /// As it was named by whoever asked to read it.
    path: PathBuf,
    /// How many files there are, and those to come.
    count: usize,
    files: VecDeque<PathBuf>,
    records: Records,
    channels: Channels,
    messages: Messages,
    metadata: BTreeMap<String, String>,
    /// Bytes of the files before the present one, and of all.
    before: u64,
    total: u64,
    /// What is lost of the files before the present one, and what of the folder is not read.
    lost: Vec<String>,
}

impl McapRows {
    /// Opens a file.
    pub(crate) fn open(path: &Path) -> Result<McapRows, ReadError> {
        McapRows::open_files(path, vec![path.to_owned()], Vec::new())
    }

    /// Opens files in the given order, one at least; `path` is their name in errors.
    pub(super) fn open_files(path: &Path, files: Vec<PathBuf>, lost: Vec<String>) -> Result<McapRows, ReadError> {
        let length = |file: &PathBuf| std::fs::metadata(file).map_or(0, |found| found.len());
        let total = files.iter().map(length).sum();
        let (count, mut files) = (files.len(), VecDeque::from(files));
        let first = files.pop_front().ok_or_else(|| ReadError::NoFile { path: path.to_owned() })?;
        let mut rows = McapRows {
            path: path.to_owned(),
            count,
            files,
            records: Records::open(&first)?,
            channels: Channels::of(&first),
            messages: Messages::default(),
            metadata: BTreeMap::new(),
            before: 0,
            total,
            lost,
        };
        rows.metadata = rows.channels.metadata(&first);
        rows.read_ahead()?;
        Ok(rows)
    }

    /// The same file from its beginning, with the names of the columns known.
    pub(crate) fn again(mut self) -> Result<McapRows, ReadError> {
        self.records = Records::open(&self.path)?;
        self.channels = Channels::of(&self.path);
        self.messages.begin_again();
        self.before = 0;
        Ok(self)
    }

    /// The next record; [`body`](Self::body) and [`unread`](Self::unread) are of that.
    pub(crate) fn next_record(&mut self) -> Result<Next, ReadError> {
        self.records.next()
    }

    pub(crate) fn body(&self) -> &[u8] {
        self.records.body()
    }

    /// The body of the attachment that came last, from its beginning.
    pub(crate) fn unread(&mut self, length: u64) -> Result<impl Read + '_, ReadError> {
        self.records.unread(length)
    }

    /// Notes that the present record is damaged, and so is left out.
    pub(crate) fn lose(&mut self, what: &'static str, cause: String) {
        self.records.lose_record(what, cause);
    }

    /// Whether the messages of a channel are joint states that can be read.
    pub(crate) fn is_joint_states(&self, channel: u16) -> bool {
        self.channels.joint_states(channel).is_some()
    }

    /// What the summary of the file says of a channel.
    pub(crate) fn channel_in_summary(&self, channel: u16) -> Option<Arc<Channel<'static>>> {
        self.channels.in_summary(channel)
    }

    /// Names the columns that came last.
    pub(crate) fn name_columns(&mut self) {
        self.messages.name_columns();
    }

    /// Changes the numbers of the message that was read last, where `changed` gives another for their column.
    pub(crate) fn edit(&self, channel: u16, data: &mut Vec<u8>, changed: &dyn Fn(usize) -> Option<f64>) {
        let Some((topic, encoding)) = self.channels.joint_states(channel) else { return };
        let column = |quantity: Quantity, joint: usize| self.messages.place(topic, quantity, joint);
        let changed = |quantity, joint| column(quantity, joint).and_then(changed);
        match encoding {
            Encoding::Cdr => edit::cdr(data, &changed),
            Encoding::Json => edit::json(data, &changed),
        }
    }

    fn read_ahead(&mut self) -> Result<(), ReadError> {
        let mut row = Row::default();
        while self.next_message(&mut row)? && self.messages.keep(&row) {}
        self.messages.name_columns();
        match self.messages.is_empty() {
            true => Err(ReadError::NoJointStates {
                path: self.path.clone(),
                found: self.messages.topics.described(),
                lost: self.remarks(),
            }),
            false => Ok(()),
        }
    }

    /// The next message that is one of joint states.
    fn next_message(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        loop {
            match self.records.next()? {
                Next::Record(opcode) => {
                    if self.take(opcode, row)? {
                        return Ok(true);
                    }
                }
                Next::Attachment(_) => {}
                Next::End => {
                    if !self.next_file()? {
                        return Ok(false);
                    }
                }
            }
        }
    }

    /// What is lost of the present file; of several it is named.
    fn lost_of_file(&self) -> Vec<String> {
        let remarks = self.records.remarks();
        match self.count {
            1 => remarks.collect(),
            _ => remarks.map(|remark| format!("{}: {remark}", self.records.name())).collect(),
        }
    }

    /// Goes to the next file.
    fn next_file(&mut self) -> Result<bool, ReadError> {
        let Some(file) = self.files.pop_front() else { return Ok(false) };
        self.lost.extend(self.lost_of_file());
        self.before += self.records.progress().1;
        self.records = Records::open(&file)?;
        self.channels.next_file(&file);
        Ok(true)
    }

    /// Takes what a record says; true if that is a row. Notes what is damaged.
    pub(crate) fn take(&mut self, opcode: u8, row: &mut Row) -> Result<bool, ReadError> {
        use mcap::records::op;
        let body = self.records.body();
        let lost = match opcode {
            op::MESSAGE => match split(body) {
                Some((channel, log_time, _)) => return self.take_message(channel, log_time, row),
                None => Some("the message"),
            },
            op::METADATA => match channels::said_in(body) {
                Some(said) => {
                    self.metadata.extend(said);
                    None
                }
                None => Some("the metadata record"),
            },
            op::SCHEMA | op::CHANNEL => {
                let taken = self.channels.take(opcode, body, &mut self.messages.topics);
                (!taken).then_some(if opcode == op::SCHEMA { "the schema" } else { "the description of a channel" })
            }
            op::HEADER => parsed::parsed(opcode, body).is_none().then_some("the header"),
            0x80.. => None,
            _ => Some("the record"),
        };
        if let Some(what) = lost {
            self.lose(what, "it cannot be taken apart".to_owned());
        }
        Ok(false)
    }

    fn take_message(&mut self, channel: u16, log_time: u64, row: &mut Row) -> Result<bool, ReadError> {
        let found = self.channels.count(channel, &mut self.messages.topics);
        let Some((topic, encoding)) = found else { return Ok(false) };
        let data = &self.records.body()[HEADER..];
        self.messages.take(&self.path, &Message { topic, encoding, log_time, data }, row)
    }
}

impl Rows for McapRows {
    fn columns(&self) -> &[String] {
        self.messages.columns()
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        if let Some(first) = self.messages.kept() {
            *row = first;
            return Ok(true);
        }
        let found = self.next_message(row)?;
        self.messages.name_columns();
        Ok(found)
    }

    fn source(&self) -> Source {
        let kind = match self.count {
            1 => "MCAP file".to_owned(),
            count => format!("{count} MCAP files"),
        };
        Source { kind, topics: self.messages.topics.found() }
    }

    fn remarks(&self) -> Vec<String> {
        let files = self.lost.iter().cloned().chain(self.lost_of_file());
        files.chain(self.channels.remarks()).chain(self.messages.remarks()).collect()
    }

    fn lost(&self) -> Vec<String> {
        let files = self.lost.iter().cloned().chain(self.lost_of_file());
        files.chain(self.channels.remarks()).chain(self.messages.topics.lost()).collect()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        self.metadata.clone()
    }

    fn progress(&self) -> f64 {
        let (read, _) = self.records.progress();
        (self.before + read) as f64 / (self.total.max(1)) as f64
    }
}

/// A message record as its channel, its time of logging, ns, and its data.
pub(crate) fn split(body: &[u8]) -> Option<(u16, u64, &[u8])> {
    let (header, data) = body.split_at_checked(HEADER)?;
    let channel = u16::from_le_bytes([header[0], header[1]]);
    let log_time = u64::from_le_bytes(std::array::from_fn(|byte| header[6 + byte]));
    Some((channel, log_time, data))
}

/// When the first message of a file was logged, ns; the end of time where there is none.
pub(super) fn first_time(path: &Path) -> Result<u64, ReadError> {
    let mut records = Records::open(path)?;
    loop {
        match records.next()? {
            Next::Record(mcap::records::op::MESSAGE) => {
                if let Some((_, log_time, _)) = split(records.body()) {
                    return Ok(log_time);
                }
            }
            Next::Record(_) | Next::Attachment(_) => {}
            Next::End => return Ok(u64::MAX),
        }
    }
}
