//! The summary at the end of an MCAP file.
//!
//! ```text
//! …, (opcode: 1 byte, length: 8 bytes, body)*, footer, magic          the footer says where the summary's records begin
//! ```
//!
//! Source: the MCAP specification, mcap.dev/spec. The records are walked here and only those are parsed that are wanted: the `mcap`
//! crate's reader of summaries panics on a damaged attachment among them, which is no record of a summary.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use mcap::records::{MetadataIndex, Record, op};
use mcap::{Channel, MAGIC, read::ChannelAccumulator};

use super::parsed::parsed;
use crate::file::opened;

/// A record of the summary is kept in memory up to this size.
pub(super) const LARGEST: u64 = 1 << 24;
/// Opcode and length.
const FRAME: usize = 9;
/// Of the footer with its frame.
const FOOTER: usize = FRAME + 8 + 8 + 4;

/// What of a file's summary is of use here.
#[derive(Default)]
pub(super) struct Summary {
    channels: ChannelAccumulator<'static>,
    /// Where metadata records are.
    pub metadata: Vec<MetadataIndex>,
}

impl Summary {
    /// None where there is none or it is damaged.
    pub fn of(path: &Path) -> Option<Summary> {
        let mut file = BufReader::new(opened(path).ok()?);
        let end = file.seek(SeekFrom::End(-((FOOTER + MAGIC.len()) as i64))).ok()?;
        let mut footer = [0; FOOTER + MAGIC.len()];
        file.read_exact(&mut footer).ok()?;
        let (record, magic) = footer.split_at(FOOTER);
        let Some(Record::Footer(footer)) = parsed(*record.first()?, &record[FRAME..]) else { return None };
        if magic != MAGIC || footer.summary_start == 0 || footer.summary_start > end {
            return None;
        }
        file.seek(SeekFrom::Start(footer.summary_start)).ok()?;
        let mut records = file.take(end - footer.summary_start);
        let mut summary = Summary::default();
        while records.limit() > 0 {
            summary.take(&mut records)?;
        }
        Some(summary)
    }

    /// What it says of a channel.
    pub fn channel(&self, id: u16) -> Option<Arc<Channel<'static>>> {
        self.channels.get(id)
    }

    /// Takes the next record; none where it is damaged.
    fn take(&mut self, records: &mut impl Read) -> Option<()> {
        let mut frame = [0; FRAME];
        records.read_exact(&mut frame).ok()?;
        let [opcode, length @ ..] = frame;
        let length = u64::from_le_bytes(length);
        let wanted = matches!(opcode, op::SCHEMA | op::CHANNEL | op::METADATA_INDEX);
        if wanted && length > LARGEST {
            return None;
        }
        let mut body = Vec::new();
        let read = match wanted {
            true => records.take(length).read_to_end(&mut body).ok()? as u64,
            false => std::io::copy(&mut records.take(length), &mut std::io::sink()).ok()?,
        };
        if read < length {
            return None;
        }
        if wanted {
            match parsed(opcode, &body)?.into_owned() {
                Record::Schema { header, data } => self.channels.add_schema(header, data).ok()?,
                Record::Channel(channel) => self.channels.add_channel(channel).ok()?,
                Record::MetadataIndex(index) => self.metadata.push(index),
                _ => {}
            }
        }
        Some(())
    }
}
