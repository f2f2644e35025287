//! The numbers of a row that matter, in SI units: positions first, then torques, instruments, velocities, temperatures, further columns.

use std::collections::HashMap;
use std::path::Path;

use crate::conditions::{ConditionColumn, ConditionUnit, MotionSource};
use crate::error::ReadError;
use crate::mapping::{PoseMapping, ReadingColumn};
use crate::rows::{Row, Rows};
use crate::unit::PositionUnit;

/// Place of a column that has not come yet: beyond every row.
const NOWHERE: usize = usize::MAX;

/// One number of each row.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    pub column: String,
    scale: f64,
    zero: f64,
    /// Ends of the sensor's range.
    pub range: [f64; 2],
}

/// All of them, and which is which.
#[derive(Clone, Debug)]
pub(crate) struct Channels {
    pub list: Vec<Channel>,
    /// The first so many are the positions of the joints.
    pub joints: usize,
    pub position_units: Vec<PositionUnit>,
    /// By joint, see [`PositionColumn::nominal_gain`](crate::mapping::PositionColumn::nominal_gain).
    pub position_gains: Vec<f64>,
    pub torques: Vec<Option<usize>>,
    pub instruments: Vec<Option<usize>>,
    pub velocity: Vec<usize>,
    pub temperature: Vec<usize>,
    pub further: Vec<usize>,
    /// Where a velocity is only known as a slope: that of a standstill is zero.
    pub velocity_is_slope: bool,
    time: Channel,
    clock: ConditionUnit,
    /// Scale and zero of each.
    units: Vec<[f64; 2]>,
    places: Vec<usize>,
    time_place: usize,
    known: usize,
}

impl Channels {
    /// `mapping` has been checked.
    pub fn new(mapping: &PoseMapping) -> Channels {
        let mut list: Vec<Channel> = mapping
            .positions
            .iter()
            .map(|position| channel(&position.column, position.unit.to_si(), 0.0, [f64::NEG_INFINITY, f64::INFINITY]))
            .collect();
        let mut add = |channel: Channel| {
            list.push(channel);
            list.len() - 1
        };
        let reading = |column: &ReadingColumn, scale: f64| {
            let ends = [column.lowest.unwrap_or(f64::NEG_INFINITY), column.highest.unwrap_or(f64::INFINITY)];
            channel(&column.column, scale, 0.0, ends.map(|end| end * scale))
        };
        let torque = |torque: &Option<(ReadingColumn, _)>| torque.clone();
        let torques = mapping
            .torques
            .iter()
            .map(torque)
            .map(|torque| {
                torque.map(|(column, unit): (_, crate::unit::TorqueUnit)| add(reading(&column, unit.to_si())))
            })
            .collect();
        let instruments =
            mapping.instruments.iter().map(|column| column.as_ref().map(|column| add(reading(column, 1.0)))).collect();
        let mut conditions =
            |columns: &[ConditionColumn]| columns.iter().map(|column| add(condition(column))).collect();
        let velocity = match &mapping.conditions.velocity {
            MotionSource::Columns(columns) => conditions(columns),
            MotionSource::Unknown | MotionSource::Slope(_) => Vec::new(),
        };
        let temperature = conditions(&mapping.conditions.temperature);
        let none = [f64::NEG_INFINITY, f64::INFINITY];
        let further = mapping.conditions.further.iter();
        let further = further.map(|column| add(channel(&column.column, 1.0, 0.0, none))).collect();
        Channels {
            joints: mapping.positions.len(),
            position_units: mapping.positions.iter().map(|position| position.unit).collect(),
            position_gains: mapping.positions.iter().map(|position| position.nominal_gain).collect(),
            units: list.iter().map(|channel| [channel.scale, channel.zero]).collect(),
            places: vec![NOWHERE; list.len()],
            torques,
            instruments,
            velocity,
            temperature,
            further,
            velocity_is_slope: matches!(mapping.conditions.velocity, MotionSource::Slope(_)),
            time: condition(&mapping.conditions.clock()),
            clock: mapping.conditions.clock().unit,
            time_place: NOWHERE,
            known: 0,
            list,
        }
    }

    /// How many must stand still, the first so many: positions and what reads gravity.
    pub fn tested(&self) -> usize {
        self.joints + self.torques.iter().chain(&self.instruments).flatten().count()
    }

    /// Looks for the columns among those that have come since the last look.
    pub fn look(&mut self, columns: &[String]) {
        let new = columns.iter().enumerate().skip(self.known);
        let new: HashMap<&str, usize> = new.map(|(place, name)| (name.as_str(), place)).collect();
        let wanted = self.list.iter().zip(&mut self.places).chain([(&self.time, &mut self.time_place)]);
        for (channel, found) in wanted {
            *found = new.get(channel.column.as_str()).copied().unwrap_or(*found);
        }
        self.known = columns.len();
    }

    /// Whether the columns are more than at the last look.
    pub fn is_behind(&self, columns: &[String]) -> bool {
        columns.len() > self.known
    }

    /// Name of the column with the times.
    pub fn clock(&self) -> &str {
        &self.time.column
    }

    /// Whether no column with times was found.
    pub fn has_no_clock(&self) -> bool {
        self.time_place == NOWHERE
    }

    /// A column that was not found, the time before all others.
    pub fn missing(&self) -> Option<&str> {
        if self.has_no_clock() {
            return Some(&self.time.column);
        }
        let found = self.list.iter().zip(&self.places).find(|(_, place)| **place == NOWHERE);
        found.map(|(channel, _)| channel.column.as_str())
    }

    /// Sees to it that dates with times are those of the clock, and that it is said to hold them.
    pub fn check_dates(&self, path: &Path, rows: &dyn Rows) -> Result<(), ReadError> {
        let path = || path.to_owned();
        let mut readings = self.list.iter().zip(&self.places);
        if let Some((channel, _)) = readings.find(|(_, place)| rows.holds_dates(**place)) {
            return Err(ReadError::DatesAsReadings { path: path(), column: channel.column.clone() });
        }
        let dates = rows.holds_dates(self.time_place);
        match self.clock.suits(dates) {
            true => Ok(()),
            false => {
                let (column, unit) = (self.time.column.clone(), self.clock.name);
                Err(ReadError::OtherClock { path: path(), column, unit, dates })
            }
        }
    }

    /// The time of a row, s, and the numbers in it; NaN where it says nothing. Temperatures and further columns, which may come more seldom than
    /// the rest, are as they were last.
    pub fn read(&self, row: &Row, values: &mut [f64]) -> f64 {
        let cell = |place: usize| row.cells.get(place).copied().unwrap_or(f64::NAN);
        let held = self.list.len() - self.temperature.len() - self.further.len();
        for (index, (value, place)) in values.iter_mut().zip(&self.places).enumerate() {
            let [scale, zero] = self.units[index];
            let new = cell(*place) * scale + zero;
            if index < held || !new.is_nan() {
                *value = new;
            }
        }
        cell(self.time_place) * self.time.scale + self.time.zero
    }
}

fn channel(column: &str, scale: f64, zero: f64, range: [f64; 2]) -> Channel {
    Channel { column: column.to_owned(), scale, zero, range }
}

fn condition(column: &ConditionColumn) -> Channel {
    let zero = column.unit.to_inside(0.0);
    channel(&column.column, column.unit.to_inside(1.0) - zero, zero, [f64::NEG_INFINITY, f64::INFINITY])
}
