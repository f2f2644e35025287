//! What is in a recording, before anybody says what it means.
//!
//! It is read once, in memory that does not grow with its length. What columns mean is guessed from their names and ranges; a guess is
//! told as one.

mod column;
mod joint_names;
mod joints;
mod names;
mod numbers;
#[cfg(test)]
mod tests;
mod text;
mod time;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use self::column::ColumnWatch;
pub use self::column::{Clipped, ColumnFound, Stuck};
pub use self::joint_names::named_joint;
pub use self::joints::JointFound;
use self::names::DATES;
pub use self::names::{Guess, Meaning};
pub use self::numbers::{are_same_numbers, column_numbers};
use self::time::TimeWatch;
pub use self::time::{Gap, TimeFound};
use super::stamp::Stamp;
use super::{Row, Rows, Source, Watched};
use crate::csv_lines::CsvWriting;
use crate::error::{ReadError, SEPARATORS};

/// What is in a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Kind of file and what it holds.
    pub source: Source,
    /// What it says of itself, such as the load.
    pub metadata: BTreeMap<String, String>,
    /// How many rows there are.
    pub rows: u64,
    /// Rows that say the same as the one before at the same time.
    pub repeated: u64,
    /// Its clock; absent where no column is one.
    pub time: Option<TimeFound>,
    /// Its columns but for the time, in their order.
    pub columns: Vec<ColumnFound>,
    /// What was lost or looks wrong.
    pub remarks: Vec<String>,
}

/// Reads a recording to its end. `watch` is told which share is read, from 0 to 1.
///
/// # Errors
///
/// It cannot be read, or has no number in any column but the clock's.
pub fn inspect(path: &Path, watch: &dyn Fn(f64)) -> Result<Inspection, ReadError> {
    inspect_as(path, &CsvWriting::default(), watch)
}

/// The same of a file that, if it is CSV, is said to be written so.
///
/// # Errors
///
/// As [`inspect`].
pub fn inspect_as(path: &Path, csv: &CsvWriting, watch: &dyn Fn(f64)) -> Result<Inspection, ReadError> {
    let found = inspect_rows(&mut Watched::new(super::open_as(path, csv)?, watch))?;
    if found.columns.iter().all(|column| column.readings == 0) {
        let kind = &found.source.kind;
        let separators = if kind.starts_with("CSV") { format!("; {SEPARATORS}") } else { String::new() };
        let what = format!("no column has a number, so it is no recording; it was read as: {kind}{separators}");
        return Err(ReadError::NotRecording { path: path.to_owned(), what });
    }
    Ok(found)
}

/// The column that is a clock: by its name, else one that holds dates with times.
fn clock(rows: &dyn Rows) -> Option<usize> {
    let columns = rows.columns();
    names::clock(columns).or_else(|| (0..columns.len()).find(|column| rows.holds_dates(*column)))
}

/// The clock's column, and those of which it was made.
fn parts_of_clock(columns: &[String], clock: Option<usize>) -> Vec<usize> {
    let made = clock.filter(|clock| clock + 1 == columns.len() && columns[*clock] == Stamp::column());
    let parts = made.and_then(|clock| Stamp::find(&columns[..clock])).map(Stamp::parts);
    clock.into_iter().chain(parts.into_iter().flatten()).collect()
}

/// Whether several positions are recorded, and none has changed since the row before.
fn rests(motion: &[Option<Meaning>], cells: &[f64], last: &[f64]) -> bool {
    let positions = || motion.iter().enumerate().filter(|(_, of)| **of == Some(Meaning::Position));
    let stays = |(place, _): (usize, &Option<Meaning>)| {
        let number = |cells: &[f64]| cells.get(place).copied().unwrap_or(f64::NAN).to_bits();
        number(cells) == number(last)
    };
    positions().nth(1).is_some() && positions().all(stays)
}

fn inspect_rows(rows: &mut dyn Rows) -> Result<Inspection, ReadError> {
    let clock = clock(rows);
    let mut time = TimeWatch::default();
    let mut columns: Vec<ColumnWatch> = Vec::new();
    let (mut row, mut last) = (Row::default(), Row::default());
    let (mut count, mut repeated) = (0, 0);
    let mut motion: Vec<Option<Meaning>> = Vec::new();
    while rows.read(&mut row)? {
        count += 1;
        columns.resize_with(row.cells.len(), ColumnWatch::default);
        let known = motion.len();
        motion.extend(rows.columns().iter().skip(known).map(|name| names::meaning_of_motion(name)));
        let same = row.cells.len() == last.cells.len()
            && row.cells.iter().zip(&last.cells).all(|(a, b)| a.to_bits() == b.to_bits());
        repeated += u64::from(same && clock.is_some());
        let now = clock.map_or(count as f64, |clock| row.cells[clock]);
        if clock.is_some() {
            time.take(now, row.number);
        }
        if !(same && clock.is_some()) {
            let rests = rests(&motion, &row.cells, &last.cells);
            let cells = columns.iter_mut().zip(&row.cells).zip(&motion);
            cells.for_each(|((column, cell), motion)| column.take(now, *cell, rests && motion.is_some()));
        }
        std::mem::swap(&mut row, &mut last);
    }
    let names = rows.columns();
    let unit = clock.map(|clock| match rows.holds_dates(clock) {
        true => DATES,
        false => names::time_unit(&names[clock], time.interval()),
    });
    let per_second = unit.map_or(1.0, |unit| unit.per_second);
    let of_clock = parts_of_clock(names, clock);
    let found = names.iter().zip(columns).enumerate().filter(|(index, _)| !of_clock.contains(index));
    let columns = found.map(|(_, (name, column))| column.found(name, per_second)).collect();
    Ok(Inspection {
        source: rows.source(),
        metadata: rows.metadata(),
        rows: count,
        repeated,
        time: clock.zip(unit).and_then(|(clock, unit)| time.found(&names[clock], unit)),
        columns,
        remarks: rows.remarks(),
    })
}
