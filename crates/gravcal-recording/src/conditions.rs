//! What else a table says of a row: when it was, how warm the sensors were, how the joints came there and how they move.

use crate::error::{Place, ReadError};
use crate::iso8601::ISO_8601;
use crate::presliding::Presliding;
use crate::table::Table;

/// Under which conditions a pose was read. Empty lists (and no time) where the mapping names no column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// s, on the recording's own clock.
    pub time: Option<f64>,
    /// °C, by joint.
    pub temperature: Vec<f64>,
    /// rad/s or m/s, by joint.
    pub velocity: Vec<f64>,
    /// rad/s² or m/s², by joint.
    pub acceleration: Vec<f64>,
    /// From which side each joint came: 1 where its coordinate rose, −1 where it fell, 0 where neither is known.
    pub direction: Vec<f64>,
    /// How far friction has built up, by joint, where that was followed over an arm's motion; `None` of a joint of which it was not, or is not known.
    pub presliding: Vec<Option<Presliding>>,
    /// Numbers of further columns, as they stand there; NaN where a cell is empty that may be.
    pub further: Vec<f64>,
}

/// Where the conditions stand. Lists are empty, or have one column for each joint (several joints may share one).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConditionColumns {
    /// Time.
    pub time: Option<ConditionColumn>,
    /// Temperature of each joint's sensors.
    pub temperature: Vec<ConditionColumn>,
    /// Velocity of each joint; as a slope, that of its coordinate over time, by the nominal gain of its position reading.
    pub velocity: MotionSource,
    /// Acceleration of each joint; as a slope, that of its velocity over time.
    pub acceleration: MotionSource,
    /// Direction of approach of each joint: the cells are 1, 0 or −1.
    pub direction: Vec<String>,
    /// Further columns of numbers.
    pub further: Vec<FurtherColumn>,
}

/// A column that only models of sensors know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FurtherColumn {
    /// What models call it.
    pub name: String,
    /// Name of the column.
    pub column: String,
    /// Whether its cells may be empty: what reads it then has nothing to read.
    pub may_be_empty: bool,
}

/// Where a derivative of the joints' positions comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum MotionSource {
    /// It is not known.
    #[default]
    Unknown,
    /// One column for each joint.
    Columns(Vec<ConditionColumn>),
    /// Numerical differentiation over the rows of one table: see [`Slope`].
    Slope(Slope),
}

/// Numerical differentiation: at every row the slope of the straight line through the rows whose time is at most half of
/// `window` away. Both ends of a table see one side only, so that there the slope belongs to a time up to `window / 4` off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Whole width, s, greater than 0.
    pub window: f64,
}

/// What the column of times is called where nothing is said.
const TIME: &str = "time_s";

impl ConditionColumns {
    /// The clock of a recording: the column that is said to be one, else `time_s`, in s.
    pub fn clock(&self) -> ConditionColumn {
        let known = || ConditionColumn { column: TIME.to_owned(), unit: ConditionUnit::TIME[0] };
        self.time.clone().unwrap_or_else(known)
    }
}

impl MotionSource {
    /// Whether anything tells the derivative.
    pub fn is_known(&self) -> bool {
        *self != MotionSource::Unknown
    }

    /// Its columns; none where it is unknown or a slope.
    fn columns(&self) -> &[ConditionColumn] {
        match self {
            MotionSource::Columns(columns) => columns,
            MotionSource::Unknown | MotionSource::Slope(_) => &[],
        }
    }

    /// How it is differentiated, where it is.
    pub(crate) fn slope(&self) -> Option<Slope> {
        match self {
            MotionSource::Slope(slope) => Some(*slope),
            MotionSource::Unknown | MotionSource::Columns(_) => None,
        }
    }
}

/// A column of numbers that become `scale · cell + zero` inside.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionColumn {
    /// Name of the column. No cell of it may be empty.
    pub column: String,
    /// Unit of its numbers.
    pub unit: ConditionUnit,
}

