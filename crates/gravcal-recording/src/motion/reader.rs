//! Rows as times and values in SI units.

use std::path::Path;

use super::alternation::Alternation;
use super::channels::Channels;
use super::row_clock::{ClockSteps, RowClock};
use super::sampler::Samples;
use super::wraps::Wraps;
use crate::error::ReadError;
use crate::rows::{Row, Rows};

/// The part of a recording that counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// Only what comes so long after its first row, s.
    pub from: Option<f64>,
    /// Only what comes before so long after its first row, s.
    pub until: Option<f64>,
}

impl Part {
    /// Whether what comes so long after the first row, s, is in it: parts that meet share nothing.
    pub(crate) fn holds(self, since: f64) -> bool {
        self.from.is_none_or(|from| since >= from) && self.until.is_none_or(|until| since < until)
    }
}

/// Reads them.
pub(crate) struct Reader<'a> {
    path: &'a Path,
    rows: &'a mut dyn Rows,
    row: Row,
    pub channels: Channels,
    part: Part,
    /// Of the last row.
    pub values: Vec<f64>,
    /// Time of the first row, s.
    begun: Option<f64>,
    /// The longest time since then, s, and whether any row was in the part that counts.
    lasts: f64,
    any: bool,
    steps: ClockSteps,
    /// The slowest channel that must stand, and the time from sample to sample of it, s, as the first samples tell it.
    slowest: Option<(usize, f64)>,
    pub without_time: u64,
    pub wraps: Wraps,
    alternation: Alternation,
}

impl<'a> Reader<'a> {
    pub fn new(path: &'a Path, rows: &'a mut dyn Rows, mut channels: Channels, part: Part) -> Reader<'a> {
        channels.look(rows.columns());
        let values = vec![f64::NAN; channels.list.len()];
        let alternation = Alternation::new(values.len());
        let wraps = Wraps::new(channels.position_units.iter().copied());
        Reader {
            path,
            rows,
            row: Row::default(),
            channels,
            part,
            values,
            begun: None,
            lasts: 0.0,
            any: false,
            steps: ClockSteps::default(),
            slowest: None,
            without_time: 0,
            wraps,
            alternation,
        }
    }

    /// Time and number of the next row that is asked for; its values stand in `values`.
    pub fn next(&mut self) -> Result<Option<(f64, u64)>, ReadError> {
        while self.rows.read(&mut self.row)? {
            if self.channels.is_behind(self.rows.columns()) {
                self.channels.look(self.rows.columns());
            }
            let time = self.channels.read(&self.row, &mut self.values);
            if !time.is_finite() {
                self.without_time += 1;
                continue;
            }
            let since = time - *self.begun.get_or_insert(time);
            self.lasts = self.lasts.max(since);
            // A row of another topic, which says nothing of what stands and moves, may have a clock of its own.
            if self.values[..self.channels.tested()].iter().all(|value| value.is_nan()) {
                continue;
            }
            if self.part.holds(since) {
                self.any = true;
                self.steps.take(time, !self.values[0].is_nan());
                self.alternation.take(&self.values);
                self.wraps.take(&self.values[..self.channels.joints]);
                return Ok(Some((time, self.row.number)));
            }
        }
        Ok(None)
    }

    /// The first samples, and the time from sample to sample, s.
    pub fn first(&mut self) -> Result<(Samples, f64), ReadError> {
        let mut first = Samples::default();
        while !first.is_full()
            && let Some((time, row)) = self.next()?
        {
            first.push(time, row, &self.values);
        }
        self.channels.check_dates(self.path, self.rows)?;
        self.slowest = first.slowest(&self.channels);
        match self.slowest {
            Some((_, interval)) => Ok((first, interval)),
            None => {
                self.check_columns()?;
                Err(self.nothing_recorded())
            }
        }
    }

    /// How the rows so far come by their clock.
    pub fn clock(&self) -> RowClock {
        let clock = self.steps.clock(self.channels.clock());
        match self.slowest {
            Some((channel, interval)) => clock.with_slowest(&self.channels.list[channel].column, interval.recip()),
            None => clock,
        }
    }

    /// The columns whose readings go back and forth from row to row, as those of two sources.
    pub fn alternating(&mut self) -> Vec<String> {
        self.alternation.columns(&self.channels)
    }

    /// No two rows have readings and different times.
    pub fn nothing_recorded(&self) -> ReadError {
        if self.begun.is_some() && !self.any {
            let Part { from, until } = self.part;
            return ReadError::NoRowInPart { path: self.path.to_owned(), from, until, lasts: self.lasts };
        }
        ReadError::NothingRecorded { path: self.path.to_owned(), column: self.channels.clock().to_owned() }
    }

    /// Whether times are what the mapping says.
    pub fn check_dates(&self) -> Result<(), ReadError> {
        self.channels.check_dates(self.path, self.rows)
    }

    /// Whether every column was there, at the end at least.
    pub fn check_columns(&self) -> Result<(), ReadError> {
        let (path, columns) = (self.path.to_owned(), self.rows.columns().to_vec());
        match self.channels.missing() {
            None => Ok(()),
            Some(column) if self.channels.has_no_clock() => {
                Err(ReadError::NoClock { path, column: column.to_owned(), columns })
            }
            Some(column) => Err(ReadError::UnknownColumn { path, column: column.to_owned(), columns }),
        }
    }
}
