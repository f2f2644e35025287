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
        let cost = |rows: &[f64]| 0.5 * self.loss.at(square(rows)).value;
        match self.noise {
            Noise::Independent { .. } => whitened.chunks(1).map(cost).sum(),
            Noise::Correlated { .. } => cost(whitened),
        }
    }

    /// ρ′ of each row.
    pub(crate) fn weights(&self, whitened: &[f64]) -> Vec<f64> {
        match self.noise {
            Noise::Independent { .. } => whitened.iter().map(|r| self.loss.at(r * r).first).collect(),
            Noise::Correlated { .. } => vec![self.loss.at(square(whitened)).first; whitened.len()],
        }
    }

    /// Puts the loss into whitened rows `[J r]` of `width` numbers: afterwards their products are the gradient and the
    /// curvature of the cost.
    pub(crate) fn correct(&self, rows: &mut [f64], width: usize) {
        match (self.loss, &self.noise) {
            (Loss::None, _) => {}
            (_, Noise::Independent { .. }) => {
                for row in rows.chunks_exact_mut(width) {
                    let s = row[width - 1] * row[width - 1];
                    let (residual, jacobian) = self.loss.at(s).correction(s);
                    row[..width - 1].iter_mut().for_each(|v| *v *= jacobian);
                    row[width - 1] *= residual;
                }
            }
            (_, Noise::Correlated { .. }) => self.correct_together(rows, width),
        }
    }

    /// `J̃ = √ρ′ J + (b − √ρ′) r (rᵀJ)/s`: only the part along r loses curvature.
    fn correct_together(&self, rows: &mut [f64], width: usize) {
        let r: Vec<f64> = rows.chunks_exact(width).map(|row| row[width - 1]).collect();
        let s = square(&r);
        let value = self.loss.at(s);
        let (residual, along) = value.correction(s);
        let across = value.first.max(0.0).sqrt();
        for column in 0..width - 1 {
            let projection: f64 = rows.chunks_exact(width).zip(&r).map(|(row, r)| row[column] * r).sum();
            let extra = if s > 0.0 { (along - across) * projection / s } else { 0.0 };
            for (row, r) in rows.chunks_exact_mut(width).zip(&r) {
                row[column] = across * row[column] + extra * r;
            }
        }
        rows.chunks_exact_mut(width).for_each(|row| row[width - 1] *= residual);
    }

    /// The same with a robust loss.
    pub fn with_loss(self, loss: Loss) -> Self {
        Factor { loss, ..self }
    }
}

fn square(rows: &[f64]) -> f64 {
    rows.iter().map(|r| r * r).sum()
}
