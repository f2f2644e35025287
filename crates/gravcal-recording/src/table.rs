//! A file as cells of text, each with its line.

use std::path::{Path, PathBuf};

use csv::StringRecord;

use crate::column_names::{column_names, columns_without_header};
use crate::csv_lines::{CsvFormat, CsvWriting, Line, Lines, cells, is_nan};
use crate::error::{Place, ReadError};
use crate::file::read_whole;
use crate::iso8601;
use crate::rows::missing::{Missing, NOT_FINITE, report_missing};
use crate::rows::stamp::Stamp;
use crate::rows::{self, Kind, Rows, kind, open};

/// The most bytes of a CSV file that are held in memory: some million poses. Recordings in motion are read row by row.
const LARGEST_TABLE: u64 = 1 << 30;

/// A table of text cells with named columns, as read from a file, mostly CSV.
///
/// A CSV file is UTF-8 text with commas, semicolons or tabs between the cells, as is found by its first lines or said; cells may be in
/// double quotes. Its first row names the columns, or is a row of numbers as the others: then they are `column1`, `column2`, …. Blank
/// lines and lines that begin with `#` are skipped. White space around a cell does not count.
/// A table has at least one column and one row, all names differ, and every row has a cell for every column.
#[derive(Clone, Debug)]
pub struct Table {
    path: PathBuf,
    columns: Vec<String>,
    rows: Vec<Row>,
    format: CsvFormat,
    /// Columns whose numbers are dates with times as seconds; none of CSV, where cells tell.
    dates: Vec<usize>,
    remarks: Vec<String>,
}

/// One row, and the line on which it stands.
#[derive(Clone, Debug)]
struct Row {
    line: u64,
    cells: StringRecord,
}

impl Table {
    /// Reads a file; recordings of other kinds than CSV, too, whose rows then are those of [`open`](crate::open).
    ///
    /// # Errors
    ///
    /// The file cannot be opened, is no UTF-8 text, has no header or no rows, has a column without a name or two
    /// columns of one name, or has a row with more or fewer cells than the header.
    pub fn read(path: &Path) -> Result<Table, ReadError> {
        Table::read_as(path, &CsvWriting::default())
    }

    /// The same of a CSV file that is said to be written so.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read).
    pub fn read_as(path: &Path, csv: &CsvWriting) -> Result<Table, ReadError> {
        match kind(path)? {
            Kind::Csv => {
                let bytes = read_whole(path, LARGEST_TABLE).map_err(|cause| ReadError::opening(path, cause))?;
                let format = CsvFormat::found(&mut Lines::new(path, &bytes[..]), csv)?;
                Table::parse_as(path, &bytes, format, csv)
            }
            Kind::Mcap | Kind::Sqlite | Kind::Folder | Kind::Parquet => Table::of_rows(path, open(path)?.as_mut()),
        }
    }

    /// All rows at once.
    pub(crate) fn of_rows(path: &Path, recording: &mut dyn Rows) -> Result<Table, ReadError> {
        // `{}` of an f64 is the shortest decimal number that is read back as the same f64.
        let text = |number: &f64| if number.is_finite() { number.to_string() } else { String::new() };
        let (mut row, mut rows) = (rows::Row::default(), Vec::new());
        while recording.read(&mut row)? {
            rows.push(Row { line: row.number, cells: row.cells.iter().map(text).collect() });
        }
        let columns = recording.columns().to_vec();
        // Columns that come midway are empty before.
        for row in &mut rows {
            (row.cells.len()..columns.len()).for_each(|_| row.cells.push_field(""));
        }
        check_rows(path, columns.len(), &rows)?;
        let dates = (0..columns.len()).filter(|column| recording.holds_dates(*column)).collect();
        let (format, remarks) = (CsvFormat::default(), recording.remarks());
        Ok(Table { path: path.to_owned(), columns, rows, format, dates, remarks })
    }

    /// Reads what a file holds; `path` is its name in errors.
    #[cfg(test)]
    pub(crate) fn parse(path: &Path, bytes: &[u8], format: CsvFormat) -> Result<Table, ReadError> {
        Table::parse_as(path, bytes, format, &CsvWriting::default())
    }

