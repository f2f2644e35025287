//! Which part of a run is a standstill, or why none is.
//!
//! Means over windows of blocks are compared with the rest of the run, in units of the noise of such means
//! ([`super::mean_noise`]): the beginning is cut off while it departs from the rest (it settles), so is the end (the next motion
//! begins). Within what is left no window may depart (something touched the arm), no position may have a slope (it moves
//! slowly), and a torque's slope must come to less than the noise of one sample (it still creeps).

use super::converter::roughness;
use super::mean_noise::{Curve, variance_within};
use super::rejected::{Reason, Rejected};
use super::run::Run;
use super::series::{Measure, Series, UNSETTLED, powers_of_two};
use crate::motion::block::Sum;
use crate::motion::rough_noise::Scales;
use crate::motion::row_clock::STANDING_SAMPLES;

/// Standard deviations of a slope that is one.
const SLOPE: f64 = 5.0;
/// Standard deviations from which on a slope widens the standard error.
const PERHAPS_A_SLOPE: f64 = 3.0;
/// A run this many times as noisy as others is no standstill.
const RESTLESS: f64 = 3.0;
/// Part of the blocks of a channel that may be outliers.
const OUTLIERS: f64 = 0.1;
/// Blocks before the first that is seen to move, in which it began to.
const GUARD: usize = 2;
/// Part of a standstill at its beginning that is left out, as it may still settle.
const UNSURE: f64 = 0.1;
/// A column says something seldom where it does so many times less often than positions do.
const SELDOM: f64 = 1.5;
/// Fewest blocks of a standstill.
pub(super) const LEAST_BLOCKS: usize = 6;

/// What a run is judged by.
pub(super) struct Judge<'a> {
    /// Names of the channels that must stand: positions, then readings.
    pub columns: Vec<&'a str>,
    pub joints: usize,
    pub curves: Vec<Curve>,
    pub scales: &'a Scales,
    /// Shortest standstill, s.
    pub least_duration: f64,
}

/// A standstill within a run.
pub(super) struct Dwell {
    /// First and last but one of its blocks.
    pub blocks: std::ops::Range<usize>,
    /// By channel that must stand.
    pub channels: Vec<Standing>,
}

/// One channel in a standstill.
pub(super) struct Standing {
    /// Of the blocks that count.
    pub sum: Sum,
    /// The blocks that count.
    pub windows: Vec<Sum>,
    /// Change from beginning to end along the straight line, and whether it may be one.
    pub drift: f64,
    pub drifts: bool,
}

impl Standing {
    /// Without what is only needed while runs are judged.
    pub fn without_windows(self) -> Standing {
        Standing { windows: Vec::new(), ..self }
    }
}

