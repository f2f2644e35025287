//! A CSV file as rows, read line by line.
//!
//! How it is written is found: what stands between cells is the sign (comma, semicolon or tab) that the first line has
//! most of; numbers have a decimal comma where cells with one in the first rows are numbers, and none has a point; there is no
//! header where every cell of the first line is a number, or a date with a time, unless a comment right before it has as many names. A
//! column of such dates is one of seconds. Two columns that are one time (`sec` and `nanosec`) make another, `time_s`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use csv::StringRecord;

use super::missing::{Missing, NO_DATES, NOT_FINITE, report_missing};
use super::stamp::Stamp;
use super::{Row, Rows, Source};
use crate::column_names::{FIRST_COLUMN, column_names, columns_without_header};
use crate::csv_lines::{CsvFormat, CsvWriting, Line, Lines, cells, is_nan};
use crate::error::ReadError;
use crate::file::opened;
use crate::iso8601;

/// Rows of a CSV file.
pub(crate) struct CsvRows {
    path: PathBuf,
    format: CsvFormat,
    /// Whether it is said, or some line told, what stands before decimals.
    decimals_known: bool,
    lines: Lines<Counted>,
    length: u64,
    columns: Vec<String>,
    /// Texts of the present line, and what stood before it.
    cells: StringRecord,
    skipped: Vec<Vec<u8>>,
    /// The header, and what stands before it.
    header: StringRecord,
    comments: Vec<Vec<u8>>,
    /// The first row, which is read ahead.
    first: Option<Row>,
    /// What each column of the file holds.
    held: Vec<Held>,
    /// Two columns that are one time, which is a column more than the file has.
    stamp: Option<Stamp>,
    /// Whether the names of columns stand in a comment.
    commented: bool,
    /// Lines that are left out by reason, and the first of each.
    left_out: BTreeMap<&'static str, (u64, u64)>,
    /// Line and number of cells of the first row with more or fewer cells than the header.
    first_ragged: Option<(u64, usize)>,
}

/// What a column holds.
#[derive(Clone, Copy, Default)]
struct Held {
    /// Whether these are dates with times, as its first cell tells that is one or a number.
    dates: Option<bool>,
    /// How many cells are neither empty nor what it holds, and the line with the first.
    others: u64,
    first_other: u64,
    /// How many of them are not NaN either.
    texts: u64,
}

impl Held {
    /// The number that a cell says, dates in seconds; NaN where it says none.
    fn take(&mut self, text: &str, line: u64, format: CsvFormat) -> f64 {
        let text = text.trim();
        let number = match self.dates {
            Some(false) => format.number(text),
            Some(true) => iso8601::seconds(text),
            None => {
                let (number, date) = (format.number(text), iso8601::seconds(text));
                self.dates = number.or(date).map(|_| number.is_none());
                number.or(date)
            }
        };
        if number.is_none() && !text.is_empty() {
            self.first_other = if self.others == 0 { line } else { self.first_other };
            self.others += 1;
            self.texts += u64::from(!is_nan(text));
        }
        number.unwrap_or(f64::NAN)
    }

    /// What it holds; a column of nothing but NaN is that of a number that was never read.
    fn kind(&self) -> Option<bool> {
        self.dates.or((self.texts == 0).then_some(false))
    }

    /// What counts as missing in it.
    fn missing<'a>(&self, column: &'a str) -> Missing<'a> {
        Missing { column, count: self.others, first: Some(self.first_other) }
    }
}

/// Which cells count as missing, in words, in columns that hold numbers, dates, or neither.
const MISSING: [(Option<bool>, &str); 3] = [
    (Some(false), NOT_FINITE),
    (Some(true), NO_DATES),
    (None, "cells that are neither finite numbers nor dates with times such as 2024-05-01T12:00:00.010Z (ISO 8601)"),
];

/// Counts the bytes that are read.
pub(crate) struct Counted {
    input: BufReader<File>,
    read: u64,
}

impl std::io::Read for Counted {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.read += read as u64;
        Ok(read)
    }
}

impl BufRead for Counted {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        self.input.fill_buf()
    }

    fn consume(&mut self, bytes: usize) {
        self.read += bytes as u64;
        self.input.consume(bytes);
    }
}

