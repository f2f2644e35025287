//! Damping that follows the ratio of actual to predicted reduction.
//!
//! ```text
//!     accepted   λ ← λ max(1/10, 1 − (2ρ − 1)³)     growth ← 2
//!     rejected   λ ← λ · growth                     growth ← 2 · growth
//! ```
//!
//! Nielsen, *Damping parameter in Marquardt's method*, IMM-REP-1999-05, eq. 2.5. Beyond the source, λ falls to a tenth (there
//! to a third) and grows by at most 2 after an accepted step.
//!
//! The first step is bounded by `‖D δ‖ ≤ 0.2 ‖D x‖` (Moré, *The Levenberg-Marquardt algorithm: implementation and theory*,
//! 1978, section 3, with a smaller factor): without it a start with one parameter far too small is left for a plateau at
//! infinity, as with NIST's BoxBOD from its far start.

use serde::{Deserialize, Serialize};

use crate::Point;

/// Damping beyond which a step is shorter than rounding.
const MAX_DAMPING: f64 = 1e32;
/// Damping at the start, relative to the column norms.
const INITIAL_DAMPING: f64 = 1e-3;
/// The first step is at most this share of what it moves.
const FIRST_STEP: f64 = 0.2;
/// Growth of the damping while a step is too long, and where that ends.
const LONG_GROWTH: f64 = 3.0;
const MAX_LONG_DAMPING: f64 = 1e4;

/// λ, and by what it grows after the next rejected step.
#[derive(Debug, Serialize, Deserialize)]
pub struct Damping {
    lambda: f64,
    growth: f64,
    /// Whether the first step has been bounded.
    bounded: bool,
}

impl Default for Damping {
    fn default() -> Self {
        Damping { lambda: INITIAL_DAMPING, growth: 2.0, bounded: false }
    }
}

impl Damping {
    /// λ.
    pub(crate) fn lambda(&self) -> f64 {
        self.lambda
    }

    /// Whether the first step should be tried shorter: it is too long, and λ could be raised. Asked of no later step.
    pub(crate) fn shortens_first_step(&mut self, here: &Point<'_>, step: &[f64]) -> bool {
        if self.bounded {
            return false;
        }
        let longest = FIRST_STEP * here.size();
        self.bounded = longest == 0.0 || here.scaled_length(step) <= longest || !self.raise();
        !self.bounded
    }

    /// For a step that is too long to be tried. `false` where more damping would be of no use.
    pub(crate) fn raise(&mut self) -> bool {
        let go_on = self.lambda < MAX_LONG_DAMPING;
        if go_on {
            self.lambda *= LONG_GROWTH;
        }
        go_on
    }

    /// After an accepted step with this ratio of actual to predicted reduction.
    pub(crate) fn accept(&mut self, ratio: f64) {
        self.lambda *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(0.1, 2.0);
        self.growth = 2.0;
    }

    /// After a rejected step. `false` where no step is left to try.
    pub(crate) fn reject(&mut self) -> bool {
        let go_on = self.lambda <= MAX_DAMPING;
        self.lambda *= self.growth;
        self.growth *= 2.0;
        go_on
    }
}
