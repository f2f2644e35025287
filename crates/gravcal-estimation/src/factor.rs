//! One term of the cost.

use std::sync::Arc;

use crate::{Loss, Noise, Residual};

/// A residual and how far it is to be trusted.
#[derive(Clone, Debug)]
pub struct Factor {
    /// The model, in the unit of the reading.
    pub residual: Arc<dyn Residual>,
    /// Covariance of the reading's error.
    pub noise: Noise,
    /// What a residual beyond the noise costs: by row where the noise is independent, by factor where it is correlated.
    pub loss: Loss,
}

impl Factor {
    /// Puts a residual and its noise together.
    pub fn new(residual: impl Residual + 'static, noise: Noise) -> Self {
        Factor { residual: Arc::new(residual), noise, loss: Loss::None }
    }

    /// Cost ½ ρ of whitened residuals.
    pub(crate) fn cost(&self, whitened: &[f64]) -> f64 {
        let cost = |square: f64| 0.5 * self.loss.at(square).value;
        match (self.loss, &self.noise) {
            (Loss::None, _) => 0.5 * square(whitened),
            (_, Noise::Independent(_)) => whitened.iter().map(|r| cost(r * r)).sum(),
            (_, Noise::Correlated(_)) => cost(square(whitened)),
        }
    }

    /// ρ′ of each row.
    pub(crate) fn weights(&self, whitened: &[f64]) -> Vec<f64> {
        match self.noise {
            Noise::Independent(_) => whitened.iter().map(|r| self.loss.at(r * r).first).collect(),
            Noise::Correlated(_) => vec![self.loss.at(square(whitened)).first; whitened.len()],
        }
    }

    /// The same with a robust loss.
    #[must_use]
    pub fn with_loss(self, loss: Loss) -> Self {
        Factor { loss, ..self }
    }
}

fn square(rows: &[f64]) -> f64 {
    rows.iter().map(|r| r * r).sum()
}
