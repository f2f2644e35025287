//! How noisy each channel is, roughly: enough to tell a standing joint from a moving one, and an outlier from noise.
//!
//! Scatter is measured over short stretches, of which most may be motion. In motion it is larger than in a standstill, so what
//! belongs to the standstills is a low quantile of all stretches. With k degrees of freedom the scatter of a stretch that stands is
//! spread as √(χ²_k / k); of the lowest fiftieth of all stretches, the largest is then half to nine tenths of the noise, whether
//! the arm stands always or in a twentieth of the time only. Quantiles are read from counts of logarithms, so that memory does
//! not grow.

use super::block::{Block, Steps};

/// Which part of the stretches is taken to be the quietest.
const QUIETEST: f64 = 0.02;
/// Scatter of the last of these, in units of the noise.
const OF_QUIETEST: f64 = 0.65;
/// Block means in a stretch.
const STRETCH: usize = 8;
/// The least steps of so many blocks, of all, must be alike for readings to stand on a grid.
const GRID: f64 = 0.2;
/// Part of the least steps that may be less than a converter's step, by numerical error.
const LEAST: f64 = 0.01;
/// Differences less than this part of a channel's range over the recording do not matter for gravity.
const IMMATERIAL: f64 = 2e-5;
/// So do differences less than this part of the readings' size, though nothing else may be seen of a channel: means of equal numbers
/// differ by rounding errors.
const ROUNDING: f64 = 1e-12;

/// By channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scales {
    /// Noise of a sample, as far as it changes from sample to sample.
    pub sample: Vec<f64>,
    /// Noise of the mean of a block.
    pub mean: Vec<f64>,
    /// Step of the converter; 0 where none is seen.
    pub quantum: Vec<f64>,
    /// The least step from sample to sample, but for a hundredth of all; 0 where there is none.
    pub least_step: Vec<f64>,
    /// Differences that do not matter.
    pub immaterial: Vec<f64>,
}

/// Counts of what was seen so far.
#[derive(Clone, Debug)]
pub(crate) struct RoughNoise {
    channels: Vec<Seen>,
    /// Means of the last blocks, one channel after the other.
    recent: Vec<[f64; STRETCH]>,
    filled: usize,
}

#[derive(Clone, Debug)]
struct Seen {
    steps: Logarithms,
    least: Logarithms,
    scatter: Logarithms,
    range: [f64; 2],
}

impl RoughNoise {
    pub fn new(channels: usize) -> RoughNoise {
        let seen = Seen {
            steps: Logarithms::new(),
            least: Logarithms::new(),
            scatter: Logarithms::new(),
            range: [f64::INFINITY, f64::NEG_INFINITY],
        };
        RoughNoise { channels: vec![seen; channels], recent: vec![[f64::NAN; STRETCH]; channels], filled: 0 }
    }

    /// Takes a block; `follows`: whether it follows the one before without a gap.
    pub fn take(&mut self, block: &Block, steps: &[Steps], follows: bool) {
        if !follows {
            self.filled = 0;
        }
        for ((seen, recent), (sum, steps)) in
            self.channels.iter_mut().zip(&mut self.recent).zip(block.sums.iter().zip(steps))
        {
            recent[self.filled] = if sum.count > 0.0 { sum.mean } else { f64::NAN };
            if sum.count > 0.0 {
                seen.range = [seen.range[0].min(sum.mean), seen.range[1].max(sum.mean)];
            }
            if steps.noise.is_finite() {
                seen.steps.count(steps.noise);
            }
            if steps.least.is_finite() {
                seen.least.count(steps.least);
            }
        }
        self.filled += 1;
        if self.filled == STRETCH {
            self.filled = 0;
            for (seen, recent) in self.channels.iter_mut().zip(&self.recent) {
                let scatter = scatter_about_line(recent);
                if scatter.is_finite() {
                    seen.scatter.count(scatter);
                }
            }
        }
    }

