//! Which times to believe.
//!
//! A recorder may stamp a row when it writes it, or round the stamp. Arms move smoothly: of the times that may be meant, those are
//! believed by which the positions have the smallest third differences,
//!
//! ```text
//!     Σ_k (q_k[t_k, …, t_{k+3}])²         divided differences, each joint in proportion to its own by the stamps
//! ```
//!
//! Candidates are the stamps, rows that are evenly spaced (a straight line through the stamps of each run), and stamps rounded to the
//! tick, the time from row to row of that line. Another than the stamps is believed only where it is clearly better.

use std::ops::Range;

use crate::motion::median;

/// Times from row to row, in median ones, that interrupt a recording.
const GAP: f64 = 5.0;
/// After a pause in which the recorder stalled, and no row is missing, rows come at once until one is on time again: within so many times the rows
/// that fit into the pause, and to so many median steps.
const BURST: f64 = 1.5;
const ON_TIME: f64 = 1.0;
/// A candidate is believed where its third differences are smaller than this share of those by the stamps.
const BETTER: f64 = 0.9;

/// A row that comes so often again is that of an arm that stands.
const STANDS: u64 = 20;

/// Which times are believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clock {
    /// Those that the recorder stamped.
    #[default]
    Stamps,
    /// Rows are evenly spaced.
    Even,
    /// Stamps, rounded to a whole number of steps.
    Rounded,
}

/// What was recorded, row by row.
#[derive(Clone, Debug)]
pub(super) struct Recorded {
    pub times: Vec<f64>,
    pub rows: Vec<u64>,
    /// So many a row.
    pub values: Vec<f64>,
    pub joints: usize,
    pub width: usize,
    tested: usize,
    pub repeated: u64,
    pub empty: u64,
    /// Rows in a row that repeated the last one.
    repeats: u64,
}

impl Recorded {
    /// `tested`: how many of the values, the first, tell a row from one that repeats it.
    pub fn new(joints: usize, width: usize, tested: usize) -> Recorded {
        Recorded {
            times: Vec::new(),
            rows: Vec::new(),
            values: Vec::new(),
            joints,
            width,
            tested,
            repeated: 0,
            empty: 0,
            repeats: 0,
        }
    }

    /// Takes a row, unless it repeats the one before, or is empty; the times, where they run backwards. Rows of one time that are no repeats wait for
    /// [`spread_equal_times`](Self::spread_equal_times).
    pub fn push(&mut self, time: f64, row: u64, values: &[f64]) -> Result<(), (f64, f64)> {
        if values[..self.joints].iter().any(|value| value.is_nan()) {
            return Ok(());
        }
        if let Some(before) = self.times.last() {
            if time < *before {
                return Err((*before, time));
            }
            let last = &self.values[self.values.len() - self.width..][..self.tested];
            // No arm that moves has every position and every torque at exactly zero.
            let is_empty = values[..self.tested].iter().all(|value| *value == 0.0);
            if is_empty && self.tested > 1 && last.iter().all(|value| *value != 0.0) {
                self.empty += 1;
                return Ok(());
            }
            let same = last.iter().zip(values).all(|(a, b)| a.to_bits() == b.to_bits());
            if same && (time == *before || (self.moves(last) && self.repeats < STANDS)) {
                self.repeated += 1;
                self.repeats += 1;
                return Ok(());
            }
        }
        self.repeats = 0;
        self.times.push(time);
        self.rows.push(row);
        self.values.extend_from_slice(values);
        Ok(())
    }

    /// Whether readings differ from those of the row before: an arm that stands without noise repeats nothing.
    fn moves(&self, last: &[f64]) -> bool {
        let before =
            self.values.len().checked_sub(2 * self.width).map(|start| &self.values[start..start + self.tested]);
        before.is_some_and(|before| before != last)
    }

    /// Spreads rows that a recorder stamped alike as it wrote them at once over the time since the row before, none farther apart than rows are on the median:
    /// the last of them keeps its stamp.
    pub fn spread_equal_times(&mut self) {
        let groups: Vec<Range<usize>> = self.equal_times().collect();
        if groups.len() == self.len() {
            return;
        }
        let since = |group: &Range<usize>| -> Option<f64> {
            let before = group.start.checked_sub(1)?;
            Some((self.times[group.start] - self.times[before]) / group.len() as f64)
        };
        let steps: Vec<f64> =
            groups.iter().flat_map(|group| since(group).map(|step| vec![step; group.len()])).flatten().collect();
        let Some(typical) = (!steps.is_empty()).then(|| median(steps)) else { return };
        let spread: Vec<f64> = groups
            .iter()
            .flat_map(|group| {
                let (last, step) = (self.times[group.start], since(group).map_or(typical, |step| step.min(typical)));
                (0..group.len()).rev().map(move |behind| last - step * behind as f64).collect::<Vec<_>>()
            })
            .collect();
        self.times = spread;
    }

    /// Rows one after the other that have the same time.
    fn equal_times(&self) -> impl Iterator<Item = Range<usize>> {
        let mut start = 0;
        self.times.chunk_by(|a, b| a == b).map(move |group| {
            start += group.len();
            start - group.len()..start
        })
    }

    pub fn len(&self) -> usize {
        self.times.len()
    }

    pub fn value(&self, row: usize, channel: usize) -> f64 {
        self.values[row * self.width + channel]
    }