impl Judge<'_> {
    /// The standstill; nothing where the run is too short for one.
    pub fn judge(&self, run: &Run) -> Result<Option<Dwell>, Rejected> {
        let count = run.blocks.len();
        let (first, last) = (1, count.saturating_sub(1));
        if last <= first || !self.is_long(run, first, last) {
            return Ok(None);
        }
        let rejected = |reason| Rejected { interval: [run.blocks[first].from, run.blocks[last - 1].until], reason };
        let series: Vec<Series<'_>> =
            (0..self.columns.len()).map(|channel| self.series(run, channel, first, last)).collect();
        if let Some(joint) = (0..self.joints).find(|joint| series[*joint].count(first, last) == 0.0) {
            return Err(rejected(Reason::NoPosition { column: self.columns[joint].to_owned() }));
        }
        let begin = self.settled_from(&series, first, last);
        let end = self.steady_until(run, &series, begin, last);
        let begin = self.calm_from(&series, begin, end);
        let begin = if begin > first { settled_for_sure(run, begin, end) } else { begin };
        let begin = self.without_what_adds_up(run, begin, end);
        if !self.is_long(run, begin, end) {
            let touched = |channel: &usize| Some((*channel, series[*channel].comes_back(first, last)?));
            if let Some((channel, block)) = (self.joints..series.len()).find_map(|channel| touched(&channel)) {
                let (column, at) = (self.columns[channel].to_owned(), run.blocks[block].from);
                return Err(rejected(Reason::Touched { column, at }));
            }
            // What changes over its later half is what keeps it from being one.
            let (half, quarter) = (first + (last - first) / 2, first + 3 * (last - first) / 4);
            let channel = self.departing(&series, half, quarter, last).or(self.departing(&series, first, half, last));
            let channel = channel.unwrap_or(0);
            let column = self.columns[channel].to_owned();
            if channel >= self.joints {
                return Err(rejected(Reason::Settling { column }));
            }
            let short = self.short(run, &series, (first, last), &column);
            return Err(rejected(short.unwrap_or(Reason::Moving { column })));
        }
        let interval = [run.blocks[begin].from, run.blocks[end - 1].until];
        let mut channels = Vec::with_capacity(series.len());
        for (channel, series) in series.iter().enumerate() {
            let standing = self.standing(run, channel, series, begin, end);
            channels.push(standing.map_err(|reason| Rejected { interval, reason })?);
        }
        Ok(Some(Dwell { blocks: begin..end, channels }))
    }

    /// Where a column that says something seldom makes the blocks so long that few of them fall between two motions. `joint`: the column
    /// of the one that seems to move.
    fn short(&self, run: &Run, series: &[Series<'_>], (first, last): (usize, usize), joint: &str) -> Option<Reason> {
        let counts = series.iter().map(|series| series.count(first, last));
        let (channel, fewest) =
            counts.enumerate().filter(|(_, count)| *count > 0.0).min_by(|a, b| a.1.total_cmp(&b.1))?;
        let of_positions = series[..self.joints].iter().map(|series| series.count(first, last)).fold(0.0, f64::max);
        let lasts = run.blocks[last - 1].until - run.blocks[first].from;
        (fewest < STANDING_SAMPLES && SELDOM * fewest < of_positions).then(|| Reason::Short {
            column: self.columns[channel].to_owned(),
            samples: fewest as u64,
            least: STANDING_SAMPLES * lasts / fewest,
            joint: joint.to_owned(),
        })
    }

    fn is_long(&self, run: &Run, begin: usize, end: usize) -> bool {
        end >= begin + LEAST_BLOCKS && run.blocks[end - 1].until - run.blocks[begin].from >= 0.95 * self.least_duration
    }

    fn series<'b>(&'b self, run: &Run, channel: usize, first: usize, last: usize) -> Series<'b> {
        let windows: Vec<Sum> = run.blocks.iter().map(|block| block.sums[channel]).collect();
        let curve = &self.curves[channel];
        let later = &run.blocks[first + (last - first) / 2..last];
        // Readings between two steps of a converter may flicker, whatever the noise.
        let flicker = 0.25 * self.scales.quantum[channel].powi(2);
        let noisier = match (curve.sample, variance_within(later, channel)) {
            (Some(usual), Some(here)) if usual + flicker > 0.0 => (here / (usual + flicker)).max(1.0),
            _ => 1.0,
        };
        let blocks = f64::from(1 << run.doublings.min(30));
        Series::new(windows, (first, last), Measure { curve, noisier, blocks, tolerance: self.tolerance(channel) })
    }

    /// Differences of a channel that do not matter: those that do not matter for gravity, and the step of a converter that no
    /// noise smooths.
    fn tolerance(&self, channel: usize) -> f64 {
        let (quantum, variance) = (self.scales.quantum[channel], self.curves[channel].sample.unwrap_or(0.0));
        // The variance that is seen holds that of rounding.
        let noise = (variance - quantum * quantum / 12.0).max(0.0);
        let step = if quantum > 0.0 { 1.1 * quantum * roughness(quantum, noise) } else { 0.0 };
        self.scales.immaterial[channel] + step
    }

    /// The channel whose part `begin..middle` departs most from `middle..end`, by more than [`UNSETTLED`].
    fn departing(&self, series: &[Series<'_>], begin: usize, middle: usize, end: usize) -> Option<usize> {
        let departures = series.iter().map(|series| series.departure((begin, middle), (middle, end)));
        let largest = departures.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (largest.1 > UNSETTLED).then_some(largest.0)
    }

    fn settled_from(&self, series: &[Series<'_>], first: usize, last: usize) -> usize {
        let mut begin = first;
        while last - begin > LEAST_BLOCKS {
            let departs = |length: usize| self.departing(series, begin, begin + length, last).is_some();
            if !powers_of_two((last - begin) / 2).any(departs) {
                break;
            }
            begin += 1;
        }
        begin
    }

    /// A reading that swings while it settles may have the right mean over the beginning: where a window near the beginning
    /// departs, it still settles there.
    fn calm_from(&self, series: &[Series<'_>], mut begin: usize, end: usize) -> usize {
        while end > begin + LEAST_BLOCKS {
            let swings = |series: &Series<'_>| series.disturbed(begin, end).map(|(_, to)| to);
            let soon = |to: &usize| to - begin <= (end - begin) / 3;
            let Some(to) = series.iter().filter_map(swings).find(soon) else { break };
            begin = to;
        }
        begin
    }

    /// A standstill is as good without its first part, and what still settles there, unseen in any one standstill, adds up over many: of
    /// `A e^(−t/T)` the mean over the duration `D` holds `A T/D`, and `e^(−D/(10 T))` of that once a tenth is left out. What lasts so long that a tenth is not
    /// enough all standstills show together (`settling.rs`).
    fn without_what_adds_up(&self, run: &Run, begin: usize, end: usize) -> usize {
        let part = ((end - begin) as f64 * UNSURE).ceil() as usize;
        let part = if run.interrupted[0] { 0 } else { part };
        (begin..=begin + part).rev().find(|begin| self.is_long(run, *begin, end)).unwrap_or(begin)
    }

    fn steady_until(&self, run: &Run, series: &[Series<'_>], begin: usize, last: usize) -> usize {
        let mut end = last;
        while end - begin > LEAST_BLOCKS {
            let departs = |length: usize| {
                let departs =
                    |series: &Series<'_>| series.departure((end - length, end), (begin, end - length)) > UNSETTLED;
                series.iter().any(departs)
            };
            if !powers_of_two(((end - begin) / 4).max(1)).any(departs) {
                break;
            }
            end -= 1;
        }
        // Where no joint moves, a long part that departs is no beginning of a motion.
        let moves = |series: &Series<'_>| series.departure((end, last), (begin, end)) > UNSETTLED;
        if last - end > (last - begin) / 6 && !run.interrupted[1] && !series[..self.joints].iter().any(moves) {
            return last;
        }
        let guard = if run.interrupted[1] || run.doublings > 0 { 0 } else { GUARD };
        end.saturating_sub(guard).max(begin)
    }

    fn standing(
        &self,
        run: &Run,
        channel: usize,
        series: &Series<'_>,
        begin: usize,
        end: usize,
    ) -> Result<Standing, Reason> {
        let column = || self.columns[channel].to_owned();
        let is_position = channel < self.joints;
        let outliers = series.outlier[begin..end].iter().filter(|outlier| **outlier).count();
        let blocks = end - begin;
        if series.measure.noisier > RESTLESS * RESTLESS || outliers as f64 > (OUTLIERS * blocks as f64).max(1.0) {
            return Err(Reason::Restless { column: column() });
        }
        if series.disturbed(begin, end).is_some() {
            let at = run.blocks[series.farthest(begin, end)].from;
            return Err(if is_position {
                Reason::Moving { column: column() }
            } else {
                Reason::Touched { column: column(), at }
            });
        }
        let counted: Vec<(f64, Sum)> = (begin..end)
            .filter(|index| !series.outlier[*index] && series.windows[*index].count > 0.0)
            .map(|index| (0.5 * (run.blocks[index].from + run.blocks[index].until), series.windows[index]))
            .collect();
        let windows: Vec<Sum> = counted.iter().map(|(_, sum)| *sum).collect();
        let sum = windows.iter().fold(Sum::default(), |all, sum| all.join(*sum));
        let duration = run.blocks[end - 1].until - run.blocks[begin].from;
        let (drift, error) = drift(&counted, duration, |count| series.std(count, blocks as f64));
        let sample = if sum.count > 1.0 { (sum.squares / (sum.count - 1.0)).sqrt() } else { 0.0 };
        let size = drift.abs() - series.measure.tolerance;
        if is_position && size > SLOPE * error {
            return Err(Reason::Moving { column: column() });
        }
        if !is_position && size > SLOPE * error && size > sample {
            return Err(Reason::Drifting { column: column(), per_second: drift / duration });
        }
        Ok(Standing { sum, windows, drift, drifts: size > PERHAPS_A_SLOPE * error })
    }
}

/// What has just become too little to be seen is given as much time again since the arm moved: over many poses it would add up.
fn settled_for_sure(run: &Run, begin: usize, end: usize) -> usize {
    let from = run.blocks[begin].from;
    let latest = begin + (end - begin) / 3;
    (begin..latest).find(|block| run.blocks[*block].from - from >= from - run.moved_until).unwrap_or(latest)
}

/// Change over a time along the least-squares line through blocks, and its standard deviation; `std`: of a mean of so many
/// samples.
fn drift(blocks: &[(f64, Sum)], duration: f64, std: impl Fn(f64) -> f64) -> (f64, f64) {
    let total: f64 = blocks.iter().map(|(_, sum)| sum.count).sum();
    let mean = |value: &dyn Fn(&(f64, Sum)) -> f64| {
        blocks.iter().map(|block| block.1.count * value(block)).sum::<f64>() / total
    };
    let (time, level) = (mean(&|block| block.0), mean(&|block| block.1.mean));
    let spread = mean(&|block| (block.0 - time).powi(2));
    if blocks.len() < 3 || spread <= 0.0 {
        return (0.0, 0.0);
    }
    let slope = mean(&|block| (block.0 - time) * (block.1.mean - level)) / spread;
    (slope * duration, std(total) / spread.sqrt() * duration)
}
