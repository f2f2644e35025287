//! The lines of a CSV file as cells, one at a time.

use std::collections::HashSet;
use std::io::{self, BufRead};
use std::path::{Path, PathBuf};

use csv::StringRecord;

use crate::error::ReadError;
use crate::iso8601;

/// No row is longer, bytes: what is, is no CSV file.
const LONGEST_LINE: usize = 1 << 20;

/// What is said of how CSV files are written; what is not said is found in each file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CsvWriting {
    /// What stands between cells, an ASCII sign.
    pub delimiter: Option<u8>,
    /// Whether numbers have a comma before their decimals, and not a point.
    pub decimal_comma: Option<bool>,
    /// Whether the first line names the columns. Without it they are `column1`, `column2`, …
    pub header: Option<bool>,
    /// Names of the columns of files without a header, all different; those with one have its names.
    pub columns: Option<Vec<String>>,
}

/// How a CSV file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CsvFormat {
    /// What stands between cells.
    pub delimiter: u8,
    /// Whether numbers have a comma before their decimals, and not a point.
    pub decimal_comma: bool,
    /// Whether the first line names the columns. Without it they are `column1`, `column2`, …
    pub header: bool,
}

impl Default for CsvFormat {
    /// Commas between cells, decimal points, a header.
    fn default() -> CsvFormat {
        CsvFormat { delimiter: b',', decimal_comma: false, header: true }
    }
}

/// Lines that tell how a file is written.
const SAMPLE: usize = 20;

impl CsvFormat {
    /// How a file is written, by what is said and its first lines.
    pub(crate) fn found<R: BufRead>(lines: &mut Lines<R>, said: &CsvWriting) -> Result<CsvFormat, ReadError> {
        let mut sample = Vec::new();
        while sample.len() < SAMPLE
            && let Some(line) = lines.read()?
        {
            sample.extend(line.text.map(str::to_owned));
        }
        Ok(CsvFormat::of_sample(&sample, said))
    }

    fn of_sample(sample: &[String], said: &CsvWriting) -> CsvFormat {
        let Some((header, rows)) = sample.split_first() else { return CsvFormat::default() };
        let count = |sign: u8| header.bytes().filter(|byte| *byte == sign).count();
        // Decimal commas may outnumber semicolons, but nothing else has semicolons or tabs.
        let found = || [b';', b'\t'].into_iter().find(|sign| count(*sign) > 0).unwrap_or(b',');
        let delimiter = said.delimiter.unwrap_or_else(found);
        let cells_of = |line: &String| -> Vec<String> {
            let mut found = StringRecord::new();
            cells(line, delimiter, &mut found);
            found.iter().map(|cell| cell.trim().to_owned()).filter(|cell| !cell.is_empty() && !is_nan(cell)).collect()
        };
        let comma = CsvFormat { delimiter, decimal_comma: true, header: true };
        let numbers: Vec<String> =
            sample.iter().flat_map(cells_of).filter(|cell| comma.number(cell).is_some()).collect();
        let found = delimiter != b','
            && numbers.iter().any(|cell| cell.contains(','))
            && !numbers.iter().any(|cell| cell.contains('.'));
        let format = CsvFormat { decimal_comma: said.decimal_comma.unwrap_or(found), ..comma };
        let is_numbers = |line: &String| {
            let cells = cells_of(line);
            !cells.is_empty()
                && cells.iter().all(|cell| format.number(cell).is_some() || iso8601::seconds(cell).is_some())
        };
        // A single line of numbers may be the names of columns that nothing follows.
        let found = || !(is_numbers(header) && rows.iter().all(is_numbers));
        CsvFormat { header: said.header.unwrap_or_else(found), ..format }
    }

    /// The names of columns that stand in a comment right before the first row, as numpy's `savetxt` writes them: as many cells as the row
    /// has, none of them a number and no two the same. `before`: the lines between the first row and what is before it.
    pub(crate) fn commented_header(self, before: &[Vec<u8>], cells_of_row: usize) -> Option<StringRecord> {
        let comment = std::str::from_utf8(before.last()?).ok()?.trim().strip_prefix('#')?;
        let mut found = StringRecord::new();
        if cells_of_row < 2 || !cells(comment, self.delimiter, &mut found) || found.len() != cells_of_row {
            return None;
        }
        let names: HashSet<&str> = found.iter().map(str::trim).collect();
        let is_name = |cell: &&str| !cell.is_empty() && self.number(cell).is_none() && !is_nan(cell);
        (names.len() == cells_of_row && names.iter().all(is_name)).then(|| found.iter().map(str::trim).collect())
    }

