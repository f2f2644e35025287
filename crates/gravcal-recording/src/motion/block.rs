//! Samples become blocks: the mean and the scatter of every channel over a hundredth of a second or so.
//!
//! Before a sample counts, it is compared with the median of the five samples around it. In steady noise and in any monotonous
//! motion the two are alike; a sample that is further off than the noise explains is an outlier, and left out.
//!
//! This is the one part that sees every sample, so it is written in groups of channels that the processor takes at once.

use super::channels::Channels;

/// Channels that are treated together.
const WIDTH: usize = 4;

/// Blocks in which every step is looked at, and then one of so many.
const WATCHED: u64 = 1024;
const OF_BLOCKS: u64 = 8;

type Group = [f64; WIDTH];

/// What one channel said during a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sum {
    /// Samples that count.
    pub count: f64,
    /// Their mean; nothing where there are none.
    pub mean: f64,
    /// Sum of the squares of their distances from it.
    pub squares: f64,
    /// How many were at an end of the sensor's range.
    pub ends: f64,
}

impl Sum {
    /// Two sums in one.
    pub fn join(self, other: Sum) -> Sum {
        if self.count == 0.0 || other.count == 0.0 {
            return if self.count == 0.0 { other } else { self };
        }
        let count = self.count + other.count;
        let step = other.mean - self.mean;
        Sum {
            count,
            mean: self.mean + step * other.count / count,
            squares: self.squares + other.squares + step * step * self.count * other.count / count,
            ends: self.ends + other.ends,
        }
    }
}

/// Some successive samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// Time of the first sample, s.
    pub from: f64,
    /// Time of the last sample, s.
    pub until: f64,
    /// Where the first one stands in its file.
    pub row: u64,
    /// By channel.
    pub sums: Vec<Sum>,
}

impl Block {
    /// Two successive blocks as one.
    pub fn join(&mut self, next: &Block) {
        self.until = next.until;
        for (sum, other) in self.sums.iter_mut().zip(&next.sums) {
            *sum = sum.join(*other);
        }
    }
}

/// What the steps from sample to sample say of a channel's noise during a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steps {
    /// Root mean square of the steps, over √2: the noise of a sample if noise is white and nothing moves.
    pub noise: f64,
    /// The least step that is none of zero; infinite where there is none.
    pub least: f64,
}

/// Channels in groups of [`WIDTH`]; those that fill up the last group are always 0.
#[derive(Clone, Debug)]
struct Lanes {
    /// The last five samples, the newest at the end.
    last: [Group; 5],
    /// Whether every channel has said something.
    is_full: bool,
    limit: Group,
    lowest: Group,
    highest: Group,
    reference: Group,
    count: Group,
    sum: Group,
    squares: Group,
    ends: Group,
    samples: Group,
    steps: Group,
    least: Group,
}

impl Lanes {
    fn new() -> Lanes {
        let zero = [0.0; WIDTH];
        Lanes {
            last: [[f64::NAN; WIDTH]; 5],
            is_full: false,
            limit: [f64::INFINITY; WIDTH],
            lowest: [f64::NEG_INFINITY; WIDTH],
            highest: [f64::INFINITY; WIDTH],
            reference: zero,
            count: zero,
            sum: zero,
            squares: zero,
            ends: zero,
            samples: zero,
            steps: zero,
            least: [f64::INFINITY; WIDTH],
        }
    }

    fn take(&mut self, values: &Group, watched: bool) {
        if self.is_full && values.iter().all(|value| !value.is_nan()) {
            self.take_all(values);
            if watched {
                (0..WIDTH).for_each(|i| self.count_step(i, values[i] - self.last[3][i]));
            }
        } else {
            (0..WIDTH).filter(|i| !values[*i].is_nan()).for_each(|i| self.take_one(i, values[i]));
            self.is_full = self.last[4].iter().all(|newest| !newest.is_nan());
        }
    }

    /// All channels say something, and have done so before: nothing to decide, so that the processor takes them at once.
    #[inline(always)]
    fn take_all(&mut self, values: &Group) {
        let [_, a, b, c, d] = self.last;
        self.last = [a, b, c, d, *values];
        for i in 0..WIDTH {
            self.count(i, [a[i], b[i], c[i], d[i], values[i]]);
        }
    }

    fn take_one(&mut self, i: usize, new: f64) {
        let newest = self.last[4][i];
        let is_first = newest.is_nan();
        for (older, newer) in (0..4).zip(1..5) {
            self.last[older][i] = if is_first { new } else { self.last[newer][i] };
        }
        self.last[4][i] = new;
        let step = if is_first { 0.0 } else { new - newest };
        self.count(i, [0, 1, 2, 3, 4].map(|place: usize| self.last[place][i]));
        self.count_step(i, step);
    }

