//! MCAP: numbers are changed where they stand in their messages; every other record is copied.

mod attachment;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::Path;

use mcap::records::{MessageHeader, Metadata, Record, op};
use mcap::write::PrivateRecordOptions;
use mcap::{McapError, Writer};

use self::attachment::Wrong;
use super::{Change, Paced, RewriteError, Rewriting, Watch, same};
use crate::error::ReadError;
use crate::rows::mcap::parsed::parsed;
use crate::rows::mcap::records::Next;
use crate::rows::mcap::{HEADER, McapRows};
use crate::rows::write::mcap::{METADATA, failed, options};
use crate::rows::{Row, Rows};
use crate::write::NewFile;

/// Bytes of an attachment that are copied at a time.
const PIECE: usize = 1 << 16;

pub(super) fn rewrite(
    what: &Rewriting<'_>,
    change: &mut Change<'_>,
    watch: &mut Watch<'_>,
) -> Result<Vec<String>, RewriteError> {
    let Rewriting { input, output, overwrite, notes, .. } = *what;
    let mut rows = McapRows::open(input)?.again()?;
    let mut paced = Paced { watch, rows: 0 };
    let mut next = rows.next_record()?;
    let mut copy = Copy::begin(output, overwrite, next, &rows)?;
    copy.note(notes)?;
    let mut row = Row::default();
    while next != Next::End {
        match next {
            Next::End => {}
            Next::Attachment(length) => {
                let checked = attachment::check(&mut rows.unread(length)?, length);
                match checked {
                    Ok(()) => copy.attachment(rows.unread(length)?, length)?,
                    Err(Wrong::Damaged(cause)) => rows.lose("the attachment", cause.to_owned()),
                    Err(Wrong::Io(cause)) => return Err(ReadError::Io { path: input.to_owned(), cause }.into()),
                }
            }
            Next::Record(op::MESSAGE) => {
                let found = rows.take(op::MESSAGE, &mut row)?;
                rows.name_columns();
                if let Some(data) = changed_message(&rows, found, &mut row, change) {
                    copy.message(&rows, &data)?;
                }
                if found {
                    paced.row(|| rows.progress())?;
                }
            }
            Next::Record(opcode) => {
                rows.take(opcode, &mut row)?;
                copy.record(opcode, rows.body())?;
            }
        }
        next = rows.next_record()?;
    }
    copy.finish()?;
    Ok(rows.remarks())
}

/// The present message with its numbers changed, where it is a row; none where it is damaged, as the remarks say.
fn changed_message(
    rows: &McapRows,
    found: bool,
    row: &mut Row,
    change: &mut Change<'_>,
) -> Option<(MessageHeader, Vec<u8>)> {
    let (header, data) = message(rows.body())?;
    if !found && rows.is_joint_states(header.channel_id) {
        return None;
    }
    let mut data = data.to_vec();
    if found {
        let before = row.cells.clone();
        change(rows.columns(), &mut row.cells);
        let changed = |column: usize| {
            let (after, before) = (row.cells[column], before[column]);
            (!same(after, before)).then_some(after)
        };
        rows.edit(header.channel_id, &mut data, &changed);
    }
    Some((header, data))
}

/// A message record as its header and data.
fn message(body: &[u8]) -> Option<(MessageHeader, &[u8])> {
    match parsed(op::MESSAGE, body) {
        Some(Record::Message { header, .. }) => Some((header, body.get(HEADER..)?)),
        _ => None,
    }
}

/// The new file.
struct Copy<'a> {
    output: &'a Path,
    file: Writer<NewFile>,
    channels: BTreeSet<u16>,
}

