//! The columns of one table, found by the names in a mapping, and their cells read as poses.

use crate::conditions::FoundConditions;
use crate::error::ReadError;
use crate::mapping::{PoseMapping, PositionColumn, ReadingColumn};
use crate::orientation::FoundOrientation;
use crate::static_pose::{Reading, StaticPose};
use crate::table::Table;

/// A mapping with the names of columns resolved to their places in one table.
pub(crate) struct Columns<'a> {
    table: &'a Table,
    positions: Vec<Position>,
    torques: Vec<Option<Column<'a>>>,
    instruments: Vec<Option<Column<'a>>>,
    orientation: Option<FoundOrientation<'a>>,
    sweep: Option<usize>,
    conditions: FoundConditions<'a>,
}

impl<'a> Columns<'a> {
    /// Looks for every column that the mapping names; `mapping` has been checked.
    pub(crate) fn find(table: &'a Table, mapping: &'a PoseMapping) -> Result<Columns<'a>, ReadError> {
        let positions = mapping.positions.iter().map(|position| Position::find(table, position));
        let torques = mapping.torques.iter().map(|torque| match torque {
            None => Ok(None),
            Some((column, unit)) => Column::find(table, column, unit.to_si()).map(Some),
        });
        let instruments = mapping
            .instruments
            .iter()
            .map(|column| column.as_ref().map(|column| Column::find(table, column, 1.0)).transpose());
        Ok(Columns {
            table,
            positions: positions.collect::<Result<_, _>>()?,
            torques: torques.collect::<Result<_, _>>()?,
            instruments: instruments.collect::<Result<_, _>>()?,
            orientation: mapping
                .orientation
                .as_ref()
                .map(|mapped| FoundOrientation::find(table, mapped))
                .transpose()?,
            sweep: find(table, mapping.sweep_column.as_ref())?,
            conditions: FoundConditions::find(table, &mapping.conditions)?,
        })
    }

    /// One row as a pose.
    pub(crate) fn pose(&self, row: usize) -> Result<StaticPose, ReadError> {
        let positions = self.positions.iter().map(|position| position.read(self.table, row));
        let read = |column: &Option<Column<'_>>| match column {
            None => Ok(None),
            Some(column) => column.read(row),
        };
        let torques = self.torques.iter().map(read);
        let mut torque: Vec<Option<Reading>> = torques.collect::<Result<_, _>>()?;
        let saturated = take_saturated(&self.torques, &mut torque);
        let instruments = self.instruments.iter().map(read);
        let mut instruments: Vec<Option<Reading>> = instruments.collect::<Result<_, _>>()?;
        take_saturated(&self.instruments, &mut instruments);
        Ok(StaticPose {
            line: self.table.line(row),
            position: positions.collect::<Result<_, _>>()?,
            orientation: self.orientation.as_ref().map(|found| found.read(self.table, row)).transpose()?,
            torque,
            saturated,
            instruments,
            sweep: self.sweep(row),
            conditions: self.conditions.read(self.table, row)?,
            merged: 1,
        })
    }

    fn sweep(&self, row: usize) -> Option<String> {
        let label = self.table.text(row, self.sweep?);
        (!label.is_empty()).then(|| label.to_owned())
    }
}

/// Takes the saturated ones from the readings of the given columns, and names them.
fn take_saturated(columns: &[Option<Column<'_>>], readings: &mut [Option<Reading>]) -> Vec<usize> {
    let mut saturated = Vec::new();
    for (index, (column, reading)) in columns.iter().zip(readings).enumerate() {
        let ends = column.as_ref().map(|column| column.range);
        if reading.zip(ends).is_some_and(|(reading, [lowest, highest])| is_saturated(reading.value, lowest, highest)) {
            *reading = None;
            saturated.push(index);
        }
    }
    saturated
}

/// Whether a sensor's reading is at an end of its range, or beyond: then the true one may be anything beyond.
pub fn is_saturated(reading: f64, lowest: Option<f64>, highest: Option<f64>) -> bool {
    lowest.is_some_and(|lowest| reading <= lowest) || highest.is_some_and(|highest| reading >= highest)
}

/// Place of a column that need not be mapped.
fn find(table: &Table, column: Option<&String>) -> Result<Option<usize>, ReadError> {
    column.map(|name| table.column(name)).transpose()
}

struct Position {
    column: usize,
    to_si: f64,
}

impl Position {
    fn find(table: &Table, mapped: &PositionColumn) -> Result<Position, ReadError> {
        Ok(Position { column: table.column(&mapped.column)?, to_si: mapped.unit.to_si() })
    }

    fn read(&self, table: &Table, row: usize) -> Result<f64, ReadError> {
        match table.number(row, self.column)? {
            Some(reading) => Ok(reading * self.to_si),
            None => Err(ReadError::NoPosition { place: table.place(row, self.column) }),
        }
    }
}

/// A column of readings with what says how uncertain they are.
struct Column<'a> {
    table: &'a Table,
    column: usize,
    to_si: f64,
    usable: Option<usize>,
    /// Lower and upper end, where there are any.
    range: [Option<f64>; 2],
    std: Setting,
    count: Setting,
}