/// Unit of a condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionUnit {
    /// The name that stands in files.
    pub name: &'static str,
    scale: f64,
    zero: f64,
}

const fn unit(name: &'static str, scale: f64, zero: f64) -> ConditionUnit {
    ConditionUnit { name, scale, zero }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

impl ConditionUnit {
    /// Units of time; s inside. Cells with dates, the last, are read as seconds.
    pub const TIME: [ConditionUnit; 7] = [
        unit("s", 1.0, 0.0),
        unit("ms", 1e-3, 0.0),
        unit("µs", 1e-6, 0.0),
        unit("ns", 1e-9, 0.0),
        unit("min", 60.0, 0.0),
        unit("h", 3600.0, 0.0),
        unit(ISO_8601, 1.0, 0.0),
    ];
    /// Units of temperature; °C inside.
    pub const TEMPERATURE: [ConditionUnit; 2] = [unit("degC", 1.0, 0.0), unit("K", 1.0, -273.15)];
    /// Units of velocity of a joint that turns; rad/s inside.
    pub const ANGULAR_VELOCITY: [ConditionUnit; 2] = [unit("rad/s", 1.0, 0.0), unit("deg/s", DEGREE, 0.0)];
    /// Units of velocity of a joint that slides; m/s inside.
    pub const VELOCITY: [ConditionUnit; 2] = [unit("m/s", 1.0, 0.0), unit("mm/s", 1e-3, 0.0)];

    /// Units of acceleration of a joint that turns; rad/s² inside.
    pub const ANGULAR_ACCELERATION: [ConditionUnit; 2] = [unit("rad/s²", 1.0, 0.0), unit("deg/s²", DEGREE, 0.0)];
    /// Units of acceleration of a joint that slides; m/s² inside.
    pub const ACCELERATION: [ConditionUnit; 2] = [unit("m/s²", 1.0, 0.0), unit("mm/s²", 1e-3, 0.0)];

    /// Whether a clock in this unit may hold dates with times, or numbers where it holds none.
    pub(crate) fn suits(self, dates: bool) -> bool {
        match self.name {
            ISO_8601 => dates,
            "s" => true,
            _ => !dates,
        }
    }

    /// A number in this unit, in the unit that is used inside.
    pub fn to_inside(self, number: f64) -> f64 {
        self.scale * number + self.zero
    }
}

/// Columns of conditions found in one table.
pub(crate) struct FoundConditions<'a> {
    mapped: &'a ConditionColumns,
    time: Option<usize>,
    temperature: Vec<usize>,
    velocity: Vec<usize>,
    acceleration: Vec<usize>,
    direction: Vec<usize>,
    further: Vec<usize>,
}