impl<'a> Copy<'a> {
    /// Begins the file with the profile of the old one, which its first record says.
    fn begin(output: &'a Path, overwrite: bool, first: Next, rows: &McapRows) -> Result<Copy<'a>, RewriteError> {
        let mut options = options();
        if first == Next::Record(op::HEADER)
            && let Some(Record::Header(header)) = parsed(op::HEADER, rows.body())
        {
            options = options.profile(header.profile);
        }
        let file = NewFile::create(output, overwrite)?;
        let file = options.create(file).map_err(|error| failed(output, error))?;
        Ok(Copy { output, file, channels: BTreeSet::new() })
    }

    fn done<T>(&self, result: Result<T, McapError>) -> Result<T, RewriteError> {
        result.map_err(|error| failed(self.output, error).into())
    }

    fn note(&mut self, notes: &BTreeMap<String, String>) -> Result<(), RewriteError> {
        if notes.is_empty() {
            return Ok(());
        }
        let written = self.file.write_metadata(&Metadata { name: METADATA.to_owned(), metadata: notes.clone() });
        self.done(written)
    }

    /// Copies a record that is neither message nor attachment; damaged ones are left out, as the remarks say.
    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<(), RewriteError> {
        if opcode >= 0x80 {
            let written = self.file.write_private_record(opcode, body, PrivateRecordOptions::IncludeInChunks.into());
            return self.done(written);
        }
        match parsed(opcode, body) {
            Some(Record::Schema { header, data }) => {
                let written = self.file.add_schema_with_id(header.id, &header.name, &header.encoding, &data);
                self.done(written).map(|_| ())
            }
            Some(Record::Channel(channel)) => {
                let id = (channel.id, channel.schema_id);
                let written = self.file.add_channel_with_id(
                    id.0,
                    id.1,
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                );
                self.channels.insert(channel.id);
                self.done(written).map(|_| ())
            }
            Some(Record::Metadata(metadata)) => {
                let written = self.file.write_metadata(&metadata);
                self.done(written)
            }
            _ => Ok(()),
        }
    }

    /// Writes a message. Where the record of its channel is lost, the summary of the old file may have it; where nothing describes
    /// the channel, nobody can read the message, and the remarks count it.
    fn message(&mut self, rows: &McapRows, (header, data): &(MessageHeader, Vec<u8>)) -> Result<(), RewriteError> {
        if !self.channels.contains(&header.channel_id) {
            let Some(channel) = rows.channel_in_summary(header.channel_id) else { return Ok(()) };
            if let Some(schema) = &channel.schema {
                let written = self.file.add_schema_with_id(schema.id, &schema.name, &schema.encoding, &schema.data);
                self.done(written)?;
            }
            let schema = channel.schema.as_ref().map_or(0, |schema| schema.id);
            let written = self.file.add_channel_with_id(
                channel.id,
                schema,
                &channel.topic,
                &channel.message_encoding,
                &channel.metadata,
            );
            self.done(written)?;
            self.channels.insert(channel.id);
        }
        let written = self.file.write_to_known_channel(header, data);
        self.done(written)
    }

    /// Copies an attachment, which is whole, piece by piece.
    fn attachment(&mut self, mut body: impl Read, length: u64) -> Result<(), RewriteError> {
        let head =
            attachment::head(&mut body, length).map_err(|wrong| failed(self.output, McapError::Io(wrong.into())))?;
        let (header, data) = head;
        let begun = self.file.start_attachment(data, header);
        self.done(begun)?;
        let mut piece = [0; PIECE];
        let mut left = data;
        while left > 0 {
            let most = PIECE.min(usize::try_from(left).unwrap_or(PIECE));
            let read = match body.read(&mut piece[..most]) {
                Ok(0) => return Err(failed(self.output, McapError::UnexpectedEof).into()),
                Ok(read) => read,
                Err(cause) => return Err(failed(self.output, McapError::Io(cause)).into()),
            };
            let written = self.file.put_attachment_bytes(&piece[..read]);
            self.done(written)?;
            left -= read as u64;
        }
        let finished = self.file.finish_attachment();
        self.done(finished)
    }

    fn finish(mut self) -> Result<(), RewriteError> {
        let finished = self.file.finish();
        self.done(finished)?;
        Ok(self.file.into_inner().finish()?)
    }
}