    pub fn add(&mut self, row: usize, channel: usize, more: f64) {
        self.values[row * self.width + channel] += more;
    }

    /// Median time from row to row, s.
    pub fn interval(&self) -> Option<f64> {
        let steps: Vec<f64> = self.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        (!steps.is_empty()).then(|| median(steps))
    }

    /// Ranges of rows without a gap between them.
    pub fn runs(&self) -> Vec<Range<usize>> {
        let interval = self.interval().unwrap_or(0.0);
        let mut starts = vec![0];
        starts.extend((1..self.len()).filter(|row| self.interrupts(*row, interval)));
        starts.push(self.len());
        starts.windows(2).map(|pair| pair[0]..pair[1]).filter(|run| !run.is_empty()).collect()
    }

    /// Whether rows are missing before one. `interval`: the median time from row to row, s.
    fn interrupts(&self, row: usize, interval: f64) -> bool {
        let pause = self.times[row] - self.times[row - 1];
        if pause <= GAP * interval {
            return false;
        }
        let late = |ahead: usize| self.times[row + ahead] - self.times[row - 1] - (ahead + 1) as f64 * interval;
        let burst = ((BURST * pause / interval) as usize).min(self.len() - 1 - row);
        !(1..=burst).any(|ahead| late(ahead) < ON_TIME * interval)
    }

    /// Finds the clock, and takes its times.
    pub fn find_clock(&mut self) -> Clock {
        let runs = self.runs();
        let candidates = [(Clock::Even, self.even(&runs)), (Clock::Rounded, self.rounded(&runs))];
        let by_stamps = self.roughness(&runs, &self.times);
        let relative = |times: &[f64]| {
            let rough = self.roughness(&runs, times);
            let shares = rough.iter().zip(&by_stamps).filter(|(_, stamps)| **stamps > 0.0);
            let shares: Vec<f64> = shares.map(|(own, stamps)| (own / stamps).max(1e-300).ln()).collect();
            if shares.is_empty() { 1.0 } else { (0.5 * shares.iter().sum::<f64>() / shares.len() as f64).exp() }
        };
        let shares: Vec<f64> = candidates.iter().map(|(_, times)| relative(times)).collect();
        let best = if shares[1] < BETTER * shares[0] { 1 } else { 0 };
        if shares[best] >= BETTER {
            return Clock::Stamps;
        }
        let [even, rounded] = candidates;
        let (clock, times) = if best == 0 { even } else { rounded };
        self.times = times;
        clock
    }

    /// Sums of squared third differences of each joint's positions.
    fn roughness(&self, runs: &[Range<usize>], times: &[f64]) -> Vec<f64> {
        let of_joint = |joint: usize| {
            let quadruples = runs.iter().flat_map(|run| run.clone().take(run.len().saturating_sub(3)));
            quadruples.map(|row| third_difference(times, row, |row| self.value(row, joint)).powi(2)).sum()
        };
        (0..self.joints).map(of_joint).collect()
    }

    fn even(&self, runs: &[Range<usize>]) -> Vec<f64> {
        let mut times = self.times.clone();
        for run in runs {
            let (first, step) = line(&self.times[run.clone()]);
            run.clone().for_each(|row| times[row] = first + step * (row - run.start) as f64);
        }
        times
    }

    fn rounded(&self, runs: &[Range<usize>]) -> Vec<f64> {
        let mut times = self.times.clone();
        for run in runs {
            let stamps = &self.times[run.clone()];
            let steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
            if steps.is_empty() {
                continue;
            }
            let tick = median(steps);
            let mut number = 0.0;
            let mut numbers = vec![0.0];
            for pair in stamps.windows(2) {
                number += ((pair[1] - pair[0]) / tick).round().max(1.0);
                numbers.push(number);
            }
            let (first, step) = line_over(&numbers, stamps);
            run.clone().zip(&numbers).for_each(|(row, number)| times[row] = first + step * number);
        }
        times
    }
}

/// Start and step of the straight line through values one after the other.
fn line(values: &[f64]) -> (f64, f64) {
    let numbers: Vec<f64> = (0..values.len()).map(|number| number as f64).collect();
    line_over(&numbers, values)
}

fn line_over(numbers: &[f64], values: &[f64]) -> (f64, f64) {
    let count = numbers.len() as f64;
    let origin = values.first().copied().unwrap_or(0.0);
    let (mean, middle) =
        (numbers.iter().sum::<f64>() / count, values.iter().map(|value| value - origin).sum::<f64>() / count);
    let across: f64 = numbers.iter().zip(values).map(|(n, value)| (n - mean) * (value - origin - middle)).sum();
    let along: f64 = numbers.iter().map(|n| (n - mean).powi(2)).sum();
    let step = if along > 0.0 { across / along } else { 0.0 };
    (origin + middle - step * mean, step)
}

/// `q[t_k, …, t_{k+3}]`.
fn third_difference(times: &[f64], row: usize, value: impl Fn(usize) -> f64) -> f64 {
    let mut table: Vec<f64> = (row..row + 4).map(value).collect();
    for order in 1..4 {
        for place in 0..4 - order {
            table[place] = (table[place + 1] - table[place]) / (times[row + place + order] - times[row + place]);
        }
    }
    table[0]
}