impl CsvRows {
    /// Opens a file.
    pub(crate) fn open(path: &Path, said: &CsvWriting) -> Result<CsvRows, ReadError> {
        let format = found_format(path, said)?;
        let (mut lines, length) = open_lines(path)?;
        let mut header = StringRecord::new();
        let line = read_header(path, &mut lines, format.delimiter, &mut header)?;
        let columns = match format.header {
            true => column_names(path, line, &header)?,
            false => columns_without_header(path, (format, lines.skipped()), header.len(), said)?,
        };
        let commented =
            !format.header && said.columns.is_none() && columns.first().is_some_and(|name| name != FIRST_COLUMN);
        let held = vec![Held::default(); columns.len()];
        let stamp = Stamp::find(&columns);
        let columns = columns.into_iter().chain(stamp.map(|_| Stamp::column())).collect();
        let (comments, skipped) = (lines.skipped().to_vec(), Vec::new());
        let (path, left_out, cells) = (path.to_owned(), BTreeMap::new(), header.clone());
        let mut rows = CsvRows {
            path,
            format,
            decimals_known: said.decimal_comma.is_some() || format.delimiter == b',' || format.decimal_comma,
            lines,
            length,
            columns,
            cells,
            skipped,
            header,
            comments,
            first: None,
            held,
            stamp,
            commented,
            left_out,
            first_ragged: None,
        };
        let mut row = Row { number: line, cells: Vec::new() };
        if !format.header {
            rows.take_cells(&mut row);
        } else if !rows.next(&mut row)? {
            return Err(rows.without_rows());
        }
        rows.first = Some(row);
        Ok(rows)
    }

    /// Writes what stands before the first row.
    pub(crate) fn write_heading(&self, new: &mut impl Write) -> io::Result<()> {
        write_lines(new, &self.comments)?;
        if self.format.header {
            self.write_cells(new, self.header.iter())?;
        }
        Ok(())
    }

    /// Writes the row that was read last, and what stands before it; some of its cells are changed, and empty where they become NaN.
    pub(crate) fn write_row(&self, new: &mut impl Write, changed: &[Option<f64>]) -> io::Result<()> {
        write_lines(new, &self.skipped)?;
        let texts = self.cells.iter().zip(changed).map(|(text, changed)| match changed {
            None => Cow::Borrowed(text),
            Some(number) if number.is_nan() => Cow::Borrowed(""),
            Some(number) => Cow::Owned(self.format.text(*number)),
        });
        self.write_cells(new, texts)
    }

    /// Writes what stands after the last row, once there is no other.
    pub(crate) fn write_rest(&self, new: &mut impl Write) -> io::Result<()> {
        write_lines(new, &self.skipped)
    }

    fn write_cells(&self, new: &mut impl Write, cells: impl Iterator<Item = impl AsRef<str>>) -> io::Result<()> {
        let mut line = csv::WriterBuilder::new();
        let mut line = line.delimiter(self.format.delimiter).comment(Some(b'#')).from_writer(Vec::new());
        line.write_record(cells.map(|cell| cell.as_ref().as_bytes().to_vec()))?;
        new.write_all(&line.into_inner().map_err(|error| error.into_error())?)
    }

    /// Why there is no row: none stands there, or none has as many cells as the header.
    fn without_rows(self) -> ReadError {
        match self.first_ragged {
            None => ReadError::NoRows { path: self.path },
            Some((line, found)) => ReadError::Ragged { path: self.path, line, expected: self.held.len(), found },
        }
    }

    /// The next row, which is not one that was kept.
    fn next(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        self.skipped.clear();
        loop {
            let found = self.lines.read()?.is_some();
            self.skipped.extend_from_slice(self.lines.skipped());
            let Some(Line { number, text }) = self.lines.present().filter(|_| found) else { return Ok(false) };
            let why = match text {
                None => "no UTF-8 text",
                Some(text) if !cells(text, self.format.delimiter, &mut self.cells) => "a quote is not closed",
                Some(_) if self.cells.len() != self.held.len() => {
                    self.first_ragged.get_or_insert((number, self.cells.len()));
                    "more or fewer cells than columns"
                }
                Some(_) => {
                    row.number = number;
                    self.take_cells(row);
                    return Ok(true);
                }
            };
            self.left_out.entry(why).or_insert((0, number)).0 += 1;
        }
    }

    /// Looks for the first number with decimals where no line so far told whether these stand behind a point or a comma.
    fn look_for_decimals(&mut self) {
        let comma = CsvFormat { decimal_comma: true, ..self.format };
        let with_decimals = |cell: &&str| {
            cell.contains([',', '.']) && comma.number(cell.trim()).is_some() && !may_have_thousands(cell.trim())
        };
        if let Some(first) = self.cells.iter().find(with_decimals) {
            self.format.decimal_comma = first.contains(',');
            self.decimals_known = true;
        }
    }

