//! An attachment in its bytes.
//!
//! ```text
//! u64 u64         times of logging and of creation, ns
//! string string   name and type, each with its length (u32) before
//! u64 bytes       the bytes with their number before
//! u32             CRC-32 of all that, or 0 where nobody computed it
//! ```
//!
//! Source: the MCAP specification, mcap.dev/spec. It may be larger than memory, so it is read piece by piece.

use std::io::{self, Read};

use crc32fast::Hasher;
use mcap::records::AttachmentHeader;

/// No name or type is longer, bytes.
const LONGEST_NAME: u64 = 1 << 16;

/// Why an attachment cannot be read.
#[derive(Debug)]
pub(super) enum Wrong {
    /// It is damaged, so.
    Damaged(&'static str),
    /// The operating system refuses.
    Io(io::Error),
}

impl From<io::Error> for Wrong {
    fn from(cause: io::Error) -> Wrong {
        match cause.kind() {
            io::ErrorKind::UnexpectedEof => Wrong::Damaged("it is shorter than it says"),
            io::ErrorKind::InvalidData => Wrong::Damaged("its name is no text"),
            _ => Wrong::Io(cause),
        }
    }
}

impl From<Wrong> for io::Error {
    fn from(wrong: Wrong) -> io::Error {
        match wrong {
            Wrong::Damaged(what) => io::Error::new(io::ErrorKind::InvalidData, what),
            Wrong::Io(cause) => cause,
        }
    }
}

/// Whether it is whole: as long as it says, and with the right check sum, where it has one.
pub(super) fn check(body: &mut impl Read, length: u64) -> Result<(), Wrong> {
    let mut summed = Summed { input: body, sum: Hasher::new() };
    let (_, data) = head(&mut summed, length)?;
    if io::copy(&mut (&mut summed).take(data), &mut io::sink())? < data {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
    }
    let Summed { input, sum } = summed;
    let mut said = [0; 4];
    input.read_exact(&mut said)?;
    match u32::from_le_bytes(said) {
        0 => Ok(()),
        said if said == sum.finalize() => Ok(()),
        _ => Err(Wrong::Damaged("its check sum is not that of its bytes")),
    }
}

/// What stands before the bytes, and how many these are.
pub(super) fn head(body: &mut impl Read, length: u64) -> Result<(AttachmentHeader, u64), Wrong> {
    let number = |body: &mut dyn Read| -> io::Result<u64> {
        let mut bytes = [0; 8];
        body.read_exact(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    };
    let text = |body: &mut dyn Read| -> io::Result<String> {
        let mut bytes = [0; 4];
        body.read_exact(&mut bytes)?;
        let length = u64::from(u32::from_le_bytes(bytes));
        let mut text = String::new();
        body.take(length.min(LONGEST_NAME)).read_to_string(&mut text)?;
        if text.len() as u64 == length { Ok(text) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    };
    let (log_time, create_time) = (number(body)?, number(body)?);
    let (name, media_type) = (text(body)?, text(body)?);
    let data = number(body)?;
    let around = (8 + 8 + 4 + name.len() + 4 + media_type.len() + 8 + 4) as u64;
    match around.checked_add(data) {
        Some(all) if all <= length => Ok((AttachmentHeader { log_time, create_time, name, media_type }, data)),
        _ => Err(io::Error::from(io::ErrorKind::UnexpectedEof).into()),
    }
}

/// Sums what is read.
struct Summed<R> {
    input: R,
    sum: Hasher,
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.sum.update(&buffer[..read]);
        Ok(read)
    }
}
