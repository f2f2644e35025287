//! How noisy the readings of blocks are while a joint sweeps: from their scatter about the lines of all bins together.
//!
//! With noise of first order from block to block, correlation ρ, the variance of a mean of n blocks is `σ² (1 + ρ) / (1 − ρ) / n`;
//! and of steps of that noise, `E[(e_{k+1} − e_k)²] = 2 σ² (1 − ρ)`.

use super::line::Line;

/// Largest correlation from block to block that is believed.
const MOST: f64 = 0.95;

/// Sums over bins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BlockNoise {
    squares: f64,
    degrees: f64,
    stepped: f64,
    steps: f64,
}

impl BlockNoise {
    pub fn hear(&mut self, line: &Line) {
        let ((squares, degrees), (stepped, steps)) = (line.squares(), line.stepped());
        if degrees >= 1.0 {
            self.squares += squares;
            self.degrees += degrees;
            self.stepped += stepped;
            self.steps += steps;
        }
    }

    /// Variance of a block that, of independent blocks, would give means the variance that they have.
    pub fn variance(&self) -> f64 {
        if self.degrees == 0.0 || self.squares == 0.0 {
            return 0.0;
        }
        let variance = self.squares / self.degrees;
        let correlation = (1.0 - self.stepped / self.steps / (2.0 * variance)).clamp(0.0, MOST);
        variance * (1.0 + correlation) / (1.0 - correlation)
    }
}
