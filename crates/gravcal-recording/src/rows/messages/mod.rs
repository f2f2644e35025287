//! Messages `sensor_msgs/JointState` as rows, whatever kind of bag they come from.
//!
//! One message is one row. Its columns are `time_s` (`header.stamp`, or the time at which it was logged where that is zero) and
//! `<joint>.position`, `<joint>.velocity`, `<joint>.effort`, whatever the order of the joints in the message. Where several topics
//! speak of one joint, the names of its columns begin with the topic: `/arm/joint_states:shoulder.position`. So that the names are
//! known, the first messages are read ahead; a topic that speaks of a known joint only later has its own columns with its name,
//! and a remark.

mod cells;
mod columns;
mod topics;

use std::collections::VecDeque;
use std::path::Path;

use self::columns::{Columns, Unread};
pub(crate) use self::topics::{Encoding, JOINT_STATE, Topics};
use super::joint_state::Quantity;
use super::{MOST_COLUMNS, Row};
use crate::error::ReadError;

/// Messages that are read ahead to know the names of the columns, and the most cells that they fill.
const AHEAD: usize = 10_000;
const AHEAD_CELLS: usize = 1 << 20;

/// A message that is one of joint states.
pub(crate) struct Message<'a> {
    /// Place of its topic.
    pub topic: usize,
    pub encoding: Encoding,
    /// When it was logged, ns.
    pub log_time: u64,
    pub data: &'a [u8],
}

/// The messages of a bag so far.
#[derive(Default)]
pub(crate) struct Messages {
    pub topics: Topics,
    columns: Columns,
    /// How many of joint states there were.
    count: u64,
    /// Rows that were read ahead.
    ahead: VecDeque<Row>,
}

impl Messages {
    /// Takes a message; true if it is a row, false if it is damaged, which the remarks say.
    ///
    /// # Errors
    ///
    /// It names more joints than any recording has columns for; `path` is the bag.
    pub(crate) fn take(&mut self, path: &Path, message: &Message<'_>, row: &mut Row) -> Result<bool, ReadError> {
        self.count += 1;
        row.number = self.count;
        let read = match message.encoding {
            Encoding::Cdr => cells::cdr(message, &mut self.columns, &mut row.cells),
            Encoding::Json => cells::json(message, &mut self.columns, &mut row.cells),
        };
        match read {
            Ok(()) => Ok(true),
            Err(Unread::Damaged(what)) => {
                self.topics.malformed(message.topic, what, self.count);
                Ok(false)
            }
            Err(Unread::TooManyJoints(found)) => {
                let topic = &self.topics.names()[message.topic];
                let what = format!(
                    "a message of {topic} names {found} joints, and no more than {} are read, of {MOST_COLUMNS} columns in all",
                    columns::MOST_JOINTS
                );
                Err(ReadError::NotRecording { path: path.to_owned(), what })
            }
        }
    }

    /// Counts a message of joint states that is damaged before it can be taken.
    pub(crate) fn damaged(&mut self, topic: usize, what: &str) {
        self.count += 1;
        self.topics.malformed(topic, what.to_owned(), self.count);
    }

    /// Keeps a row that is read ahead; false where it is the last that is.
    pub(crate) fn keep(&mut self, row: &Row) -> bool {
        self.ahead.push_back(row.clone());
        self.ahead.len() < AHEAD && self.ahead.len() * row.cells.len() < AHEAD_CELLS
    }

    /// The next row that was read ahead.
    pub(crate) fn kept(&mut self) -> Option<Row> {
        let mut first = self.ahead.pop_front()?;
        first.cells.resize(self.columns.names().len(), f64::NAN);
        Some(first)
    }

    /// Whether no row was read ahead.
    pub(crate) fn is_empty(&self) -> bool {
        self.ahead.is_empty()
    }

    /// Before the same messages are read again, with the names of the columns known.
    pub(crate) fn begin_again(&mut self) {
        self.columns.forget_layouts();
        self.ahead.clear();
        self.topics = Topics::default();
        self.count = 0;
    }

    /// Names the columns that came last.
    pub(crate) fn name_columns(&mut self) {
        self.columns.name(self.topics.names());
    }

    /// Names of the columns so far.
    pub(crate) fn columns(&self) -> &[String] {
        self.columns.names()
    }

    /// The column of a joint of the topic's last message.
    pub(crate) fn place(&self, topic: usize, quantity: Quantity, joint: usize) -> Option<usize> {
        self.columns.place(topic, quantity, joint)
    }

    /// What of them could not be read or looks wrong.
    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        self.topics.remarks().chain(self.columns.remarks())
    }
}