/// A number that stands in a column, or is the same for all rows, or both: then the constant fills empty cells.
#[derive(Clone, Copy)]
struct Setting {
    column: Option<usize>,
    constant: Option<f64>,
}

impl<'a> Column<'a> {
    fn find(table: &'a Table, mapped: &ReadingColumn, to_si: f64) -> Result<Column<'a>, ReadError> {
        let setting = |column: &Option<String>, constant| -> Result<Setting, ReadError> {
            Ok(Setting { column: find(table, column.as_ref())?, constant })
        };
        Ok(Column {
            table,
            column: table.column(&mapped.column)?,
            to_si,
            usable: find(table, mapped.usable_column.as_ref())?,
            range: [mapped.lowest, mapped.highest].map(|end| end.map(|end| end * to_si)),
            std: setting(&mapped.std_column, mapped.std)?,
            count: setting(&mapped.count_column, mapped.count)?,
        })
    }

    fn read(&self, row: usize) -> Result<Option<Reading>, ReadError> {
        if !self.is_usable(row)? {
            return Ok(None);
        }
        let Some(value) = self.table.number(row, self.column)? else {
            return Ok(None);
        };
        Ok(Some(Reading { value: value * self.to_si, std: self.std_of_value(row)? }))
    }

    fn is_usable(&self, row: usize) -> Result<bool, ReadError> {
        let Some(column) = self.usable else {
            return Ok(true);
        };
        let text = self.table.text(row, column);
        match text.to_ascii_lowercase().as_str() {
            "1" | "true" => Ok(true),
            "0" | "false" => Ok(false),
            _ => Err(ReadError::NotYesOrNo { place: self.table.place(row, column), found: text.to_owned() }),
        }
    }

    /// Standard deviation of the recorded value: that of one sample over the root of their number.
    fn std_of_value(&self, row: usize) -> Result<Option<f64>, ReadError> {
        let cell = self.in_column(row, self.std)?;
        let Some(found) = cell.map(|(std, _)| std).or(self.std.constant) else {
            return Ok(None);
        };
        let std = found / self.count(row)?.sqrt() * self.to_si;
        // Asked of the quotient, so that one too small to be represented is refused too.
        if std > 0.0 {
            return Ok(Some(std));
        }
        let column = cell.map_or(self.column, |(_, column)| column);
        Err(ReadError::BadStd { place: self.table.place(row, column), found })
    }

    /// Number of samples: 1, if the mapping speaks of none.
    fn count(&self, row: usize) -> Result<f64, ReadError> {
        match (self.in_column(row, self.count)?, self.count.column, self.count.constant) {
            (Some((found, column)), _, _) if found < 1.0 => {
                Err(ReadError::BadCount { place: self.table.place(row, column), found })
            }
            (Some((found, _)), _, _) => Ok(found),
            (None, _, Some(constant)) => Ok(constant),
            (None, Some(column), None) => Err(ReadError::NoCount { place: self.table.place(row, column) }),
            (None, None, None) => Ok(1.0),
        }
    }

    /// The number in the setting's column, and the column, if there is such a column and the cell is not empty.
    fn in_column(&self, row: usize, setting: Setting) -> Result<Option<(f64, usize)>, ReadError> {
        let Some(column) = setting.column else {
            return Ok(None);
        };
        Ok(self.table.number(row, column)?.map(|number| (number, column)))
    }
}