    /// The cells of the present line as numbers.
    fn take_cells(&mut self, row: &mut Row) {
        if !self.decimals_known {
            self.look_for_decimals();
        }
        row.cells.clear();
        for (text, held) in self.cells.iter().zip(&mut self.held) {
            row.cells.push(held.take(text, row.number, self.format));
        }
        row.cells.extend(self.stamp.map(|stamp| stamp.time(&row.cells)));
    }
}

impl Rows for CsvRows {
    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn read(&mut self, row: &mut Row) -> Result<bool, ReadError> {
        match self.first.take() {
            Some(first) => {
                *row = first;
                Ok(true)
            }
            None => self.next(row),
        }
    }

    fn holds_dates(&self, column: usize) -> bool {
        self.held.get(column).is_some_and(|held| held.dates == Some(true))
    }

    fn source(&self) -> Source {
        let delimiter = match self.format.delimiter {
            b',' => "commas",
            b';' => "semicolons",
            b'|' => "bars",
            _ => "tabs",
        };
        let decimal = if self.format.decimal_comma { ", decimal commas" } else { "" };
        let header = match (self.format.header, self.commented) {
            (true, _) => "",
            (false, true) => ", header in a comment",
            (false, false) => ", no header",
        };
        Source { kind: format!("CSV file ({delimiter} between cells{decimal}{header})"), topics: Vec::new() }
    }

    fn remarks(&self) -> Vec<String> {
        let left_out = self.left_out.iter().map(|(why, (count, first))| {
            let path = self.path.display();
            match count {
                1 => format!("{path}: line {first} is left out ({why})"),
                _ => format!("{path}: {count} lines are left out ({why}), the first is line {first}"),
            }
        });
        let others = MISSING.iter().filter_map(|(dates, which)| {
            let columns = self.columns.iter().zip(&self.held).filter(|(_, held)| held.kind() == *dates);
            report_missing(which, columns.map(|(column, held)| held.missing(column)))
        });
        left_out.chain(others).collect()
    }

    fn metadata(&self) -> BTreeMap<String, String> {
        let comments = self.comments.iter().filter_map(|line| std::str::from_utf8(line).ok()?.strip_prefix('#'));
        let pairs = comments.filter_map(|comment| comment.split_once(" = "));
        pairs.map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned())).collect()
    }

    fn progress(&self) -> f64 {
        self.lines.input().read as f64 / self.length.max(1) as f64
    }
}

fn write_lines(new: &mut impl Write, lines: &[Vec<u8>]) -> io::Result<()> {
    lines.iter().try_for_each(|line| {
        new.write_all(line)?;
        new.write_all(b"\n")
    })
}

fn open_lines(path: &Path) -> Result<(Lines<Counted>, u64), ReadError> {
    let file = opened(path).map_err(|cause| ReadError::opening(path, cause))?;
    let length = file.metadata().map_err(|cause| ReadError::opening(path, cause))?.len();
    let input = BufReader::with_capacity(1 << 16, file);
    Ok((Lines::new(path, Counted { input, read: 0 }), length))
}

/// The cells of the first line, and its number.
fn read_header(
    path: &Path,
    lines: &mut Lines<Counted>,
    delimiter: u8,
    header: &mut StringRecord,
) -> Result<u64, ReadError> {
    let first = lines.read()?.ok_or_else(|| ReadError::NoHeader { path: path.to_owned() })?;
    let line = first.number;
    let text = first.text.ok_or_else(|| ReadError::NotUtf8 { path: path.to_owned(), line })?;
    match cells(text, delimiter, header) {
        true => Ok(line),
        false => Err(ReadError::LineBreak { path: path.to_owned(), line }),
    }
}

/// How a file is written, by its first lines.
/// Whether a comma in a number may stand between thousands, as in `1,000`.
fn may_have_thousands(cell: &str) -> bool {
    let mut parts = cell.trim_start_matches(['+', '-']).split(',');
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let first = parts.next().is_some_and(|first| digits(first) && first.len() <= 3 && first != "0");
    let mut rest = parts.peekable();
    first && rest.peek().is_some() && rest.all(|part| digits(part) && part.len() == 3)
}

fn found_format(path: &Path, said: &CsvWriting) -> Result<CsvFormat, ReadError> {
    CsvFormat::found(&mut open_lines(path)?.0, said)
}