    /// A number as a cell says it.
    pub(crate) fn text(self, number: f64) -> String {
        // `{}` of an f64 is the shortest decimal number that is read back as the same f64.
        let text = number.to_string();
        if self.decimal_comma { text.replace('.', ",") } else { text }
    }

    /// The number in a cell, if it is a finite one.
    pub(crate) fn number(self, text: &str) -> Option<f64> {
        let number = match self.decimal_comma && text.contains(',') {
            true => text.replace(',', ".").parse::<f64>(),
            false => text.parse::<f64>(),
        };
        number.ok().filter(|number| number.is_finite())
    }
}

/// Whether a cell says NaN, in capitals or not.
pub(crate) fn is_nan(text: &str) -> bool {
    text.trim().parse::<f64>().is_ok_and(f64::is_nan)
}

/// Reads lines; blank ones and comments, which begin with `#`, are passed over.
pub(crate) struct Lines<R> {
    path: PathBuf,
    input: R,
    line: Vec<u8>,
    number: u64,
    /// The lines that were passed over before the last one with cells.
    skipped: Vec<Vec<u8>>,
}

/// A line with its number in the file, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line<'a> {
    pub(crate) number: u64,
    /// Its text, if it is UTF-8.
    pub(crate) text: Option<&'a str>,
}

impl<R: BufRead> Lines<R> {
    /// `path` is the file's name in errors.
    pub(crate) fn new(path: &Path, input: R) -> Lines<R> {
        Lines { path: path.to_owned(), input, line: Vec::new(), number: 0, skipped: Vec::new() }
    }

    /// The comments and blank lines between the last two lines with cells, or before the first.
    pub(crate) fn skipped(&self) -> &[Vec<u8>] {
        &self.skipped
    }

    /// What the lines are read from.
    pub(crate) fn input(&self) -> &R {
        &self.input
    }

    /// The next line with cells in it; `None` at the end.
    pub(crate) fn read(&mut self) -> Result<Option<Line<'_>>, ReadError> {
        self.skipped.clear();
        loop {
            let first = self.number == 0;
            if !self.read_line()? {
                return Ok(None);
            }
            if first && self.line.starts_with("\u{feff}".as_bytes()) {
                self.line.drain(..3);
            }
            if !matches!(self.line.first(), None | Some(b'#')) {
                break;
            }
            self.skipped.push(self.line.clone());
        }
        Ok(self.present())
    }

    /// The line that was read last; `None` before the first.
    pub(crate) fn present(&self) -> Option<Line<'_>> {
        (self.number > 0).then(|| Line { number: self.number, text: std::str::from_utf8(&self.line).ok() })
    }

    /// Reads up to the next line break, which may be `\n`, `\r\n` or `\r`; false at the end of the file.
    fn read_line(&mut self) -> Result<bool, ReadError> {
        self.line.clear();
        let io = |path: &Path, cause: io::Error| ReadError::Io { path: path.to_owned(), cause };
        loop {
            let bytes = match self.input.fill_buf() {
                Ok(bytes) => bytes,
                Err(cause) if cause.kind() == io::ErrorKind::Interrupted => continue,
                Err(cause) => return Err(io(&self.path, cause)),
            };
            if bytes.is_empty() {
                self.number += u64::from(!self.line.is_empty());
                return Ok(!self.line.is_empty());
            }
            let end = memchr::memchr2(b'\n', b'\r', bytes);
            let text = &bytes[..end.unwrap_or(bytes.len())];
            if self.line.len() + text.len() > LONGEST_LINE {
                return Err(ReadError::LongLine { path: self.path.clone(), line: self.number + 1, most: LONGEST_LINE });
            }
            self.line.extend_from_slice(text);
            let Some(end) = end else {
                let read = bytes.len();
                self.input.consume(read);
                continue;
            };
            let is_return = bytes[end] == b'\r';
            self.input.consume(end + 1);
            self.number += 1;
            if is_return && self.input.fill_buf().map_err(|cause| io(&self.path, cause))?.first() == Some(&b'\n') {
                self.input.consume(1);
            }
            return Ok(true);
        }
    }
}

/// Takes a line apart; false if a quoted cell does not end on it.
pub(crate) fn cells(text: &str, delimiter: u8, cells: &mut StringRecord) -> bool {
    cells.clear();
    if !text.contains('"') {
        text.split(char::from(delimiter)).for_each(|cell| cells.push_field(cell));
        return true;
    }
    // A cell that is not closed goes on over the end of the line, and has it in it.
    let line = [text.as_bytes(), b"\n"].concat();
    let mut reader = csv::ReaderBuilder::new();
    let mut reader = reader.has_headers(false).flexible(true).delimiter(delimiter).from_reader(&line[..]);
    matches!(reader.read_record(cells), Ok(true)) && !cells.iter().any(|cell| cell.contains('\n'))
}
