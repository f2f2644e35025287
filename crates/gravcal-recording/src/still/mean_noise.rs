//! How noisy means of a channel are while it stands, by how long they are.
//!
//! Of white noise with variance σ² a mean of N samples has variance σ²/N. Filtered noise is less white: its means over short
//! windows have variance A(L)/N, where A grows with the length L of the window to a plateau, σ² times the integrated
//! autocorrelation time (Flyvbjerg and Petersen, Error estimates on averages of correlated data, 1989, whose blocking this is).
//! A is found at lengths of 1, 2, 4, … blocks, from the second differences of successive windows, which no steady drift disturbs:
//!
//! ```text
//!     A(L) = mean of (m_{k−1} − 2 m_k + m_{k+1})² / (1/N_{k−1} + 4/N_k + 1/N_{k+1})
//! ```
//!
//! and as the median over runs, of which some may have been touched.

use std::collections::VecDeque;

use super::run::Run;
use crate::motion::block::{Block, Sum};
use crate::motion::median;

/// Lengths that are looked at.
const LEVELS: usize = 9;
/// Runs that are remembered.
const REMEMBERED: usize = 128;
/// Fewest differences, over all runs, from which A is told.
const ENOUGH: usize = 30;
/// Where a run is looked at: behind this part of it, as it may begin with settling.
const BEGIN: f64 = 0.4;
/// Blocks at its end that may belong to the next motion.
const END: usize = 2;

/// What the last runs said, by channel.
#[derive(Clone, Debug)]
pub(super) struct MeanNoise {
    channels: Vec<Heard>,
}

#[derive(Clone, Debug, Default)]
struct Heard {
    /// A with its number of differences, by level.
    levels: [VecDeque<(f64, usize)>; LEVELS],
    /// Variance of samples within blocks.
    sample: VecDeque<f64>,
}

/// The noise of one channel.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    /// A at windows of 2^k blocks.
    pub levels: [f64; LEVELS],
    /// Variance of samples within a block; `None` if no run has told it.
    pub sample: Option<f64>,
}

impl Curve {
    /// A of a window of so many blocks.
    pub fn of(&self, blocks: f64) -> f64 {
        let level = blocks.max(1.0).log2().floor() as usize;
        self.levels[level.min(LEVELS - 1)]
    }
}

impl MeanNoise {
    pub fn new(channels: usize) -> MeanNoise {
        MeanNoise { channels: vec![Heard::default(); channels] }
    }

    /// Listens to a run.
    pub fn hear(&mut self, run: &Run) {
        let count = run.blocks.len();
        let begin = (BEGIN * count as f64).ceil() as usize;
        let Some(blocks) = run.blocks.get(begin..count.saturating_sub(END)) else { return };
        for (channel, heard) in self.channels.iter_mut().enumerate() {
            if let Some(variance) = variance_within(blocks, channel) {
                remember(&mut heard.sample, variance);
            }
            let mut windows: Vec<Sum> = blocks.iter().map(|block| block.sums[channel]).collect();
            for level in &mut heard.levels[(run.doublings as usize).min(LEVELS - 1)..] {
                let Some(found) = from_differences(&windows) else { break };
                remember(level, found);
                windows = windows.chunks_exact(2).map(|pair| pair[0].join(pair[1])).collect();
            }
        }
    }

    /// The noise of each channel; `rough`: of the mean of a block, and how many samples a block has.
    pub fn curves(&self, rough: impl Iterator<Item = (f64, f64)>) -> Vec<Curve> {
        self.channels.iter().zip(rough).map(|(heard, rough)| heard.curve(rough)).collect()
    }
}

impl Heard {
    fn curve(&self, (rough, samples): (f64, f64)) -> Curve {
        let mut levels = [rough * rough * samples; LEVELS];
        for (index, heard) in self.levels.iter().enumerate() {
            let differences: usize = heard.iter().map(|(_, count)| count).sum();
            // Of a longer window A is not less.
            let before = index.checked_sub(1).map(|before| levels[before]);
            levels[index] = match before {
                _ if differences >= ENOUGH => {
                    let found = median(
                        heard.iter().map(|(value, count)| value / median_of_chi_squared(independent(*count))).collect(),
                    );
                    found.max(0.8 * before.unwrap_or(0.0))
                }
                Some(before) => before,
                None => levels[index],
            };
        }
        let sample = (!self.sample.is_empty()).then(|| median(self.sample.iter().copied().collect()));
        Curve { levels, sample }
    }
}

fn remember<T>(values: &mut VecDeque<T>, value: T) {
    if values.len() == REMEMBERED {
        values.pop_front();
    }
    values.push_back(value);
}

/// Median over blocks of the variance of samples within one.
pub(super) fn variance_within(blocks: &[Block], channel: usize) -> Option<f64> {
    let of = |block: &Block| {
        let sum = block.sums[channel];
        (sum.count >= 2.0).then(|| sum.squares / (sum.count - 1.0) / median_of_chi_squared(sum.count as usize - 1))
    };
    let variances: Vec<f64> = blocks.iter().filter_map(of).collect();
    (!variances.is_empty()).then(|| median(variances))
}

/// A, and of how many differences; `None` where they are too few to tell.
fn from_differences(windows: &[Sum]) -> Option<(f64, usize)> {
    let said: Vec<&Sum> = windows.iter().filter(|window| window.count > 0.0).collect();
    let difference = |three: &[&Sum]| {
        let bend = three[0].mean - 2.0 * three[1].mean + three[2].mean;
        bend.powi(2) / (1.0 / three[0].count + 4.0 / three[1].count + 1.0 / three[2].count)
    };
    let count = said.len().checked_sub(2).filter(|count| *count >= 2)?;
    Some((said.windows(3).map(difference).sum::<f64>() / count as f64, count))
}

/// Of so many second differences, which share windows, some half are independent.
fn independent(differences: usize) -> usize {
    differences.div_ceil(2)
}

/// Median of χ² over its degrees of freedom (Wilson and Hilferty).
fn median_of_chi_squared(degrees: usize) -> f64 {
    (1.0 - 2.0 / (9.0 * degrees as f64)).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(mean: f64) -> Sum {
        Sum { count: 10.0, mean, ..Sum::default() }
    }

    #[test]
    fn a_slow_drift_is_no_noise() {
        let drifting: Vec<Sum> = (0..50).map(|k| window(0.1 * f64::from(k) + f64::from(k % 2))).collect();
        let (a, count) = from_differences(&drifting).unwrap();
        assert_eq!(count, 48);
        // Bends of two, over the variance 6/10 of those of means of ten.
        assert!((a - 40.0 / 6.0).abs() < 1e-9, "{a}");
    }

    #[test]
    fn too_few_windows_tell_nothing() {
        assert_eq!(from_differences(&[window(1.0), window(2.0), window(3.0)]), None);
        let missing = [window(1.0), Sum::default(), window(2.0), Sum::default(), window(3.0)];
        assert_eq!(from_differences(&missing), None);
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
