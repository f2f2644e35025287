//! Columns of readings with what says how noisy they are: of the joints' torques, or of the axes of an instrument.

use gravcal_recording::ReadingColumn;
use gravcal_robot_model::session::units::UnitError;
use serde::Deserialize;

use super::context::Context;
use super::unexplained;
use crate::document::{Field, FileError, OneOrMany};

/// In lists of columns, `""` means that there is none for the joint (or axis).
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct ReadingColumnsTable {
    /// One column for each joint or axis; `""` where there is no sensor.
    ///
    /// Example: `columns = ["y1", "y2"]`
    pub columns: Vec<String>,
    /// Unit of the readings; one for all or a list.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "N·m"`
    unit: Option<OneOrMany<String>>,
    /// Standard deviation of a reading; one for all or a list. With `count`, of one of so many averaged samples.
    ///
    /// Unit: the reading's.
    /// Default: estimated from the residuals.
    /// Example: `std = 0.02`
    std: Option<OneOrMany<f64>>,
    /// Errors beyond that noise: `"estimated"` joint by joint from the residuals, `"none"`, or a number.
    ///
    /// Unit: the reading's.
    /// Default: `"estimated"` with `still` and `sweeps`, else `"none"`.
    /// Example: `unexplained_std = "estimated"`
    pub unexplained_std: Option<OneOrMany<unexplained::Written>>,
    /// How many samples a reading is the mean of.
    ///
    /// Unit: 1.
    /// Default: 1.
    /// Example: `count = 200`
    count: Option<OneOrMany<f64>>,
    /// Lower end of the sensor's range. Readings there are left out.
    ///
    /// Unit: the reading's.
    /// Default: no end.
    /// Example: `lowest = 0`
    lowest: Option<OneOrMany<f64>>,
    /// Upper end of the sensor's range. Readings there are left out.
    ///
    /// Unit: the reading's.
    /// Default: no end.
    /// Example: `highest = 4095`
    highest: Option<OneOrMany<f64>>,
    /// Columns with the standard deviation of each reading; `""` where there is none. An empty cell stands for the root mean square of the
    /// other cells.
    ///
    /// Unit: the reading's.
    /// Example: `std_columns = ["s1", "s2"]`
    std_columns: Option<Vec<String>>,
    /// Columns with the number of averaged samples of each reading.
    ///
    /// Unit: 1.
    /// Example: `count_columns = ["n1", "n2"]`
    count_columns: Option<Vec<String>>,
    /// Columns that say whether a reading may be used.
    ///
    /// Example: `usable_columns = ["ok1", "ok2"]`
    usable_columns: Option<Vec<String>>,
}

/// The parts of such a table, one for each joint (or axis).
pub(super) struct ReadingColumns<'a> {
    columns: &'a [String],
    units: Units<'a>,
    std: Option<Vec<f64>>,
    count: Option<Vec<f64>>,
    lowest: Option<Vec<f64>>,
    highest: Option<Vec<f64>>,
    std_columns: Option<Vec<String>>,
    count_columns: Option<Vec<String>>,
    usable_columns: Option<Vec<String>>,
}

impl<'a> ReadingColumns<'a> {
    /// `field`: where the table stands; `names`: of the joints (or axes).
    pub fn new(
        context: &'a Context<'_>,
        field: &Field,
        names: &[&str],
        table: &'a ReadingColumnsTable,
    ) -> Result<Self, FileError> {
        let document = context.document;
        let numbers = |key: &str, numbers: &Option<OneOrMany<f64>>| {
            numbers.as_ref().map(|numbers| document.for_each(&field.key(key), numbers, names)).transpose()
        };
        let columns = |key: &str, columns: &Option<Vec<String>>| {
            columns.as_ref().map(|columns| document.one_each(&field.key(key), columns, names).cloned()).transpose()
        };
        Ok(ReadingColumns {
            columns: document.one_each(&field.key("columns"), &table.columns, names)?,
            units: Units::new(context, field.key("unit"), names, table.unit.as_ref())?,
            std: numbers("std", &table.std)?,
            count: numbers("count", &table.count)?,
            lowest: numbers("lowest", &table.lowest)?,
            highest: numbers("highest", &table.highest)?,
            std_columns: columns("std_columns", &table.std_columns)?,
            count_columns: columns("count_columns", &table.count_columns)?,
            usable_columns: columns("usable_columns", &table.usable_columns)?,
        })
    }

    /// Whether each joint (or axis) has a unit, and not one all.
    pub fn have_units_of_their_own(&self) -> bool {
        matches!(self.units.written, Some(OneOrMany::Many(_)))
    }

    /// The reading of a joint (or axis) with its unit; `None` where it has no column (and needs no unit).
    pub fn of<U>(
        &self,
        index: usize,
        parse: impl Fn(Option<&str>) -> Result<U, UnitError>,
    ) -> Result<Option<(ReadingColumn, U)>, FileError> {
        let Some(name) = named(&self.columns[index]) else { return Ok(None) };
        let number = |numbers: &Option<Vec<f64>>| numbers.as_ref().map(|numbers| numbers[index]);
        let column = |columns: &Option<Vec<String>>| columns.as_ref().and_then(|columns| named(&columns[index]));
        let reading = ReadingColumn {
            column: name,
            std_column: column(&self.std_columns),
            count_column: column(&self.count_columns),
            usable_column: column(&self.usable_columns),
            std: number(&self.std),
            count: number(&self.count),
            lowest: number(&self.lowest),
            highest: number(&self.highest),
        };
        Ok(Some((reading, self.units.of(index, parse)?)))
    }
}

/// The name of a column; `""` is none.
fn named(column: &str) -> Option<String> {
    (!column.is_empty()).then(|| column.to_owned())
}

/// The units that are written for the joints (or axes): one for all, or a list.
pub(super) struct Units<'a> {
    context: &'a Context<'a>,
    field: Field,
    written: Option<&'a OneOrMany<String>>,
}

impl<'a> Units<'a> {
    pub fn new(
        context: &'a Context<'_>,
        field: Field,
        names: &[&str],
        written: Option<&'a OneOrMany<String>>,
    ) -> Result<Units<'a>, FileError> {
        if let Some(OneOrMany::Many(units)) = written {
            context.document.one_each(&field, units, names)?;
        }
        Ok(Units { context, field, written })
    }

    pub fn of<U>(&self, index: usize, parse: impl Fn(Option<&str>) -> Result<U, UnitError>) -> Result<U, FileError> {
        let (written, field) = match self.written {
            Some(OneOrMany::Many(units)) => (Some(&units[index]), self.field.at(index)),
            Some(OneOrMany::One(unit)) => (Some(unit), self.field.clone()),
            None => (None, self.field.clone()),
        };
        parse(written.map(String::as_str)).map_err(|error| self.context.document.error(&field, error))
    }
}
