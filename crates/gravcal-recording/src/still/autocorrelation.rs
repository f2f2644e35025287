//! How many independent samples a mean is worth: the integrated autocorrelation time of each channel, from all standstills.
//!
//! ```text
//!     std(m)² = τ s² / N         s² variance of samples, N their number, N / τ the effective number
//! ```
//!
//! Within each standstill the variance of means over windows of L samples, times L and over s², grows with L to τ (Flyvbjerg and
//! Petersen, 1989); it is summed over all standstills, and τ is where it does not grow any more by more than its error.

use crate::motion::block::Sum;

/// Window lengths that are looked at: 2^k blocks.
const LEVELS: usize = 12;
/// Fewest degrees of freedom from which growth is told.
const ENOUGH: f64 = 20.0;

/// Sums over standstills, by channel and window length: of ratios times degrees of freedom, and of these.
#[derive(Clone, Debug)]
pub(super) struct Autocorrelation {
    channels: Vec<[(f64, f64); LEVELS]>,
}

impl Autocorrelation {
    pub fn new(channels: usize) -> Autocorrelation {
        Autocorrelation { channels: vec![[(0.0, 0.0); LEVELS]; channels] }
    }

    /// Takes the windows of a standstill, each of 2^`doublings` blocks, and the variance of its samples.
    pub fn take(&mut self, channel: usize, windows: &[Sum], doublings: u32, variance: f64) {
        if variance <= 0.0 {
            return;
        }
        let mut windows = windows.to_vec();
        for (ratio, degrees) in self.channels[channel].iter_mut().skip(doublings as usize) {
            if windows.len() < 2 {
                break;
            }
            let mean = windows.iter().fold(Sum::default(), |all, sum| all.join(*sum)).mean;
            let squares: f64 = windows.iter().map(|sum| sum.count * (sum.mean - mean).powi(2)).sum();
            *ratio += squares / variance;
            *degrees += windows.len() as f64 - 1.0;
            windows = windows.chunks_exact(2).map(|pair| pair[0].join(pair[1])).collect();
        }
    }

    /// τ, in samples; at least 1.
    pub fn time(&self, channel: usize) -> f64 {
        let reported: Vec<(f64, f64)> = self.channels[channel]
            .iter()
            .filter(|(_, degrees)| *degrees >= ENOUGH)
            .map(|(sum, degrees)| (sum / degrees, *degrees))
            .collect();
        let Some((first, _)) = reported.first() else { return self.few(channel) };
        let mut time = *first;
        let mut growth = 0.0;
        for (next, degrees) in &reported[1..] {
            if *next <= time * (1.0 + 2.0 * (2.0 / degrees).sqrt()) {
                growth = 0.0;
                break;
            }
            growth = next - time;
            time = *next;
        }
        // Where it still grows at the last length, what is missing halves with each doubling of the length.
        (time + growth).max(1.0)
    }

    /// The largest ratio that a single short standstill shows.
    fn few(&self, channel: usize) -> f64 {
        let ratios = self.channels[channel].iter().filter(|(_, degrees)| *degrees >= 4.0);
        ratios.map(|(sum, degrees)| sum / degrees).fold(1.0, f64::max)
    }
}