    fn parse_as(path: &Path, bytes: &[u8], format: CsvFormat, said: &CsvWriting) -> Result<Table, ReadError> {
        let (mut rows, before) = records(path, bytes, format.delimiter)?;
        let first = rows.first().ok_or_else(|| ReadError::NoHeader { path: path.to_owned() })?;
        let columns = match format.header {
            true => column_names(path, first.line, &first.cells)?,
            false => columns_without_header(path, (format, &before), first.cells.len(), said)?,
        };
        if format.header {
            rows.remove(0);
        }
        check_rows(path, columns.len(), &rows)?;
        let columns = with_stamps(columns, &mut rows, format);
        let remarks = report_missing(NOT_FINITE, missing(&columns, &rows).into_iter()).into_iter().collect();
        Ok(Table { path: path.to_owned(), columns, rows, format, dates: Vec::new(), remarks })
    }

    /// The file, as it was named to [`read`](Self::read).
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the columns, in the order of the file.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Number of rows, the header not counted.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no rows; never so in a table that was read.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// What was lost or looks wrong, in words; of a CSV file, of which no row is left out, cells that are NaN.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Place of the column with this name.
    ///
    /// # Errors
    ///
    /// There is none; the error lists those that there are.
    pub fn column(&self, name: &str) -> Result<usize, ReadError> {
        self.columns.iter().position(|column| column == name).ok_or_else(|| ReadError::UnknownColumn {
            path: self.path.clone(),
            column: name.to_owned(),
            columns: self.columns.clone(),
        })
    }

    /// Line in the file on which a row stands, counted from 1.
    ///
    /// # Panics
    ///
    /// If `row` is not less than [`len`](Self::len).
    pub fn line(&self, row: usize) -> u64 {
        self.rows[row].line
    }

    /// Text of a cell, without the white space around it.
    ///
    /// # Panics
    ///
    /// If there is no such row or column.
    pub fn text(&self, row: usize, column: usize) -> &str {
        self.rows[row].cells[column].trim()
    }

    /// Number in a cell, `None` if the cell is empty or NaN.
    ///
    /// # Errors
    ///
    /// The cell holds something else than a finite number: text, `inf`, a number beyond the range of `f64`.
    ///
    /// # Panics
    ///
    /// If there is no such row or column.
    pub fn number(&self, row: usize, column: usize) -> Result<Option<f64>, ReadError> {
        let text = self.text(row, column);
        if text.is_empty() || is_nan(text) {
            return Ok(None);
        }
        let number = self.format.number(text);
        let wrong = || ReadError::NotANumber { place: self.place(row, column), found: text.to_owned() };
        number.map(Some).ok_or_else(wrong)
    }

    /// The date with a time in a cell, as seconds since 1970-01-01 in UTC; `None` where it holds none.
    pub(crate) fn date(&self, row: usize, column: usize) -> Result<Option<f64>, ReadError> {
        match self.dates.contains(&column) {
            true => self.number(row, column),
            false => Ok(iso8601::seconds(self.text(row, column))),
        }
    }

    /// Names a cell in an error.
    ///
    /// # Panics
    ///
    /// If there is no such row or column.
    pub fn place(&self, row: usize, column: usize) -> Place {
        Place { path: self.path.clone(), line: self.line(row), column: self.columns[column].clone() }
    }
}

/// All lines with cells in them, the header among them, of any number of cells, and the comments before the first.
fn records(path: &Path, bytes: &[u8], delimiter: u8) -> Result<(Vec<Row>, Vec<Vec<u8>>), ReadError> {
    let mut lines = Lines::new(path, bytes);
    let (mut rows, mut before) = (Vec::new(), Vec::new());
    while let Some(Line { number: line, text }) = lines.read()? {
        let text = text.ok_or_else(|| ReadError::NotUtf8 { path: path.to_owned(), line })?;
        let mut found = StringRecord::new();
        if !cells(text, delimiter, &mut found) {
            return Err(ReadError::LineBreak { path: path.to_owned(), line });
        }
        rows.push(Row { line, cells: found });
        if rows.len() == 1 {
            before = lines.skipped().to_vec();
        }
    }
    Ok((rows, before))
}

/// The names of columns, and a column more where two are one time.
fn with_stamps(mut columns: Vec<String>, rows: &mut [Row], format: CsvFormat) -> Vec<String> {
    let Some(stamp) = Stamp::find(&columns) else { return columns };
    columns.push(Stamp::column());
    for row in rows {
        let numbers: Vec<f64> = row.cells.iter().map(|cell| format.number(cell.trim()).unwrap_or(f64::NAN)).collect();
        let time = stamp.time(&numbers);
        row.cells.push_field(&if time.is_nan() { String::new() } else { format.text(time) });
    }
    columns
}

