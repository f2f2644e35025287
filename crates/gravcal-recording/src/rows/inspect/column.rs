//! One column of a recording: its range, its rate, and whether its sensor is stuck or at an end of its range.

use std::f64::consts::PI;

use serde::Serialize;

use super::names::{Guess, Meaning, guess};

/// First intervals, whose median is the usual one.
const FIRST: usize = 1001;
/// Readings that are the same so often one after another, of a sensor whose readings mostly differ, are stuck.
const STUCK: u64 = 100;
/// So many readings that are the same at the end of the range, of such a sensor, are saturated.
const CLIPPED: u64 = 10;
/// A sensor's readings mostly differ where for each that does less than this share are equal to the one before, runs as above not
/// counted.
const MOSTLY: f64 = 0.1;

/// What is in a column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnFound {
    /// Its name.
    pub name: String,
    /// What it may mean.
    pub guess: Guess,
    /// Rows that say something of it.
    pub readings: u64,
    /// Median interval between these, s (in rows, where there is no clock).
    pub interval_s: f64,
    /// Smallest and largest reading.
    pub lowest: f64,
    /// See `lowest`.
    pub highest: f64,
    /// Whether all readings are whole numbers.
    pub whole: bool,
    /// Where it was stuck the longest, if it was.
    pub stuck: Option<Stuck>,
    /// Where it seems to be at an end of its range.
    pub clipped: Vec<Clipped>,
    /// Whether every reading is more than the one before, as a clock's.
    pub rises: bool,
    /// Of an angle, how often it jumps by about a full turn from one reading to the next.
    pub wraps: u64,
}

/// A time during which nothing changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stuck {
    /// The reading.
    pub at: f64,
    /// When it begins, s.
    pub from_s: f64,
    /// How many readings it lasts.
    pub readings: u64,
}

/// An end of the range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clipped {
    /// The reading there.
    pub at: f64,
    /// How many readings are there.
    pub readings: u64,
}

/// Listens to a column.
#[derive(Debug)]
pub(super) struct ColumnWatch {
    readings: u64,
    last_time: f64,
    intervals: Vec<f64>,
    lowest: End,
    highest: End,
    whole: bool,
    /// The present run of equal readings, and the longest one.
    run: Stuck,
    longest: Stuck,
    /// Readings equal to the one before, in runs shorter than those that are stuck, and readings that differ from it.
    equal: u64,
    changes: u64,
    last: f64,
    /// Readings that are not more than the one before.
    falls: u64,
    /// Jumps by about each of [`TURNS`].
    jumps: [u64; 2],
}

/// A full turn in rad and in degrees, and the share of it by which a reading jumps where an angle wraps: no joint turns by the rest from
/// one reading to the next.
const TURNS: [f64; 2] = [2.0 * PI, 360.0];
const WRAPS: [f64; 2] = [0.95, 1.01];

/// An extreme, and how many readings are there.
#[derive(Clone, Copy, Debug, Default)]
struct End {
    at: f64,
    readings: u64,
}

impl End {
    fn take(&mut self, reading: f64, beyond: bool) {
        match beyond {
            true => *self = End { at: reading, readings: 1 },
            false => self.readings += u64::from(reading == self.at),
        }
    }
}

impl Default for ColumnWatch {
    fn default() -> ColumnWatch {
        let none = Stuck { at: f64::NAN, from_s: 0.0, readings: 0 };
        ColumnWatch {
            readings: 0,
            last_time: f64::NAN,
            intervals: Vec::new(),
            lowest: End::default(),
            highest: End::default(),
            whole: true,
            run: none,
            longest: none,
            equal: 0,
            changes: 0,
            last: f64::NAN,
            falls: 0,
            jumps: [0; 2],
        }
    }
}

impl ColumnWatch {
    /// `rests`: whether the arm rests, as all position sensors say, which then tells nothing of this one.
    pub(super) fn take(&mut self, time: f64, reading: f64, rests: bool) {
        if reading.is_nan() {
            return;
        }
        self.readings += 1;
        let interval = time - self.last_time;
        if self.intervals.len() < FIRST && interval > 0.0 {
            self.intervals.push(interval);
        }
        self.last_time = time;
        let step = reading - std::mem::replace(&mut self.last, reading);
        self.falls += u64::from(step <= 0.0);
        for (jumps, turn) in self.jumps.iter_mut().zip(TURNS) {
            *jumps += u64::from((WRAPS[0] * turn..WRAPS[1] * turn).contains(&step.abs()));
        }
        if rests && reading == self.run.at {
            return;
        }
        let first = self.readings == 1;
        self.lowest.take(reading, first || reading < self.lowest.at);
        self.highest.take(reading, first || reading > self.highest.at);
        self.whole &= reading.fract() == 0.0;
        match reading == self.run.at {
            true => self.run.readings += 1,
            false => {
                self.changes += 1;
                self.end_run();
                self.run = Stuck { at: reading, from_s: time, readings: 1 };
            }
        }
    }

    fn end_run(&mut self) {
        if self.run.readings < STUCK {
            self.equal += self.run.readings.saturating_sub(1);
        }
        if self.run.readings > self.longest.readings {
            self.longest = self.run;
        }
    }

    /// What was found; times had so many units a second.
    pub(super) fn found(mut self, name: &str, per_second: f64) -> ColumnFound {
        self.end_run();
        self.intervals.sort_by(f64::total_cmp);
        let interval = self.intervals.get(self.intervals.len() / 2).map_or(0.0, |interval| interval / per_second);
        let [lowest, highest] =
            [self.lowest, self.highest].map(|end| if self.readings == 0 { f64::NAN } else { end.at });
        let varied = self.changes >= STUCK && (self.equal as f64) < MOSTLY * self.changes as f64;
        let constant = self.readings > 1 && lowest == highest;
        let is_stuck = constant || varied && self.longest.readings >= STUCK;
        let clipped =
            |end: &End| (varied && end.readings >= CLIPPED).then_some(Clipped { at: end.at, readings: end.readings });
        let guess = guess(name, lowest, highest, self.whole);
        let turn = match (guess.meaning, guess.unit) {
            (Some(Meaning::Position), Some("rad")) => Some(0),
            (Some(Meaning::Position), Some("deg")) => Some(1),
            _ => None,
        };
        ColumnFound {
            name: name.to_owned(),
            guess,
            readings: self.readings,
            interval_s: interval,
            lowest,
            highest,
            whole: self.whole && self.readings > 0,
            stuck: is_stuck.then_some(Stuck { from_s: self.longest.from_s / per_second, ..self.longest }),
            clipped: [self.lowest, self.highest].iter().filter_map(clipped).collect(),
            rises: self.readings > 1 && self.falls == 0,
            wraps: turn.map_or(0, |turn| self.jumps[turn]),
        }
    }
}
