//! Messages `sensor_msgs/JointState` of SQLite files, as rosbag2 wrote them by default until 2023, as rows.

mod bag;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

pub(super) use self::bag::first_time;
use self::bag::{Bag, Stored};
use super::messages::{Message, Messages};
use super::{Row, Rows, Source};
use crate::error::ReadError;
use crate::file::file_name;

/// No message is longer, bytes.
const LONGEST_MESSAGE: usize = 1 << 26;
/// What a message begins with that rosbag2 compressed: the magic number of zstd.
const COMPRESSED: [u8; 4] = [0x28, 0xB5, 0x2F, 0xFD];

/// Rows of one or more SQLite files, one after another.
pub(super) struct SqliteRows {
    /// As it was named by whoever asked to read it.
    path: PathBuf,
    /// How many files there are, and those to come.
    count: usize,
    files: VecDeque<PathBuf>,
    bag: Bag,
    messages: Messages,
    /// The present file.
    present: PathBuf,
    /// What is lost of the files before it, and what of the folder is not read.
    lost: Vec<String>,
    /// Of compressed messages.
    decompressed: Vec<u8>,
}

impl SqliteRows {
    /// Opens files in the given order, one at least; `path` is their name in errors.
    pub(super) fn open(path: &Path, files: Vec<PathBuf>, lost: Vec<String>) -> Result<SqliteRows, ReadError> {
        let (count, mut files) = (files.len(), VecDeque::from(files));
        let first = files.pop_front().ok_or_else(|| ReadError::NoFile { path: path.to_owned() })?;
        let mut messages = Messages::default();
        let bag = Bag::open(&first, &mut messages.topics)?;
        let path = path.to_owned();
        let mut rows = SqliteRows { path, count, files, bag, messages, present: first, lost, decompressed: Vec::new() };
        rows.read_ahead()?;
        Ok(rows)
    }

    fn read_ahead(&mut self) -> Result<(), ReadError> {
        let mut row = Row::default();
        while self.next_row(&mut row)? && self.messages.keep(&row) {}
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
    fn next_row(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        loop {
            match self.bag.next(&mut self.messages.topics) {
                Some(stored) => {
                    if self.take(&stored, row)? {
                        return Ok(true);
                    }
                }
                None => {
                    let Some(file) = self.files.pop_front() else { return Ok(false) };
                    self.lost.extend(self.lost_of_file());
                    self.bag = Bag::open(&file, &mut self.messages.topics)?;
                    self.present = file;
                }
            }
        }
    }

    /// What is lost of the present file; of several it is named.
    fn lost_of_file(&self) -> Vec<String> {
        let remarks = self.bag.remarks();
        match self.count {
            1 => remarks.collect(),
            _ => remarks.map(|remark| format!("{}: {remark}", file_name(&self.present))).collect(),
        }
    }

    /// Takes a message; true if it is a row.
    fn take(&mut self, stored: &Stored, row: &mut Row) -> Result<bool, ReadError> {
        let Stored { topic, encoding, log_time, .. } = *stored;
        let data = match plain(&stored.data, &mut self.decompressed) {
            Ok(data) => data,
            Err(what) => {
                self.messages.damaged(topic, what);
                return Ok(false);
            }
        };
        self.messages.take(&self.path, &Message { topic, encoding, log_time, data }, row)
    }
}

/// The bytes of a message, decompressed if they are compressed.
fn plain<'a>(data: &'a [u8], decompressed: &'a mut Vec<u8>) -> Result<&'a [u8], &'static str> {
    if !data.starts_with(&COMPRESSED) {
        return Ok(data);
    }
    let damaged = "its compressed bytes are damaged";
    let size = zstd::zstd_safe::get_frame_content_size(data).ok().flatten().ok_or(damaged)?;
    let size = usize::try_from(size).ok().filter(|size| *size <= LONGEST_MESSAGE).ok_or("longer than any message")?;
    decompressed.clear();
    decompressed.reserve(size);
    let mut decompressor = zstd::bulk::Decompressor::new().map_err(|_| damaged)?;
    decompressor.decompress_to_buffer(data, decompressed).map_err(|_| damaged)?;
    Ok(decompressed)
}

impl Rows for SqliteRows {
    fn columns(&self) -> &[String] {
        self.messages.columns()
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        if let Some(first) = self.messages.kept() {
            *row = first;
            return Ok(true);
        }
        let found = self.next_row(row)?;
        self.messages.name_columns();
        Ok(found)
    }

    fn source(&self) -> Source {
        let kind = match self.count {
            1 => "ROS 2 bag in SQLite".to_owned(),
            count => format!("ROS 2 bag in {count} SQLite files"),
        };
        Source { kind, topics: self.messages.topics.found() }
    }

    fn remarks(&self) -> Vec<String> {
        let files = self.lost.iter().cloned().chain(self.lost_of_file());
        files.chain(self.messages.remarks()).collect()
    }

    fn lost(&self) -> Vec<String> {
        let files = self.lost.iter().cloned().chain(self.lost_of_file());
        files.chain(self.messages.topics.lost()).collect()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    fn progress(&self) -> f64 {
        let done = self.count - self.files.len() - 1;
        (done as f64 + self.bag.progress()) / self.count as f64
    }
}
