//! The lengths that a Parquet file announces, checked before the libraries make room for them.
//!
//! ```text
//! "PAR1", (page header, page)*, metadata, length of the metadata: 4 bytes, "PAR1"
//! ```
//!
//! Page headers and metadata are structures of Thrift's compact protocol (apache/thrift, doc/specs/thrift-compact-protocol.md; their
//! fields: apache/parquet-format, parquet.thrift). They are walked here without keeping anything: a list has no more elements, and a
//! string no more bytes, than bytes are left; a page is not larger than any writer makes it, and a dictionary has no more values than
//! bytes.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

use parquet::errors::Result;
use parquet::file::reader::{ChunkReader, Length};

/// No writer makes larger pages, bytes; mostly they have one million.
const LARGEST_PAGE: i64 = 1 << 28;
/// Groups of columns, which may lie in one another: no table has more, and who takes them apart goes into each.
const MOST_GROUPS: u32 = 1000;
/// Structures lie no deeper in one another.
const DEEPEST: usize = 32;
/// After the metadata.
const TAIL: u64 = 8;

/// A Parquet file whose lengths are checked.
#[derive(Debug)]
pub struct CheckedFile {
    file: File,
    /// Where its metadata begin; the pages are before.
    metadata: u64,
}

impl CheckedFile {
    /// Checks the metadata; page headers are checked when they are read.
    pub(super) fn new(mut file: File) -> io::Result<CheckedFile> {
        let end = file.seek(SeekFrom::End(0))?;
        let start_of_tail = end.checked_sub(TAIL).ok_or_else(|| damaged("it is too short"))?;
        file.seek(SeekFrom::Start(start_of_tail))?;
        let mut length = [0; 4];
        file.read_exact(&mut length)?;
        let length = u64::from(u32::from_le_bytes(length));
        let metadata =
            start_of_tail.checked_sub(length).ok_or_else(|| damaged("its metadata are longer than the file"))?;
        file.seek(SeekFrom::Start(metadata))?;
        check_metadata(&mut Walk { input: BufReader::new(&file), left: length })?;
        Ok(CheckedFile { file, metadata })
    }
}

impl Length for CheckedFile {
    fn len(&self) -> u64 {
        self.file.len()
    }
}

impl ChunkReader for CheckedFile {
    type T = FromPageHeader;

    fn get_read(&self, start: u64) -> Result<FromPageHeader> {
        let left = self.metadata.checked_sub(start);
        Ok(FromPageHeader { input: self.file.get_read(start)?, left })
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<bytes::Bytes> {
        self.file.get_bytes(start, length)
    }
}

/// Reads from a page header on, which is walked when its first byte is asked for: some readers are made and not used.
#[derive(Debug)]
pub struct FromPageHeader {
    input: BufReader<File>,
    /// Bytes left before the metadata, as long as the header is not checked; none where it begins after them.
    left: Option<u64>,
}

impl Read for FromPageHeader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Some(left) = self.left.take() {
            let mut walk = Walk { input: &mut self.input, left };
            check_page_header(&mut walk)?;
            let walked = i64::try_from(left - walk.left).map_err(io::Error::other)?;
            self.input.seek_relative(-walked)?;
        }
        self.input.read(buffer)
    }
}

fn check_metadata(walk: &mut Walk<impl Read>) -> io::Result<()> {
    let mut groups = 0;
    walk.structure(&mut Vec::new(), &mut |path, number| {
        // Of an element of the schema, how many it holds.
        groups += u32::from(path == [2, 5] && number > 0);
        if groups > MOST_GROUPS { Err(damaged("its columns lie in too many groups")) } else { Ok(()) }
    })
}

fn check_page_header(walk: &mut Walk<impl Read>) -> io::Result<()> {
    let (mut size, mut values) = (0, 0);
    walk.structure(&mut Vec::new(), &mut |path, number| {
        match path {
            // Uncompressed.
            [2] => size = number,
            // Of a dictionary.
            [7, 1] => values = number,
            _ => {}
        }
        Ok(())
    })?;
    match size <= LARGEST_PAGE && values <= size {
        true => Ok(()),
        false => Err(damaged("a page is larger than any")),
    }
}

