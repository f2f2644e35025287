//! The clock of a recording: its rate, its gaps and whether it runs backwards.

use serde::Serialize;

use super::names::TimeUnit;

/// First intervals, whose median is the usual one.
const FIRST: usize = 10_001;
/// An interval so many times the usual one is a gap.
const GAP: f64 = 5.0;
/// Gaps that are told one by one.
const TOLD: usize = 10;

/// The clock.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeFound {
    /// Name of its column.
    pub column: String,
    /// Unit of the column, as its name or its steps tell.
    pub unit: &'static str,
    /// First and last time, s.
    pub from_s: f64,
    /// See `from_s`.
    pub to_s: f64,
    /// Median interval between rows of different times, s.
    pub interval_s: f64,
    /// Intervals of more than five times that.
    pub gaps: u64,
    /// The first of them.
    pub first_gaps: Vec<Gap>,
    /// How often the time is less than in the row before.
    pub backwards: u64,
    /// Where it first is: the row's number in its file.
    pub first_backwards: Option<u64>,
    /// Rows without a time.
    pub missing: u64,
    /// Rows with a time, and those of them that have the time of the row before.
    pub rows: u64,
    /// See `rows`.
    pub standing: u64,
}

/// Share of the rows that have the time of the row before, from which on the clock stands; several topics have some in common.
const STANDS: f64 = 0.85;

impl TimeFound {
    /// Whether its times tell next to nothing: nearly all rows have that of the row before.
    pub fn stands(&self) -> bool {
        self.standing > 0 && self.standing as f64 > STANDS * self.rows as f64
    }
}

/// A time without rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// Where it begins, s.
    pub at_s: f64,
    /// How long it lasts, s.
    pub lasts_s: f64,
}

/// Listens to the times of rows.
#[derive(Debug, Default)]
pub(super) struct TimeWatch {
    first: Option<f64>,
    last: f64,
    latest: f64,
    /// The first intervals, with the time before each.
    intervals: Vec<(f64, f64)>,
    usual: Option<f64>,
    gaps: u64,
    first_gaps: Vec<(f64, f64)>,
    backwards: u64,
    first_backwards: Option<u64>,
    missing: u64,
    rows: u64,
    standing: u64,
}

impl TimeWatch {
    pub(super) fn take(&mut self, time: f64, row: u64) {
        if time.is_nan() {
            self.missing += 1;
            return;
        }
        self.rows += 1;
        if self.first.is_none() {
            self.first = Some(time);
            (self.last, self.latest) = (time, time);
            return;
        }
        let interval = time - self.last;
        self.standing += u64::from(interval == 0.0);
        if interval < 0.0 {
            self.backwards += 1;
            self.first_backwards.get_or_insert(row);
        } else if interval > 0.0 {
            match self.usual {
                Some(usual) => self.judge(usual, self.last, interval),
                None => self.intervals.push((self.last, interval)),
            }
            if self.intervals.len() == FIRST {
                self.settle();
            }
        }
        self.last = time;
        self.latest = self.latest.max(time);
    }

    /// The usual interval, in the unit of the column.
    pub(super) fn interval(&mut self) -> f64 {
        self.settle();
        self.usual.unwrap_or(f64::NAN)
    }

    /// Judges the first intervals by their median.
    fn settle(&mut self) {
        if self.usual.is_some() || self.intervals.is_empty() {
            return;
        }
        let mut sorted: Vec<f64> = self.intervals.iter().map(|(_, interval)| *interval).collect();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted[sorted.len() / 2];
        self.usual = Some(usual);
        for (at, interval) in std::mem::take(&mut self.intervals) {
            self.judge(usual, at, interval);
        }
    }

    fn judge(&mut self, usual: f64, at: f64, interval: f64) {
        if interval > GAP * usual {
            self.gaps += 1;
            if self.first_gaps.len() < TOLD {
                self.first_gaps.push((at, interval));
            }
        }
    }

    /// What was found; nothing where no row has a time.
    pub(super) fn found(mut self, column: &str, unit: TimeUnit) -> Option<TimeFound> {
        self.settle();
        let seconds = |time: f64| time / unit.per_second;
        let gap = |(at, lasts): &(f64, f64)| Gap { at_s: seconds(*at), lasts_s: seconds(*lasts) };
        Some(TimeFound {
            column: column.to_owned(),
            unit: unit.name,
            from_s: seconds(self.first?),
            to_s: seconds(self.latest),
            interval_s: seconds(self.usual.unwrap_or(0.0)),
            gaps: self.gaps,
            first_gaps: self.first_gaps.iter().map(gap).collect(),
            backwards: self.backwards,
            first_backwards: self.first_backwards,
            missing: self.missing,
            rows: self.rows,
            standing: self.standing,
        })
    }
}
