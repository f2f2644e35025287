//! Tables as CSV files that [`Table`](crate::Table) reads back to the bit.

use std::path::Path;

use crate::write::{WriteError, write_atomically};

/// One cell of a table to be written.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A finite number; written with the fewest digits that give back the same `f64`.
    Number(f64),
    /// A text of one line, such as the label of a sweep. White space around it is lost in reading, and an empty text
    /// is read as an empty cell.
    Text(String),
    /// Nothing: a missing reading.
    Empty,
}

impl From<f64> for Cell {
    fn from(number: f64) -> Cell {
        Cell::Number(number)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Cell {
        number.map_or(Cell::Empty, Cell::Number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

/// Writes a table as a CSV file, in one step (see [`write_atomically`]).
///
/// First come the lines of `comment`, each after `# `, then the names of the columns, then the rows. Lines end with
/// a single line feed on every machine: equal tables are equal bytes.
///
/// # Errors
///
/// The table could not be read back (there are no columns, a name is empty or there twice, a row has more or fewer cells than there are
/// columns, a number is not finite, a text has a line break), or the file cannot be written.
pub fn write_table(path: &Path, comment: &[String], columns: &[String], rows: &[Vec<Cell>]) -> Result<(), WriteError> {
    write_atomically(path, &table_contents(path, comment, columns, rows)?)
}

/// The bytes that [`write_table`] writes; `path` is only the file's name in errors.
///
/// # Errors
///
/// As [`write_table`], but for the writing.
pub fn table_contents(
    path: &Path,
    comment: &[String],
    columns: &[String],
    rows: &[Vec<Cell>],
) -> Result<Vec<u8>, WriteError> {
    check_columns(path, columns)?;
    for (index, row) in rows.iter().enumerate() {
        check_row(path, columns, index + 1, row)?;
    }
    let csv = csv_lines(columns, rows).map_err(|cause| WriteError::Io { path: path.to_owned(), cause })?;
    let mut contents = comment_lines(comment).into_bytes();
    contents.extend(csv);
    Ok(contents)
}

pub(crate) fn check_columns(path: &Path, columns: &[String]) -> Result<(), WriteError> {
    if columns.is_empty() {
        return Err(WriteError::NoColumns { path: path.to_owned() });
    }
    for (index, column) in columns.iter().enumerate() {
        check_text(path, column)?;
        // Names are compared as they will be read, without the white space around them.
        let name = column.trim();
        if name.is_empty() || columns[..index].iter().any(|earlier| earlier.trim() == name) {
            return Err(WriteError::ColumnName { path: path.to_owned(), column: column.clone() });
        }
    }
    Ok(())
}

/// `number` is that of the row, counted from 1.
fn check_row(path: &Path, columns: &[String], number: usize, row: &[Cell]) -> Result<(), WriteError> {
    let (expected, found) = (columns.len(), row.len());
    if found != expected {
        return Err(WriteError::Ragged { path: path.to_owned(), row: number, expected, found });
    }
    for (cell, column) in row.iter().zip(columns) {
        match cell {
            Cell::Number(found) if !found.is_finite() => {
                let (path, column) = (path.to_owned(), column.clone());
                return Err(WriteError::NotFinite { path, row: number, column, found: *found });
            }
            Cell::Text(text) => check_text(path, text)?,
            Cell::Number(_) | Cell::Empty => {}
        }
    }
    Ok(())
}

pub(crate) fn check_text(path: &Path, text: &str) -> Result<(), WriteError> {
    if text.contains(['\n', '\r']) {
        return Err(WriteError::LineBreak { path: path.to_owned(), text: text.to_owned() });
    }
    Ok(())
}

fn comment_lines(comment: &[String]) -> String {
    let lines = comment.iter().flat_map(|entry| entry.split('\n'));
    lines.map(|line| format!("{}\n", format!("# {line}").trim_end())).collect()
}

fn csv_lines(columns: &[String], rows: &[Vec<Cell>]) -> std::io::Result<Vec<u8>> {
    // With the comment sign made known, a cell that begins with it is put in quotes.
    let mut writer = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(Vec::new());
    writer.write_record(columns)?;
    for row in rows {
        writer.write_record(row.iter().map(text_of))?;
    }
    writer.into_inner().map_err(|error| error.into_error())
}

fn text_of(cell: &Cell) -> String {
    match cell {
        // `{}` of an f64 is the shortest decimal number that is read back as the same f64.
        Cell::Number(number) => format!("{number}"),
        Cell::Text(text) => text.clone(),
        Cell::Empty => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;
    use crate::Table;
    use crate::csv_lines::CsvFormat;

    fn strings(texts: &[&str]) -> Vec<String> {
        texts.iter().map(|text| text.to_string()).collect()
    }

    fn contents(comment: &[&str], columns: &[&str], rows: &[Vec<Cell>]) -> Result<String, String> {
        let bytes = table_contents(Path::new("out.csv"), &strings(comment), &strings(columns), rows);
        bytes.map(|bytes| String::from_utf8(bytes).unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_bytes_are_as_documented() {
        let rows = [
            vec![Cell::from("a, b"), Cell::from(0.1), Cell::from(-0.0)],
            vec![Cell::from("#1".to_owned()), Cell::from(2075.0), Cell::from(None)],
            vec![Cell::Empty, Cell::from(Some(1e-7)), Cell::from(1e21)],
        ];
        let expected =
            "# two\n# lines\n#\nsweep,q,tau\n\"a, b\",0.1,-0\n\"#1\",2075,\n,0.0000001,1000000000000000000000\n";
        assert_eq!(contents(&["two\nlines", ""], &["sweep", "q", "tau"], &rows).unwrap(), expected);
    }

    #[test]
    fn a_table_is_written_to_disk_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        write_table(&path, &strings(&["note"]), &strings(&["q"]), &[vec![Cell::Number(0.1)]]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "# note\nq\n0.1\n");
        let table = Table::read(&path).unwrap();
        assert_eq!((table.line(0), table.number(0, 0).unwrap()), (3, Some(0.1)));
    }

    #[test]
    fn a_lone_empty_cell_is_a_row() {
        let text = contents(&[], &["q"], &[vec![Cell::Empty], vec![Cell::Number(1.0)]]).unwrap();
        let table = Table::parse(Path::new("out.csv"), text.as_bytes(), CsvFormat::default()).unwrap();
        assert_eq!((table.len(), table.number(0, 0).unwrap()), (2, None));
    }

    #[test]
    fn what_could_not_be_read_back_is_not_written() {
        let error =
            |columns: &[&str], row: Vec<Cell>| contents(&[], columns, &[vec![Cell::Empty; 2], row]).unwrap_err();
        let empty = || vec![Cell::Empty; 2];
        let start = "out.csv: the table cannot be written:";
        assert_eq!(error(&[], vec![]), format!("{start} it has no columns"));
        assert_eq!(error(&["a", " a"], empty()), format!("{start} column name ` a` is empty or used twice"));
        assert_eq!(error(&["a", ""], empty()), format!("{start} column name `` is empty or used twice"));
        assert_eq!(error(&["a", "b\nc"], empty()), format!("{start} \"b\\nc\" has a line break"));
        assert_eq!(error(&["a", "b"], vec![Cell::Empty]), format!("{start} row 2 has 1 cells, expected 2"));
        assert_eq!(
            error(&["a", "b"], vec![Cell::Empty, Cell::Number(f64::NAN)]),
            format!("{start} row 2, column `b` is NaN")
        );
        assert_eq!(
            error(&["a", "b"], vec![Cell::from("x\ry"), Cell::Empty]),
            format!("{start} \"x\\ry\" has a line break")
        );
    }

    #[test]
    fn an_error_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        fs::write(&path, "old").unwrap();
        let rows = [vec![Cell::Number(f64::INFINITY)]];
        assert!(write_table(&path, &[], &strings(&["q"]), &rows).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    }

    fn finite() -> impl Strategy<Value = f64> {
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |number| number.is_finite())
    }

    fn cell() -> impl Strategy<Value = Cell> {
        prop_oneof![finite().prop_map(Cell::Number), "[ -~é]{0,8}".prop_map(Cell::Text), Just(Cell::Empty)]
    }

    /// Whether a cell says what was written into it.
    fn says(table: &Table, row: usize, column: usize, cell: &Cell) -> bool {
        match cell {
            Cell::Number(number) => {
                let read = table.number(row, column).ok().flatten();
                read.map(f64::to_bits) == Some(number.to_bits())
            }
            Cell::Text(text) => table.text(row, column) == text.trim(),
            Cell::Empty => table.text(row, column).is_empty(),
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_to_the_bit(
            comment in proptest::collection::vec(any::<String>(), 0..3),
            rows in (1_usize..5).prop_flat_map(|columns| {
                proptest::collection::vec(proptest::collection::vec(cell(), columns), 1..8)
            }),
        ) {
            let path = Path::new("out.csv");
            let columns: Vec<String> = (1..=rows[0].len()).map(|column| format!("#\"{column}, é")).collect();
            let bytes = table_contents(path, &comment, &columns, &rows).unwrap();
            let table = Table::parse(path, &bytes, CsvFormat::default()).unwrap();
            prop_assert_eq!(table.columns(), columns.as_slice());
            prop_assert_eq!(table.len(), rows.len());
            for (row, cells) in rows.iter().enumerate() {
                for (column, cell) in cells.iter().enumerate() {
                    prop_assert!(says(&table, row, column, cell), "{:?}", cell);
                }
            }
        }
    }
}