impl<'a> FoundConditions<'a> {
    pub(crate) fn find(table: &Table, mapped: &'a ConditionColumns) -> Result<FoundConditions<'a>, ReadError> {
        let places = |columns: &[ConditionColumn]| -> Result<Vec<usize>, ReadError> {
            columns.iter().map(|c| table.column(&c.column)).collect()
        };
        Ok(FoundConditions {
            mapped,
            time: mapped.time.as_ref().map(|c| table.column(&c.column)).transpose()?,
            temperature: places(&mapped.temperature)?,
            velocity: places(mapped.velocity.columns())?,
            acceleration: places(mapped.acceleration.columns())?,
            direction: mapped.direction.iter().map(|c| table.column(c)).collect::<Result<_, _>>()?,
            further: mapped.further.iter().map(|c| table.column(&c.column)).collect::<Result<_, _>>()?,
        })
    }

    pub(crate) fn read(&self, table: &Table, row: usize) -> Result<Conditions, ReadError> {
        let number = |column: usize| {
            table.number(row, column)?.ok_or_else(|| ReadError::NoCondition { place: table.place(row, column) })
        };
        let numbers = |places: &[usize], mapped: &[ConditionColumn]| -> Result<Vec<f64>, ReadError> {
            places.iter().zip(mapped).map(|(place, mapped)| Ok(mapped.unit.to_inside(number(*place)?))).collect()
        };
        let direction = |column: &usize| match number(*column)? {
            sign if [-1.0, 0.0, 1.0].contains(&sign) => Ok(sign),
            found => Err(ReadError::NotADirection { place: table.place(row, *column), found }),
        };
        let further = |(column, mapped): (&usize, &FurtherColumn)| match mapped.may_be_empty {
            true => Ok(table.number(row, *column)?.unwrap_or(f64::NAN)),
            false => number(*column),
        };
        let mapped = self.mapped;
        let time = self.time.zip(mapped.time.as_ref());
        Ok(Conditions {
            time: time.map(|(column, mapped)| time_of(table, row, column, mapped.unit)).transpose()?,
            temperature: numbers(&self.temperature, &mapped.temperature)?,
            velocity: numbers(&self.velocity, mapped.velocity.columns())?,
            acceleration: numbers(&self.acceleration, mapped.acceleration.columns())?,
            direction: self.direction.iter().map(direction).collect::<Result<_, _>>()?,
            presliding: Vec::new(),
            further: self.further.iter().zip(&mapped.further).map(further).collect::<Result<_, _>>()?,
        })
    }
}

/// The time in a cell, s.
fn time_of(table: &Table, row: usize, column: usize, unit: ConditionUnit) -> Result<f64, ReadError> {
    let place = || table.place(row, column);
    match table.date(row, column)? {
        Some(seconds) if unit.suits(true) => Ok(seconds),
        Some(_) => {
            let Place { path, column, .. } = place();
            Err(ReadError::OtherClock { path, column, unit: unit.name, dates: true })
        }
        None if table.text(row, column).is_empty() => Err(ReadError::NoCondition { place: place() }),
        None if !unit.suits(false) => {
            Err(ReadError::NotADate { place: place(), found: table.text(row, column).to_owned() })
        }
        None => {
            let number = table.number(row, column)?.ok_or_else(|| ReadError::NoCondition { place: place() })?;
            Ok(unit.to_inside(number))
        }
    }
}

/// Means over the rows of one standstill, which have one direction.
pub(crate) fn mean_conditions(rows: &[&Conditions]) -> Conditions {
    let mean = |value: &dyn Fn(&Conditions) -> f64| rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64;
    let means = |list: &dyn Fn(&Conditions) -> &[f64]| -> Vec<f64> {
        (0..rows.first().map_or(0, |row| list(row).len())).map(|joint| mean(&|row| list(row)[joint])).collect()
    };
    Conditions {
        time: rows.iter().map(|row| row.time).sum::<Option<f64>>().map(|sum| sum / rows.len() as f64),
        temperature: means(&|row| &row.temperature),
        velocity: means(&|row| &row.velocity),
        acceleration: means(&|row| &row.acceleration),
        direction: rows.first().map_or_else(Vec::new, |row| row.direction.clone()),
        presliding: Vec::new(),
        further: means_of_known(rows),
    }
}

/// Means of further columns over the rows that have a number there.
fn means_of_known(rows: &[&Conditions]) -> Vec<f64> {
    let mean = |place: usize| {
        let known: Vec<f64> = rows.iter().map(|row| row.further[place]).filter(|number| !number.is_nan()).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    (0..rows.first().map_or(0, |row| row.further.len())).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::csv_lines::CsvFormat;

    fn column(column: &str, unit: ConditionUnit) -> ConditionColumn {
        ConditionColumn { column: column.to_owned(), unit }
    }

    fn read(text: &str) -> Result<Vec<Conditions>, String> {
        let mapped = ConditionColumns {
            time: Some(column("t", ConditionUnit::TIME[1])),
            temperature: vec![column("T", ConditionUnit::TEMPERATURE[1]); 2],
            velocity: MotionSource::Columns(vec![column("v", ConditionUnit::ANGULAR_VELOCITY[1]); 2]),
            acceleration: MotionSource::Unknown,
            direction: vec!["d".to_owned()],
            further: vec![FurtherColumn { name: "pressure".into(), column: "p".into(), may_be_empty: false }],
        };
        let table = Table::parse(Path::new("a.csv"), text.as_bytes(), CsvFormat::default())
            .map_err(|error| error.to_string())?;
        let found = FoundConditions::find(&table, &mapped).map_err(|error| error.to_string())?;
        (0..table.len()).map(|row| found.read(&table, row).map_err(|error| error.to_string())).collect()
    }

    #[test]
    fn conditions_are_in_si_units() {
        let poses = read("t,T,v,d,p\n1500,293.15,180,-1,2.5\n").unwrap();
        assert_eq!(poses[0].time, Some(1.5));
        assert_eq!(poses[0].temperature, [20.0, 20.0]);
        assert_eq!(poses[0].velocity, [std::f64::consts::PI; 2]);
        assert_eq!((&poses[0].direction[..], &poses[0].further[..]), (&[-1.0][..], &[2.5][..]));
    }

    #[test]
    fn dates_are_times_where_the_clock_is_said_to_hold_them() {
        let times = |unit: usize, cell: &str| {
            let mapped =
                ConditionColumns { time: Some(column("t", ConditionUnit::TIME[unit])), ..ConditionColumns::default() };
            let text = format!("t\n{cell}\n2024-05-01 12:00:01\n");
            let table = Table::parse(Path::new("a.csv"), text.as_bytes(), CsvFormat::default()).unwrap();
            let found = FoundConditions::find(&table, &mapped).unwrap();
            let times: Result<Vec<_>, _> = (0..2).map(|row| found.read(&table, row).map(|read| read.time)).collect();
            times.map_err(|error| error.to_string())
        };
        for unit in [0, 6] {
            let found = times(unit, "2024-05-01T14:00:00.500+02:00").unwrap();
            assert_eq!(found, [Some(1_714_564_800.5), Some(1_714_564_801.0)]);
        }
        let other = "a.csv: the clock `t` holds dates with times: its unit is \"ISO 8601\", and not ms";
        assert_eq!(times(1, "2024-05-01 12:00:00").unwrap_err(), other);
        let none =
            "a.csv:2: column `t`: expected a date with a time (ISO 8601) such as 2024-05-01T12:00:00.010Z, found `12`";
        assert_eq!(times(6, "12").unwrap_err(), none);
    }

    #[test]
    fn what_is_missing_or_no_direction_is_reported() {
        let missing = read("t,T,v,d,p\n1,293,,1,0\n").unwrap_err();
        assert!(missing.starts_with("a.csv:2: column `v`: the cell is empty"), "{missing}");
        let direction = read("t,T,v,d,p\n1,293,0,0.5,0\n").unwrap_err();
        assert!(direction.contains("column `d`: expected 1 (rising), -1 (falling) or 0 (not known), found 0.5"));
        let empty = read("t,T,v,d,p\n1,293,0,1,\n").unwrap_err();
        assert!(empty.starts_with("a.csv:2: column `p`: the cell is empty"), "{empty}");
        assert!(read("t,T,v\n1,293,0\n").unwrap_err().contains("there is no column `d`"));
    }

    #[test]
    fn rows_of_one_standstill_have_the_mean_of_their_conditions() {
        let rows = read("t,T,v,d,p\n1000,293.15,0,1,3\n2000,295.15,0,1,4\n").unwrap();
        let mean = mean_conditions(&rows.iter().collect::<Vec<_>>());
        assert_eq!((mean.time, mean.temperature, mean.direction), (Some(1.5), vec![21.0; 2], vec![1.0]));
        assert_eq!(mean.further, [3.5]);
        assert_eq!(mean_conditions(&[&Conditions::default()]), Conditions::default());
    }
}