fn damaged(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// Told the numbers of fields of a structure, with the identifiers of the fields in which they lie.
type See<'a> = dyn FnMut(&[i16], i64) -> io::Result<()> + 'a;

/// Bytes of Thrift's compact protocol.
struct Walk<R> {
    input: R,
    left: u64,
}

impl<R: Read> Walk<R> {
    fn byte(&mut self) -> io::Result<u8> {
        self.left = self.left.checked_sub(1).ok_or(io::ErrorKind::UnexpectedEof)?;
        let mut byte = [0];
        self.input.read_exact(&mut byte)?;
        Ok(byte[0])
    }

    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| damaged("a text is longer than what is left"))?;
        match io::copy(&mut (&mut self.input).take(bytes), &mut io::sink())? {
            skipped if skipped == bytes => Ok(()),
            _ => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }

    /// Seven bits a byte, the lowest first.
    fn unsigned(&mut self) -> io::Result<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(damaged("a number is too long"))
    }

    /// Whose lowest bit is the sign.
    fn signed(&mut self) -> io::Result<i64> {
        let number = self.unsigned()?;
        Ok((number >> 1) as i64 ^ -((number & 1) as i64))
    }

    /// Goes through a structure; `path` are the fields in which it lies.
    fn structure(&mut self, path: &mut Vec<i16>, see: &mut See<'_>) -> io::Result<()> {
        let mut field = 0_i16;
        loop {
            let head = self.byte()?;
            if head & 0x0F == 0 {
                return Ok(());
            }
            field = match head >> 4 {
                0 => self.signed()? as i16,
                more => field.wrapping_add(i16::from(more)),
            };
            path.push(field);
            // The truth of a truth value is its type.
            if !matches!(head & 0x0F, 1 | 2) {
                self.value(head & 0x0F, path, see)?;
            }
            path.pop();
        }
    }

    fn value(&mut self, kind: u8, path: &mut Vec<i16>, see: &mut See<'_>) -> io::Result<()> {
        match kind {
            1..=3 => self.skip(1),
            4..=6 => {
                let number = self.signed()?;
                see(path, number)
            }
            7 => self.skip(8),
            8 => {
                let length = self.unsigned()?;
                self.skip(length)
            }
            9 => self.list(path, see),
            12 if path.len() < DEEPEST => self.structure(path, see),
            _ => Err(damaged("a field is of no known type")),
        }
    }

    fn list(&mut self, path: &mut Vec<i16>, see: &mut See<'_>) -> io::Result<()> {
        let head = self.byte()?;
        let count = match head >> 4 {
            15 => self.unsigned()?,
            count => u64::from(count),
        };
        if count > self.left {
            return Err(damaged("a list is longer than what is left"));
        }
        let kind = head & 0x0F;
        match kind {
            9 => Err(damaged("a list holds lists")),
            _ => (0..count).try_for_each(|_| self.value(kind, path, see)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(bytes: &[u8]) -> Walk<&[u8]> {
        Walk { input: bytes, left: bytes.len() as u64 }
    }

    fn metadata(bytes: &[u8]) -> Result<(), String> {
        check_metadata(&mut walk(bytes)).map_err(|error| error.to_string())
    }

    fn page(bytes: &[u8]) -> Result<(), String> {
        check_page_header(&mut walk(bytes)).map_err(|error| error.to_string())
    }

    /// Field 1: 1; field 2: a list of one structure with field 5: 1; field 3: "ab"; end.
    const SMALL: [u8; 12] = [0x15, 2, 0x19, 0x1C, 0x55, 2, 0, 0x18, 2, b'a', b'b', 0];

    #[test]
    fn what_is_as_long_as_it_says_is_let_through() {
        assert_eq!(metadata(&SMALL), Ok(()));
        for cut in 0..SMALL.len() {
            assert!(metadata(&SMALL[..cut]).is_err(), "{cut}");
        }
    }

    #[test]
    fn no_list_and_no_text_is_longer_than_what_is_left() {
        let four_billion = [0xFF, 0xFF, 0xFF, 0xFF, 0x0F];
        let list = [&[0x29, 0xFC][..], &four_billion, &[0]].concat();
        assert_eq!(metadata(&list), Err("a list is longer than what is left".to_owned()));
        let text = [&[0x18][..], &four_billion, &[0]].concat();
        assert_eq!(metadata(&text), Err("a text is longer than what is left".to_owned()));
        assert_eq!(metadata(&[0x19, 0x19, 0x19, 0x19]), Err("a list holds lists".to_owned()));
        let deep = [0x1C].repeat(1000);
        assert_eq!(metadata(&deep), Err("a field is of no known type".to_owned()));
    }

    #[test]
    fn groups_lie_in_one_another_no_deeper_than_any_table_has() {
        let groups =
            |count: u8| [&[0x29, 0xFC, 0x80 | count, 0x08][..], &[0x55, 2, 0].repeat(1024 + count as usize)].concat();
        assert_eq!(metadata(&groups(0)), Err("its columns lie in too many groups".to_owned()));
    }

    #[test]
    fn no_page_and_no_dictionary_is_larger_than_any() {
        // Field 2: size; field 7: field 1: values.
        let header = |size: &[u8], values: &[u8]| [&[0x25], size, &[0x5C, 0x15], values, &[0, 0]].concat();
        assert_eq!(page(&header(&[20], &[20])), Ok(()));
        let too_large = Err("a page is larger than any".to_owned());
        assert_eq!(page(&header(&[20], &[22])), too_large);
        assert_eq!(page(&header(&[0xFE, 0xFF, 0xFF, 0xFF, 0x0F], &[20])), too_large);
    }
}