    /// Counts the middle one of five successive samples of channel `i`.
    #[inline(always)]
    fn count(&mut self, i: usize, [a, b, c, d, e]: [f64; 5]) {
        let low = max(min(a, b), min(d, e));
        let high = min(max(a, b), max(d, e));
        let median = max(min(low, high), min(max(low, high), c));
        let weight = if (c - median).abs() <= self.limit[i] { 1.0 } else { 0.0 };
        let distance = weight * (c - self.reference[i]);
        self.count[i] += weight;
        self.sum[i] += distance;
        self.squares[i] += distance * distance;
        let below = if c <= self.lowest[i] { weight } else { 0.0 };
        let above = if c >= self.highest[i] { weight } else { 0.0 };
        self.ends[i] += below + above;
    }

    /// Counts the step between the last two samples of channel `i`.
    #[inline(always)]
    fn count_step(&mut self, i: usize, step: f64) {
        let size = step.abs();
        self.samples[i] += 1.0;
        self.steps[i] += step * step;
        self.least[i] = min(self.least[i], if size > 0.0 { size } else { f64::INFINITY });
    }

    /// What channel `i` said since the last time, and begins anew.
    fn finish(&mut self, i: usize) -> (Sum, Steps) {
        let count = self.count[i];
        let offset = if count > 0.0 { self.sum[i] / count } else { 0.0 };
        let mean = self.reference[i] + offset;
        let squares = (self.squares[i] - count * offset * offset).max(0.0);
        let sum = Sum { count, mean, squares, ends: self.ends[i] };
        let steps = Steps { noise: (self.steps[i] / (2.0 * self.samples[i])).sqrt(), least: self.least[i] };
        self.reference[i] = if count > 0.0 { mean } else { self.reference[i] };
        for total in
            [&mut self.count, &mut self.sum, &mut self.squares, &mut self.ends, &mut self.samples, &mut self.steps]
        {
            total[i] = 0.0;
        }
        self.least[i] = f64::INFINITY;
        (sum, steps)
    }
}

/// Unlike `f64::min` and `max` these are one instruction; what they make of NaN does not matter here.
#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Samples in, blocks out.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    lanes: Vec<Lanes>,
    values: Vec<f64>,
    channels: usize,
    /// Of a block, s.
    length: f64,
    /// Blocks so far.
    finished: u64,
    /// Time of the first and of the last sample, s, and where the first one stands.
    begun: Option<(f64, f64, u64)>,
}

impl Blocks {
    pub fn new(channels: &Channels, length: f64) -> Blocks {
        let count = channels.list.len();
        let mut lanes = vec![Lanes::new(); count.div_ceil(WIDTH)];
        for (index, channel) in channels.list.iter().enumerate() {
            lanes[index / WIDTH].lowest[index % WIDTH] = channel.range[0];
            lanes[index / WIDTH].highest[index % WIDTH] = channel.range[1];
        }
        Blocks { values: vec![0.0; lanes.len() * WIDTH], lanes, channels: count, length, finished: 0, begun: None }
    }

    /// How far a sample may be from the median of its neighbours, by channel.
    pub fn limit(&mut self, limits: impl Iterator<Item = f64>) {
        for (index, limit) in limits.enumerate() {
            self.lanes[index / WIDTH].limit[index % WIDTH] = limit;
        }
    }

    /// Whether a row is the last one once more.
    pub fn repeats(&self, values: &[f64]) -> bool {
        let newest = |index: usize| self.lanes[index / WIDTH].last[4][index % WIDTH];
        values.iter().enumerate().all(|(index, value)| value.is_nan() || *value == newest(index))
    }

    /// Whether the block that has begun ends before a sample at this time.
    pub fn ends_before(&self, time: f64) -> bool {
        self.begun.is_some_and(|(from, _, _)| time - from >= self.length)
    }

    /// Takes a sample into the block that has begun, or begins one.
    pub fn take(&mut self, time: f64, row: u64, values: &[f64]) {
        self.begun = Some(self.begun.map_or((time, time, row), |(from, _, row)| (from, time, row)));
        let watched = self.finished < WATCHED || self.finished.is_multiple_of(OF_BLOCKS);
        self.values[..self.channels].copy_from_slice(values);
        for (lanes, values) in self.lanes.iter_mut().zip(self.values.as_chunks::<WIDTH>().0) {
            lanes.take(values, watched);
        }
    }

    /// Ends the block that has begun, if any.
    pub fn finish(&mut self, steps: &mut Vec<Steps>) -> Option<Block> {
        let (from, until, row) = self.begun.take()?;
        steps.clear();
        self.finished += 1;
        let mut sums = Vec::with_capacity(self.channels);
        for index in 0..self.channels {
            let (sum, step) = self.lanes[index / WIDTH].finish(index % WIDTH);
            sums.push(sum);
            steps.push(step);
        }
        Some(Block { from, until, row, sums })
    }
}
