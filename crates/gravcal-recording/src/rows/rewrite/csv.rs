//! CSV: the text of every cell that is not changed stays, comments stay where they are.

use std::io::{self, Write};

use super::{Change, Paced, RewriteError, Rewriting, Watch, same};
use crate::rows::csv::CsvRows;
use crate::rows::{Row, Rows};
use crate::write::{NewFile, WriteError};

pub(super) fn rewrite(
    what: &Rewriting<'_>,
    change: &mut Change<'_>,
    watch: &mut Watch<'_>,
) -> Result<Vec<String>, RewriteError> {
    let Rewriting { input, output, overwrite, notes, csv } = *what;
    let mut rows = CsvRows::open(input, csv)?;
    let mut new = NewFile::create(output, overwrite)?;
    let mut paced = Paced { watch, rows: 0 };
    let io = |cause: io::Error| WriteError::Io { path: output.to_owned(), cause };
    for (key, value) in notes {
        writeln!(new, "# {key} = {value}").map_err(io)?;
    }
    rows.write_heading(&mut new).map_err(io)?;
    let columns = rows.columns().to_vec();
    let mut row = Row::default();
    while rows.read(&mut row)? {
        let before = row.cells.clone();
        change(&columns, &mut row.cells);
        let changed: Vec<Option<f64>> =
            row.cells.iter().zip(&before).map(|(after, before)| (!same(*after, *before)).then_some(*after)).collect();
        rows.write_row(&mut new, &changed).map_err(io)?;
        paced.row(|| rows.progress())?;
    }
    rows.write_rest(&mut new).map_err(io)?;
    new.finish()?;
    Ok(rows.remarks())
}
