//! Samples in, blocks out, with how noisy they are.
//!
//! The first samples are looked at twice: how often each channel is sampled and how noisy it is must be known before the first
//! block counts.

use super::block::{Block, Blocks, Steps};
use super::channels::Channels;
use super::median;
use super::rough_noise::{RoughNoise, Scales};

/// Samples that are looked at twice, and the most values in them.
const FIRST: usize = 8192;
const FIRST_VALUES: usize = 1 << 21;
/// Part of the time from sample to sample by which a clock may be rounded: that must not decide to which block a sample belongs.
const ROUNDING: f64 = 0.01;
/// Shortest block, s, and how many samples of the slowest channel it holds at least.
const BLOCK: f64 = 0.01;
const SAMPLES: f64 = 4.0;
/// Blocks without a sample that interrupt the recording.
const GAP: f64 = 5.0;
/// Noise of a sample that makes an outlier.
const OUTLIER: f64 = 5.0;
/// Blocks after which the noise is asked for again.
const AGAIN: u64 = 1024;

/// Samples with their times and rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    times: Vec<f64>,
    rows: Vec<u64>,
    values: Vec<f64>,
}

impl Samples {
    /// Whether enough of them are kept.
    pub fn is_full(&self) -> bool {
        self.times.len() >= FIRST || self.values.len() >= FIRST_VALUES
    }

    pub fn push(&mut self, time: f64, row: u64, values: &[f64]) {
        self.times.push(time);
        self.rows.push(row);
        self.values.extend_from_slice(values);
    }

    fn iter(&self, channels: usize) -> impl Iterator<Item = (f64, u64, &[f64])> {
        self.times.iter().zip(&self.rows).zip(self.values.chunks_exact(channels)).map(|((t, row), v)| (*t, *row, v))
    }

    /// The slowest channel that must stand and says anything, and the median time from sample to sample of it, s.
    pub fn slowest(&self, channels: &Channels) -> Option<(usize, f64)> {
        let of = |channel: usize| {
            let says = |(_, values): &(&f64, &[f64])| !values[channel].is_nan();
            let times: Vec<f64> = self
                .times
                .iter()
                .zip(self.values.chunks_exact(channels.list.len()))
                .filter(says)
                .map(|(time, _)| *time)
                .collect();
            let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
            (!steps.is_empty()).then(|| median(steps))
        };
        let intervals = (0..channels.tested()).filter_map(|channel| Some((channel, of(channel)?)));
        intervals.reduce(|slowest, other| if other.1 > slowest.1 { other } else { slowest })
    }
}

/// How much of the recording could be used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Usage {
    pub samples: u64,
    pub repeated: u64,
    pub interruptions: u64,
}

/// What is heard from a recording.
#[derive(Debug)]
pub(crate) enum Heard<'a> {
    /// How noisy channels are is known anew.
    Scales(&'a Scales),
    /// The next block, which follows the one before without a gap.
    Block(Block),
    /// The recording is interrupted, or at its end.
    Interruption,
}

/// Makes blocks of samples.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    blocks: Blocks,
    steps: Vec<Steps>,
    rough: RoughNoise,
    pub scales: Scales,
    /// Length of a block, s, and how many samples of the slowest channel it holds.
    pub length: f64,
    pub samples_per_block: f64,
    last: Option<f64>,
    follows: bool,
    seen: u64,
    /// Blocks after which `scales` are to be found anew.
    next: u64,
    pub usage: Usage,
}

impl Sampler {
    /// Made for a recording that begins with these samples, which it has not yet taken. `interval`: from sample to sample, s.
    pub fn new(channels: &Channels, first: &Samples, interval: f64) -> Sampler {
        let length = BLOCK.max(SAMPLES * interval);
        let empty = Sampler {
            blocks: Blocks::new(channels, length - ROUNDING * interval),
            steps: Vec::new(),
            rough: RoughNoise::new(channels.list.len()),
            scales: Scales::default(),
            length,
            samples_per_block: length / interval,
            last: None,
            follows: false,
            seen: 0,
            next: u64::MAX,
            usage: Usage::default(),
        };
        let mut scout = empty.clone();
        first.iter(channels.list.len()).for_each(|(time, row, values)| scout.take(time, row, values, &mut |_| {}));
        scout.finish(&mut |_| {});
        let mut sampler = Sampler { next: 2 * scout.seen, ..empty };
        sampler.learn(scout.rough.scales());
        sampler
    }

    /// Takes the first samples.
    pub fn take_first(&mut self, first: &Samples, channels: usize, report: &mut impl FnMut(Heard<'_>)) {
        first.iter(channels).for_each(|(time, row, values)| self.take(time, row, values, report));
    }

    /// Takes a sample.
    pub fn take(&mut self, time: f64, row: u64, values: &[f64], report: &mut impl FnMut(Heard<'_>)) {
        if let Some(last) = self.last {
            let step = time - last;
            if step == 0.0 && self.blocks.repeats(values) {
                self.usage.repeated += 1;
                return;
            }
            if step.abs() > GAP * self.length {
                self.usage.interruptions += 1;
                self.finish(report);
            } else if self.blocks.ends_before(time) {
                self.finish_block(report);
            }
        }
        self.last = Some(time);
        self.usage.samples += 1;
        self.blocks.take(time, row, values);
    }

    /// Ends the block that is going on, and what it belongs to.
    pub fn finish(&mut self, report: &mut impl FnMut(Heard<'_>)) {
        self.finish_block(report);
        report(Heard::Interruption);
        self.follows = false;
    }

    fn finish_block(&mut self, report: &mut impl FnMut(Heard<'_>)) {
        let Some(block) = self.blocks.finish(&mut self.steps) else { return };
        self.rough.take(&block, &self.steps, self.follows);
        self.follows = true;
        self.seen += 1;
        if self.seen >= self.next {
            self.next = self.seen + AGAIN;
            self.learn(self.rough.scales());
            report(Heard::Scales(&self.scales));
        }
        report(Heard::Block(block));
    }

    fn learn(&mut self, scales: Scales) {
        let limits = scales.sample.iter().zip(&scales.quantum).zip(&scales.immaterial);
        self.blocks.limit(limits.map(|((noise, quantum), immaterial)| OUTLIER * noise + 1.5 * quantum + immaterial));
        self.scales = scales;
    }
}