/// How often each column is NaN.
fn missing<'a>(columns: &'a [String], rows: &[Row]) -> Vec<Missing<'a>> {
    let of_column = |(place, column): (usize, &'a String)| {
        let mut lines = rows.iter().filter(|row| is_nan(&row.cells[place])).map(|row| row.line);
        let first = lines.next();
        Missing { column, count: first.map_or(0, |_| 1 + lines.count() as u64), first }
    };
    columns.iter().enumerate().map(of_column).collect()
}

fn check_rows(path: &Path, expected: usize, rows: &[Row]) -> Result<(), ReadError> {
    if rows.is_empty() {
        return Err(ReadError::NoRows { path: path.to_owned() });
    }
    match rows.iter().find(|row| row.cells.len() != expected) {
        None => Ok(()),
        Some(row) => {
            let found = row.cells.len();
            Err(ReadError::Ragged { path: path.to_owned(), line: row.line, expected, found })
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;

    fn parse(text: impl AsRef<[u8]>) -> Result<Table, ReadError> {
        Table::parse(Path::new("poses.csv"), text.as_ref(), CsvFormat::default())
    }

    fn error(text: impl AsRef<[u8]>) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn cells_are_text_or_numbers() {
        let table = parse("q1, tau1 ,sweep\n1.5, -2e3 ,up\n+.5,,\"a, b\"\n").unwrap();
        assert_eq!(table.path(), Path::new("poses.csv"));
        assert_eq!(table.columns(), ["q1", "tau1", "sweep"]);
        assert_eq!(table.len(), 2);
        assert!(!table.is_empty());
        assert_eq!(table.column("tau1").unwrap(), 1);
        assert_eq!(table.number(0, 0).unwrap(), Some(1.5));
        assert_eq!(table.number(0, 1).unwrap(), Some(-2000.0));
        assert_eq!(table.number(1, 0).unwrap(), Some(0.5));
        assert_eq!(table.number(1, 1).unwrap(), None);
        assert_eq!(table.text(0, 2), "up");
        assert_eq!(table.text(1, 2), "a, b");
    }

    #[test]
    fn lines_are_those_of_the_file() {
        let text = "# made by hand\n\nq\n1\n# why not\n#\n\n2\n\n3";
        for text in [text.to_owned(), text.replace('\n', "\r\n"), format!("\u{feff}{text}")] {
            let table = parse(text).unwrap();
            let lines: Vec<u64> = (0..table.len()).map(|row| table.line(row)).collect();
            assert_eq!(lines, [4, 8, 10]);
            assert_eq!(table.columns(), ["q"]);
        }
    }

    #[test]
    fn a_quoted_sign_is_no_comment() {
        let table = parse("label\n\"#1\"\n\"#2\"\n").unwrap();
        assert_eq!((table.len(), table.text(0, 0), table.line(1)), (2, "#1", 3));
    }

    #[test]
    fn a_cell_that_is_no_finite_number_is_an_error() {
        for found in ["abc", "inf", "-infinity", "1e999", "1.5 N", "--"] {
            let table = parse(format!("q1,tau1\n# comment\n0,{found}\n")).unwrap();
            assert_eq!(
                table.number(0, 1).unwrap_err().to_string(),
                format!(
                    "poses.csv:3: column `tau1`: expected a finite number, found `{found}`; \
                     leave the cell empty if a reading is missing, and remove a row that gives units or is no reading"
                )
            );
        }
    }

    /// Robots log it for joints without a sensor.
    #[test]
    fn nan_is_an_empty_cell_that_is_counted() {
        let table = parse("q1,tau1,label\n# comment\n0,nan,a\n1,-NaN,b\n2,,c\n3,4,d\n").unwrap();
        let numbers: Vec<Option<f64>> = (0..4).map(|row| table.number(row, 1).unwrap()).collect();
        assert_eq!(numbers, [None, None, None, Some(4.0)]);
        let counted = "cells that are no finite numbers count as missing: 2 of `tau1`; the first is on line 3";
        assert_eq!(table.remarks(), [counted]);
        // Nor do numbers become names of columns where some are NaN.
        assert_eq!(read_as("1.5,nan\n3,4\n", &CsvWriting::default()).unwrap().columns().join(" "), "column1 column2");
    }

    #[test]
    fn an_unknown_column_lists_what_there_is() {
        let table = parse("q1_deg,tau_1,sweep\n0,0,a\n").unwrap();
        assert_eq!(
            table.column("tau1").unwrap_err().to_string(),
            "poses.csv: there is no column `tau1` (did you mean `tau_1`?); the columns are `q1_deg`, `tau_1`, `sweep`"
        );
        assert_eq!(
            table.column("temperature").unwrap_err().to_string(),
            "poses.csv: there is no column `temperature`; the columns are `q1_deg`, `tau_1`, `sweep`"
        );
    }

    /// As a file, so that how it is written is found or said.
    fn read_as(text: &str, said: &CsvWriting) -> Result<Table, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.csv");
        fs::write(&path, text).unwrap();
        Table::read_as(&path, said)
    }

    #[test]
    fn how_a_file_is_written_is_found_or_said() {
        let found = &CsvWriting::default();
        let numbers = |text: &str, said: &CsvWriting| {
            let table = read_as(text, said).unwrap();
            let row = (0..table.columns().len()).map(|column| table.number(0, column).unwrap());
            (table.columns().join(" "), table.line(0), row.collect::<Vec<_>>())
        };
        for text in ["q;tau\n1,5;2\n", "q\ttau\n1.5\t2\n", "q,tau\n1.5,2\n"] {
            assert_eq!(numbers(text, found), ("q tau".to_owned(), 2, vec![Some(1.5), Some(2.0)]));
        }
        let headless = numbers("1.5;2\n3;4\n", found);
        assert_eq!(headless, ("column1 column2".to_owned(), 1, vec![Some(1.5), Some(2.0)]));
        // Names that are numbers, and rows of whole numbers that a comma parts or not.
        let named = CsvWriting { header: Some(true), ..found.clone() };
        assert_eq!(numbers("1;2\n3;4\n", &named), ("1 2".to_owned(), 2, vec![Some(3.0), Some(4.0)]));
        let bars = CsvWriting { delimiter: Some(b'|'), decimal_comma: Some(true), header: Some(false), columns: None };
        assert_eq!(numbers("1,5|2\n", &bars), ("column1 column2".to_owned(), 1, vec![Some(1.5), Some(2.0)]));
        let point = CsvWriting { decimal_comma: Some(false), ..found.clone() };
        let error = read_as("q;tau\n1,5;2\n", &point).unwrap().number(0, 0).unwrap_err().to_string();
        assert!(error.contains("expected a finite number, found `1,5`"), "{error}");
    }

    #[test]
    fn columns_of_files_without_a_header_may_be_named() {
        let said = CsvWriting { columns: Some(vec!["q".to_owned(), "tau".to_owned()]), ..CsvWriting::default() };
        let columns = |text: &str| read_as(text, &said).map(|table| table.columns().join(" "));
        assert_eq!(columns("1.5,2\n3,4\n").unwrap(), "q tau");
        assert_eq!(columns("a,b\n3,4\n").unwrap(), "a b", "a header has its own names");
        let error = columns("1,2,3\n4,5,6\n").unwrap_err().to_string();
        let reported =
            "its rows have 3 cells, and 2 columns are named for files without a header: `q`, `tau`; name as many";
        assert!(error.ends_with(reported), "{error}");
    }

    #[test]
    fn another_separator_is_recognised() {
        let table = parse("q1;tau1\n0;0\n").unwrap();
        assert_eq!(
            table.column("q1").unwrap_err().to_string(),
            "poses.csv: there is no column `q1` (cells must be separated by commas); the columns are `q1;tau1`"
        );
    }

    #[test]
    fn spaces_between_cells_and_columns_without_names_are_recognised() {
        let error = parse("q1 tau1\n0 0\n").unwrap().column("q1").unwrap_err().to_string();
        assert!(error.contains("not by spaces: write the table so (numpy: np.savetxt(…, delimiter=\",\"))"), "{error}");
        let headless = read_as("1.5,2\n3,4\n", &CsvWriting::default()).unwrap();
        let error = headless.column("q1").unwrap_err().to_string();
        assert!(
            error.contains("(the file has no header: name its columns in the session, [readings.csv] columns"),
            "{error}"
        );
    }

    #[test]
    fn a_header_in_a_comment_is_recognised() {
        let hint = "(if this row holds readings, add a header line before it, one that does not begin with #)";
        let table = parse("# q1,tau1\n0.5,2.25\n0.75,2.5\n").unwrap();
        assert_eq!(
            table.column("q1").unwrap_err().to_string(),
            format!("poses.csv: there is no column `q1` {hint}; the columns are `0.5`, `2.25`")
        );
        assert_eq!(
            error("# q1,tau1\n0,0\n"),
            format!("poses.csv:2: the header names column `0` twice; rename one {hint}")
        );
    }

    #[test]
    fn headers_must_name_every_column_once() {
        assert_eq!(error("# c\nq1,tau1,q1\n0,0,0\n"), "poses.csv:2: the header names column `q1` twice; rename one");
        assert_eq!(error("q1,q2,\n0,0,\n"), "poses.csv:1: column 3 of the header has no name; name it or delete it");
    }

    #[test]
    fn files_without_header_or_rows_are_errors() {
        for text in ["", "\n\n", "# nothing\n", "\u{feff}"] {
            assert_eq!(error(text), "poses.csv: the file is empty; its first line must name the columns");
        }
        for text in ["q1,tau1", "q1,tau1\n", "q1,tau1\n# nothing\n\n"] {
            assert_eq!(error(text), "poses.csv: the file has a header but no rows");
        }
    }

    #[test]
    fn ragged_rows_are_errors() {
        assert_eq!(error("a,b\n1,2\n\n1,2,3\n"), "poses.csv:4: expected 2 cells, as in the header, found 3");
        assert_eq!(error("a,b\n1,2\n1\n"), "poses.csv:3: expected 2 cells, as in the header, found 1");
    }

    #[test]
    fn an_open_quote_swallows_no_rows() {
        assert_eq!(
            error("q,label\n1,a\n2,\"b\n3,c\n4,d\n"),
            "poses.csv:3: a cell that begins here goes on over the end of the line; is a quote (\") not closed?"
        );
    }

    #[test]
    fn other_encodings_are_errors() {
        assert_eq!(
            error(b"q,label\n1,a\n2,\xe4\n"),
            "poses.csv:3: this is not UTF-8 text; save the table as CSV in UTF-8"
        );
    }

    #[test]
    fn files_that_cannot_be_opened_are_distinguished() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| Table::read(path).unwrap_err().to_string();

        let path = folder.path().join("absent.csv");
        assert_eq!(message(&path), format!("{}: there is no such file", path.display()));
        assert_eq!(message(Path::new("absent.csv")), "absent.csv: there is no such file");

        let absent = folder.path().join("absent");
        let path = absent.join("poses.csv");
        assert_eq!(message(&path), format!("{}: there is no such folder as {}", path.display(), absent.display()));

        // A folder may be one of rosbag2.
        assert!(message(folder.path()).starts_with(&folder.path().display().to_string()));

        // A file where a folder should be: whatever the operating system calls it, the path is named.
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(message(&file.join("poses.csv")).starts_with(&file.display().to_string()));
    }

    #[test]
    fn a_file_is_read_from_disk() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.csv");
        fs::write(&path, "q\n1\n").unwrap();
        let table = Table::read(&path).unwrap();
        assert_eq!((table.path(), table.number(0, 0).unwrap()), (path.as_path(), Some(1.0)));
    }

    /// Touches every cell, as a reader of the table would.
    fn exercise(bytes: &[u8]) {
        let Ok(table) = parse(bytes) else { return };
        for row in 0..table.len() {
            for column in 0..table.columns().len() {
                let _ = table.number(row, column).map_err(|error| error.to_string());
            }
        }
        let _ = table.column("tau1").map_err(|error| error.to_string());
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_do_not_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            exercise(&bytes);
        }

        /// Random bytes are seldom nearly a table; these are.
        #[test]
        fn almost_tables_do_not_panic(text in "[q1,\"#\n\r \u{feff}é.e-]{0,60}") {
            exercise(text.as_bytes());
        }

        #[test]
        fn lines_agree_with_a_naive_count(text in "(#[a-z,]{0,4}\n|\n|[a-z]{1,4}\n){0,30}") {
            let content = |line: &&str| !line.is_empty() && !line.starts_with('#');
            let naive = text.lines().zip(1..).filter(|(line, _)| content(line)).skip(1);
            let naive: Vec<(String, u64)> = naive.map(|(line, number)| (line.to_owned(), number)).collect();
            let Ok(table) = parse(&text) else {
                prop_assert!(naive.is_empty());
                return Ok(());
            };
            let found: Vec<(String, u64)> =
                (0..table.len()).map(|row| (table.text(row, 0).to_owned(), table.line(row))).collect();
            prop_assert_eq!(found, naive);
        }
    }
}