    pub fn scales(&self) -> Scales {
        let mut scales = Scales::default();
        for seen in &self.channels {
            let quantum = seen.least.pile(GRID).unwrap_or(0.0);
            // A sensor on a grid may well say one number while it stands; of another that means it is not alive.
            let of = |counts: &Logarithms| counts.quantile(QUIETEST, quantum > 0.0) / OF_QUIETEST;
            scales.sample.push(of(&seen.steps));
            scales.mean.push(of(&seen.scatter));
            scales.quantum.push(quantum);
            scales.least_step.push(seen.least.quantile(LEAST, false));
            scales.immaterial.push(immaterial(seen.range));
        }
        scales
    }
}

/// Differences that do not matter in a channel of this range; 0 where nothing was seen of it.
fn immaterial([lowest, highest]: [f64; 2]) -> f64 {
    let size = lowest.abs().max(highest.abs());
    if lowest <= highest { (IMMATERIAL * (highest - lowest)).max(ROUNDING * size) } else { 0.0 }
}

/// Standard deviation of numbers about their straight line, `n − 2` degrees of freedom.
fn scatter_about_line(numbers: &[f64; STRETCH]) -> f64 {
    let middle = (STRETCH - 1) as f64 / 2.0;
    let first = numbers[0];
    let (mut sum, mut squares, mut moment, mut spread) = (0.0, 0.0, 0.0, 0.0);
    for (index, number) in numbers.iter().enumerate() {
        let (place, number) = (index as f64 - middle, number - first);
        sum += number;
        squares += number * number;
        moment += place * number;
        spread += place * place;
    }
    let left: f64 = squares - sum * sum / STRETCH as f64 - moment * moment / spread;
    if left.is_nan() { left } else { (left.max(0.0) / (STRETCH - 2) as f64).sqrt() }
}

/// Bins of an eighth of a power of two, from 2⁻⁶⁴ to 2⁶⁴; zero and what is less stands in the first.
const BINS: usize = 128 * 8;

/// How often which order of magnitude was seen.
#[derive(Clone, Debug)]
struct Logarithms {
    counts: Vec<u32>,
    total: u64,
}

impl Logarithms {
    fn new() -> Logarithms {
        Logarithms { counts: vec![0; BINS], total: 0 }
    }

    fn count(&mut self, number: f64) {
        let exponent_and_eighth = (number.to_bits() >> 49) as usize;
        let bin = exponent_and_eighth.saturating_sub((1023 - 64) * 8).min(BINS - 1);
        self.counts[bin] = self.counts[bin].saturating_add(1);
        self.total += 1;
    }

    /// The middle of a bin.
    fn number(bin: usize) -> f64 {
        if bin == 0 {
            return 0.0;
        }
        let edge = |bin: usize| f64::from_bits(((bin + (1023 - 64) * 8) as u64) << 49);
        0.5 * (edge(bin) + edge(bin + 1))
    }

    /// The bin up to which the given part of the counts stands; without the first bin unless `zero` counts.
    fn bin(&self, part: f64, zero: bool) -> usize {
        let skipped = if zero { 0 } else { u64::from(self.counts[0]) };
        let wanted = skipped as f64 + part * (self.total - skipped) as f64;
        let mut below = 0;
        let reached = |count: &u32| {
            below += u64::from(*count);
            below > skipped && below as f64 >= wanted
        };
        self.counts.iter().position(reached).unwrap_or(0)
    }

    fn quantile(&self, part: f64, zero: bool) -> f64 {
        Logarithms::number(self.bin(part, zero))
    }

    /// Where the smallest numbers pile up: at least a part `share` of all stands within an eighth of a power of two of it.
    fn pile(&self, share: f64) -> Option<f64> {
        let bin = self.bin(LEAST, false);
        let near: u64 =
            self.counts[bin.saturating_sub(1)..(bin + 2).min(BINS)].iter().map(|count| u64::from(*count)).sum();
        (bin > 0 && near as f64 >= share * self.total as f64).then(|| Logarithms::number(bin))
    }
}
