//! The records of an MCAP file one after another, as far as they are whole.
//!
//! ```text
//! magic, (opcode: 1 byte, length: 8 bytes, body)*, magic          a chunk's body holds records, perhaps compressed
//! ```
//!
//! Source: the MCAP specification, mcap.dev/spec. The frames outside of chunks are walked here, because a damaged chunk must not end
//! the reading; what is in a chunk is the `mcap` crate's. A chunk's check sum is tested before any of its records is given. Of a
//! file that ends early, every record is given that is there in full, those of its last chunk unchecked.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

use crate::error::ReadError;
use crate::file::{file_name, opened};
use crate::rows::shield::shielded;

/// Opcode and length.
const FRAME: u64 = 9;
/// What stands in a chunk before its records, where they are not compressed: start and end of its messages, size, check sum, length of the
/// name of the compression (0), length of the records.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;
/// A larger chunk is checked without keeping it in memory, and then read again.
const LARGE_CHUNK: u64 = 1 << 25;
/// Records are kept in memory up to this size.
const LARGEST_RECORD: usize = 1 << 26;
/// Losses that are told one by one.
const MOST_LOSSES: usize = 100;
/// Bytes that are read at a time.
const BUFFER: usize = 1 << 16;

/// A file that is read record by record.
pub(crate) struct Records {
    path: PathBuf,
    file: BufReader<File>,
    /// Length of the file, and where in it the next frame begins.
    length: u64,
    next: u64,
    chunk: Option<Chunk>,
    /// A reader of chunks that are checked before, which has read one to its end.
    used: Option<LinearReader>,
    /// Body of the last record.
    body: Vec<u8>,
    state: State,
    losses: Vec<Loss>,
    /// How many more there are.
    further_losses: u64,
    /// Where the frame of the present record or of its chunk begins.
    at: u64,
}

/// A chunk that is being read.
struct Chunk {
    reader: LinearReader,
    /// Bytes of it that the reader has not got yet.
    left: u64,
    /// Bytes of records that are to come, by what the chunk says of their length, where it is checked before.
    unread: Option<u64>,
    offset: u64,
    times: [u64; 2],
    cut: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Reading,
    Ended,
}

/// What of a file could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Loss {
    /// The file ends early.
    Cut {
        /// Its length.
        length: u64,
    },
    /// A chunk is damaged.
    Chunk {
        /// Where it begins.
        offset: u64,
        /// Of its first and last message, ns, as it says.
        times: [u64; 2],
        /// What is wrong.
        cause: String,
    },
    /// A record is too large to be one.
    Record {
        /// Where it begins.
        offset: u64,
        /// Its length.
        length: u64,
    },
    /// A record is damaged.
    Damaged {
        /// What it is.
        what: &'static str,
        /// Where it begins, or its chunk does.
        offset: u64,
        /// Whether it is in a chunk.
        in_chunk: bool,
        /// What is wrong.
        cause: String,
    },
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Loss::Cut { length } => write!(
                f,
                "the file is cut: it ends after {length} bytes without the end that every MCAP file has; all whole messages \
                 before that are read"
            ),
            Loss::Chunk { offset, times: [first, last], cause } => {
                let seconds = |time: u64| time as f64 * 1e-9;
                write!(
                    f,
                    "the chunk at byte {offset} with the messages from {:.3} s to {:.3} s is damaged and left out: {cause}",
                    seconds(*first),
                    seconds(*last)
                )
            }
            Loss::Record { offset, length } => {
                write!(f, "the record at byte {offset} is left out: it is {length} bytes long, which no message is")
            }
            Loss::Damaged { what, offset, in_chunk, cause } => {
                let place = if *in_chunk { "in the chunk at byte" } else { "at byte" };
                write!(f, "{what} {place} {offset} is damaged and left out: {cause}")
            }
        }
    }
}

/// What comes next in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// A record with this opcode; [`Records::body`] has its body.
    Record(u8),
    /// An attachment of this length; [`Records::unread`] reads its body.
    Attachment(u64),
    /// Nothing.
    End,
}

/// What a step in a chunk comes to.
enum Step {
    Record(u8),
    End,
    /// Why.
    Failed(String),
}

impl Records {
    /// Opens a file.
    ///
    /// # Errors
    ///
    /// It cannot be opened, or does not begin as an MCAP file does.
    pub(crate) fn open(path: &Path) -> Result<Records, ReadError> {
        let file = opened(path).map_err(|cause| ReadError::opening(path, cause))?;
        let length = file.metadata().map_err(|cause| ReadError::opening(path, cause))?.len();
        let mut file = BufReader::with_capacity(BUFFER, file);
        let mut magic = Vec::new();
        let read = (&mut file).take(MAGIC.len() as u64).read_to_end(&mut magic);
        read.map_err(|cause| ReadError::opening(path, cause))?;
        if magic != MAGIC {
            let what = "it does not begin as an MCAP file does".to_owned();
            return Err(ReadError::NotRecording { path: path.to_owned(), what });
        }
        let (next, chunk, used, body) = (MAGIC.len() as u64, None, None, Vec::new());
        let (state, losses) = (State::Reading, Vec::new());
        let path = path.to_owned();
        Ok(Records { path, file, length, next, chunk, used, body, state, losses, further_losses: 0, at: next })
    }

