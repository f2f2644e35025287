//! Samples in, runs out: everything that sees the whole recording, in memory that does not grow with it.
//!
//! The first samples are looked at twice: how often each channel is sampled and how noisy it is must be known before the first
//! run is found.

use super::block::{Blocks, Steps};
use super::channels::Channels;
use super::judge::LEAST_BLOCKS;
use super::mean_noise::median;
use super::rough_noise::{RoughNoise, Scales};
use super::run::{Run, Runs};

/// Samples that are looked at twice.
pub(super) const FIRST: usize = 8192;
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
pub(super) struct Samples {
    times: Vec<f64>,
    rows: Vec<u64>,
    values: Vec<f64>,
}

impl Samples {
    pub fn len(&self) -> usize {
        self.times.len()
    }

    pub fn push(&mut self, time: f64, row: u64, values: &[f64]) {
        self.times.push(time);
        self.rows.push(row);
        self.values.extend_from_slice(values);
    }

    fn iter(&self, channels: usize) -> impl Iterator<Item = (f64, u64, &[f64])> {
        self.times.iter().zip(&self.rows).zip(self.values.chunks_exact(channels)).map(|((t, row), v)| (*t, *row, v))
    }

    /// Median time from sample to sample of the slowest channel that must stand and says anything, s.
    pub fn interval(&self, channels: &Channels) -> Option<f64> {
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
        (0..channels.tested()).filter_map(of).reduce(f64::max)
    }
}

/// How much of the recording could be used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Usage {
    pub samples: u64,
    pub repeated: u64,
    pub interruptions: u64,
}

/// Finds runs in samples.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    joints: usize,
    blocks: Blocks,
    steps: Vec<Steps>,
    rough: RoughNoise,
    pub scales: Scales,
    gates: Vec<f64>,
    runs: Runs,
    /// Length of a block, s, and how many samples of the slowest channel it holds.
    length: f64,
    samples_per_block: f64,
    last: Option<f64>,
    follows: bool,
    seen: u64,
    /// Blocks after which `scales` are to be found anew.
    next: u64,
    pub usage: Usage,
}

impl Segments {
    /// Made for a recording that begins with these samples, which it has not yet taken. `interval`: from sample to sample, s.
    pub fn new(channels: &Channels, first: &Samples, interval: f64) -> Segments {
        let length = BLOCK.max(SAMPLES * interval);
        let empty = Segments {
            joints: channels.joints,
            blocks: Blocks::new(channels, length),
            steps: Vec::new(),
            rough: RoughNoise::new(channels.list.len()),
            scales: Scales::default(),
            gates: vec![f64::INFINITY; channels.joints],
            runs: Runs::new(channels.joints),
            length,
            samples_per_block: length / interval,
            last: None,
            follows: false,
            seen: 0,
            next: u64::MAX,
            usage: Usage::default(),
        };
        let mut scout = empty.clone();
        let mut runs = Vec::new();
        first.iter(channels.list.len()).for_each(|(time, row, values)| scout.take(time, row, values, &mut runs));
        scout.finish(&mut runs);
        let mut segments = Segments { next: 2 * scout.seen, ..empty };
        segments.learn(scout.rough.scales());
        segments
    }

    /// Takes the first samples.
    pub fn take_first(&mut self, first: &Samples, channels: usize, runs: &mut Vec<Run>) {
        first.iter(channels).for_each(|(time, row, values)| self.take(time, row, values, runs));
    }

    /// Takes a sample; a run that ends is added to `runs`.
    pub fn take(&mut self, time: f64, row: u64, values: &[f64], runs: &mut Vec<Run>) {
        if let Some(last) = self.last {
            let step = time - last;
            if step == 0.0 && self.blocks.repeats(values) {
                self.usage.repeated += 1;
                return;
            }
            if step.abs() > GAP * self.length {
                self.usage.interruptions += 1;
                self.finish(runs);
            } else if self.blocks.ends_before(time) {
                self.finish_block(runs);
            }
        }
        self.last = Some(time);
        self.usage.samples += 1;
        self.blocks.take(time, row, values);
    }

    /// Ends the run that is going on.
    pub fn finish(&mut self, runs: &mut Vec<Run>) {
        self.finish_block(runs);
        runs.extend(self.runs.interrupt().filter(is_long));
        self.follows = false;
    }

    /// How many samples of the slowest channel a block holds.
    pub fn samples_per_block(&self) -> f64 {
        self.samples_per_block
    }

    /// How far each joint may be from where it stays.
    pub fn gates(&self) -> &[f64] {
        &self.gates
    }

    fn finish_block(&mut self, runs: &mut Vec<Run>) {
        let Some(block) = self.blocks.finish(&mut self.steps) else { return };
        self.rough.take(&block, &self.steps, self.follows);
        self.follows = true;
        self.seen += 1;
        if self.seen >= self.next {
            self.next = self.seen + AGAIN;
            self.learn(self.rough.scales());
        }
        runs.extend(self.runs.take(block, &self.gates).filter(is_long));
    }

    fn learn(&mut self, scales: Scales) {
        self.gates = Runs::gates(self.joints, &scales);
        let limits = scales.sample.iter().zip(&scales.quantum).zip(&scales.immaterial);
        self.blocks.limit(limits.map(|((noise, quantum), immaterial)| OUTLIER * noise + 1.5 * quantum + immaterial));
        self.scales = scales;
    }
}

/// Whether a run has enough blocks to be looked at, besides its first and last.
fn is_long(run: &Run) -> bool {
    run.blocks.len() >= LEAST_BLOCKS + 2
}
