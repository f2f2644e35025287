//! How much moments count.

use std::f64::consts::TAU;

/// Length of the Hann window that passes half of the power at 1 Hz, s: `u` with `sin πu / (πu (1 − u²)) = 1/√2`.
pub const FILTER_LENGTH: f64 = 0.720_291;
/// Steps in which a filter is seen.
const STEPS: usize = 16;

/// A Hann window that may be seen through another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weighing {
    /// When it begins, s.
    pub start: f64,
    /// s.
    pub length: f64,
    /// Length of the other, s; 0 for none.
    pub filter: f64,
}

impl Weighing {
    pub fn end(&self) -> f64 {
        self.start + self.length + self.filter
    }

    /// How much a moment counts, beside others.
    pub fn at(&self, time: f64) -> f64 {
        let since = time - self.start;
        if self.filter <= 0.0 {
            return hann(since / self.length);
        }
        let through = |step: usize| {
            let share = step as f64 / STEPS as f64;
            hann(share) * hann((since - share * self.filter) / self.length)
        };
        (1..STEPS).map(through).sum::<f64>() / STEPS as f64
    }
}

/// By the share of the window that has passed.
fn hann(share: f64) -> f64 {
    if (0.0..=1.0).contains(&share) { 1.0 - (TAU * share).cos() } else { 0.0 }
}