    /// Body of the record that [`next`](Self::next) came to.
    pub(crate) fn body(&self) -> &[u8] {
        &self.body
    }

    /// Name of the file.
    pub(crate) fn name(&self) -> String {
        file_name(&self.path)
    }

    /// What could not be read so far.
    pub(crate) fn remarks(&self) -> impl Iterator<Item = String> + '_ {
        let further = (self.further_losses > 0).then(|| format!("{} more parts are left out", self.further_losses));
        self.losses.iter().map(ToString::to_string).chain(further)
    }

    /// Notes that the record that [`next`](Self::next) came to is damaged, and so is left out.
    pub(crate) fn lose_record(&mut self, what: &'static str, cause: String) {
        self.note(Loss::Damaged { what, offset: self.at, in_chunk: self.chunk.is_some(), cause });
    }

    fn note(&mut self, loss: Loss) {
        match self.losses.len() < MOST_LOSSES {
            true => self.losses.push(loss),
            false => self.further_losses += 1,
        }
    }

    /// Bytes that are read, and all of them.
    pub(crate) fn progress(&self) -> (u64, u64) {
        (self.next - self.chunk.as_ref().map_or(0, |chunk| chunk.left), self.length)
    }

    /// The body of the attachment that [`next`](Self::next) came to, from its beginning.
    ///
    /// # Errors
    ///
    /// The operating system refuses.
    pub(crate) fn unread(&mut self, length: u64) -> Result<impl Read + '_, ReadError> {
        let found = self.seek(self.next - length);
        found.map_err(|cause| ReadError::Io { path: self.path.clone(), cause })?;
        Ok((&mut self.file).take(length))
    }

    /// Goes on to the next record.
    ///
    /// # Errors
    ///
    /// The operating system refuses to read.
    pub(crate) fn next(&mut self) -> Result<Next, ReadError> {
        let next = self.step();
        next.map_err(|cause| ReadError::Io { path: self.path.clone(), cause })
    }

    fn step(&mut self) -> io::Result<Next> {
        while self.state == State::Reading {
            let found = match self.chunk.take() {
                Some(chunk) => self.in_chunk(chunk)?,
                None => self.frame()?,
            };
            if let Some(found) = found {
                return Ok(found);
            }
        }
        Ok(Next::End)
    }

    /// The next frame outside of chunks; `None` where it is to be passed over, or is a chunk.
    fn frame(&mut self) -> io::Result<Option<Next>> {
        let offset = self.next;
        self.at = offset;
        let left = self.length - offset;
        self.seek(offset)?;
        let mut frame = [0; FRAME as usize];
        if left < FRAME || read_full(&mut self.file, &mut frame)? < frame.len() {
            self.cut();
            return Ok(None);
        }
        let [opcode, length @ ..] = frame;
        let length = u64::from_le_bytes(length);
        let left = left - FRAME;
        match opcode {
            op::DATA_END | op::FOOTER => {
                self.state = State::Ended;
                self.next = self.length;
                return Ok(None);
            }
            op::CHUNK => return self.enter(offset, length, left).map(|()| None),
            _ if length > left => {
                self.cut();
                return Ok(None);
            }
            _ => self.next = offset + FRAME + length,
        }
        match opcode {
            op::ATTACHMENT => Ok(Some(Next::Attachment(length))),
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | 0x80.. => {
                if length > LARGEST_RECORD as u64 {
                    self.note(Loss::Record { offset, length });
                    return Ok(None);
                }
                self.body.resize(length as usize, 0);
                if read_full(&mut self.file, &mut self.body)? < self.body.len() {
                    self.cut();
                    return Ok(None);
                }
                Ok(Some(Next::Record(opcode)))
            }
            // Written anew with what they point to.
            op::MESSAGE_INDEX | op::CHUNK_INDEX | op::ATTACHMENT_INDEX => Ok(None),
            op::STATISTICS | op::METADATA_INDEX | op::SUMMARY_OFFSET => Ok(None),
            _ => {
                self.lose_record("the record", format!("nobody knows its kind, {opcode}"));
                Ok(None)
            }
        }
    }

    /// Begins a chunk whose frame is at `offset`; `left` bytes of the file are after the frame.
    fn enter(&mut self, offset: u64, length: u64, left: u64) -> io::Result<()> {
        let cut = length > left;
        self.next = offset + FRAME + length.min(left);
        let mut head = [0; CHUNK_HEAD];
        if length.min(left) < head.len() as u64 || read_full(&mut self.file, &mut head)? < head.len() {
            match cut {
                true => self.cut(),
                false => self.lose(offset, [0, 0], McapError::UnexpectedEoc.to_string()),
            };
            return Ok(());
        }
        let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|byte| head[at + byte]));
        let times = [number(0), number(8)];
        // Records may not go on over the end of theirs: the reader of chunks does not look.
        let uncompressed = head[28..32] == [0; 4];
        if uncompressed && number(32) != length - CHUNK_HEAD as u64 {
            self.lose(offset, times, McapError::UnexpectedEoc.to_string());
            return Ok(());
        }
        let large = length.max(number(16)) > LARGE_CHUNK;
        let left = FRAME + length.min(left);
        let chunk = |reader: LinearReader, unread: Option<u64>| Chunk { reader, left, unread, offset, times, cut };
        if large && !cut {
            let mut chunk = chunk(reader(Check::Meanwhile), None);
            self.seek(offset)?;
            loop {
                match self.advance(&mut chunk, Keep::No)? {
                    Step::Record(_) => {}
                    Step::End => break,
                    Step::Failed(cause) => {
                        self.lose(offset, times, cause);
                        return Ok(());
                    }
                }
            }
        }
        self.seek(offset)?;
        self.chunk = Some(match large || cut {
            true => chunk(reader(Check::No), None),
            false => {
                let reader = self.used.take().unwrap_or_else(|| reader(Check::Before));
                // Where nothing is compressed the length of the records is said twice, and may be said wrong.
                chunk(reader, Some(if uncompressed { number(32) } else { number(16) }))
            }
        });
        Ok(())
    }

    /// The next record of a chunk; `None` at its end.
    fn in_chunk(&mut self, mut chunk: Chunk) -> io::Result<Option<Next>> {
        match self.advance(&mut chunk, Keep::Body)? {
            Step::Record(opcode) => {
                self.chunk = Some(chunk);
                Ok(Some(Next::Record(opcode)))
            }
            Step::End => {
                self.used = (chunk.unread == Some(0)).then_some(chunk.reader);
                Ok(None)
            }
            Step::Failed(_) if chunk.cut => {
                self.cut();
                Ok(None)
            }
            Step::Failed(cause) => {
                self.lose(chunk.offset, chunk.times, cause);
                Ok(None)
            }
        }
    }

    fn advance(&mut self, chunk: &mut Chunk, keep: Keep) -> io::Result<Step> {
        loop {
            let reader = &mut chunk.reader;
            let event = match shielded(move || reader.next_event()) {
                Ok(event) => event,
                Err(panicked) => return Ok(Step::Failed(panicked.to_string())),
            };
            match event {
                None => return Ok(Step::End),
                Some(Err(error)) => return Ok(Step::Failed(error.to_string())),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    // Of a wrong length something is left, or there are more records than it says.
                    chunk.unread = chunk.unread.and_then(|unread| unread.checked_sub(FRAME + data.len() as u64));
                    if keep == Keep::Body {
                        self.body.clear();
                        self.body.extend_from_slice(data);
                    }
                    return Ok(Step::Record(opcode));
                }
                // It waits for another chunk, and may have it.
                Some(Ok(LinearReadEvent::ReadRequest(_))) if chunk.left == 0 && chunk.unread == Some(0) => {
                    return Ok(Step::End);
                }
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                    let wanted = wanted.max(BUFFER).min(usize::try_from(chunk.left).unwrap_or(usize::MAX));
                    // Not all at once: a length that is no more than said costs no memory.
                    let wanted = wanted.min(1 << 22);
                    let read = match wanted {
                        0 => 0,
                        _ => self.file.read(chunk.reader.insert(wanted))?,
                    };
                    chunk.left -= read as u64;
                    chunk.reader.notify_read(read);
                }
            }
        }
    }

    /// The file ends before its end.
    fn cut(&mut self) {
        self.state = State::Ended;
        self.next = self.length;
        self.note(Loss::Cut { length: self.length });
    }

    fn lose(&mut self, offset: u64, times: [u64; 2], cause: String) {
        self.note(Loss::Chunk { offset, times, cause });
    }

    /// Goes to a place in the file, within what is buffered if possible.
    fn seek(&mut self, to: u64) -> io::Result<()> {
        let at = self.file.stream_position()?;
        match i64::try_from(i128::from(to) - i128::from(at)) {
            Ok(0) => Ok(()),
            Ok(by) => self.file.seek_relative(by),
            Err(_) => self.file.seek(SeekFrom::Start(to)).map(|_| ()),
        }
    }
}

/// What is kept of a record.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keep {
    Body,
    No,
}

/// When a chunk's check sum is tested.
#[derive(Clone, Copy)]
enum Check {
    /// Before its first record is given; the chunk is kept in memory.
    Before,
    /// After its last record.
    Meanwhile,
    /// Never.
    No,
}

/// A reader of one chunk in its frame.
fn reader(check: Check) -> LinearReader {
    let options = LinearReaderOptions::default().with_skip_start_magic(true).with_skip_end_magic(true);
    let options = options.with_record_length_limit(LARGEST_RECORD);
    LinearReader::new_with_options(match check {
        Check::Before => options.with_prevalidate_chunk_crcs(true),
        Check::Meanwhile => options.with_validate_chunk_crcs(true),
        Check::No => options,
    })
}

/// Reads until the buffer is full or the file ends; how much that is.
fn read_full(file: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut at = 0;
    while at < buffer.len() {
        match file.read(&mut buffer[at..]) {
            Ok(0) => break,
            Ok(read) => at += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(at)
}
