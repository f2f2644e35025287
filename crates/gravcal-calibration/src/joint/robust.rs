//! Robust losses in the joint problem.
//!
//! A loss knows an outlier by its residual, so good readings must look good from the start, and a cost that is not convex
//! has several minima. The problem is therefore solved by least squares first, then with Huber's convex loss, and with a
//! loss that forgets outliers last, each from where the one before ended.
//!
//! Noise that no reading states is then the scaled median of the residuals, of which up to half may be outliers:
//!
//! ```text
//!     σ = median |r| / √(1 − h) / 0.6745         (Huber, Robust statistics, 1981, section 5.1; h: leverage)
//! ```
//!
//! The first round of it is by least squares, when nothing is known of the noise yet.

use gravcal_estimation::{Estimate, EvaluateError, Loss, LossName, Values};
use gravcal_robot_model::session::Session;

use super::error::EstimateError;
use super::median::{NORMAL_MEDIAN, median};
use super::problem::JointProblem;
use super::solved::Solved;
use crate::workbench::Workbench;

/// Solves a problem posed without a loss under `loss`.
pub(super) fn solve_with_loss(
    posed: &JointProblem,
    loss: Loss,
    workbench: &Workbench<'_>,
) -> Result<(JointProblem, Estimate), EstimateError> {
    let solve = |posed: &JointProblem, from: &Values| workbench.solve(&posed.problem, from);
    let mut values = posed.initial.clone();
    for stage in stages_before(loss) {
        values = solve(&posed.with_loss(stage)?, &values)?.values;
    }
    let last = posed.with_loss(loss)?;
    let estimate = solve(&last, &values)?;
    Ok((last, estimate))
}

/// Losses that lead to one.
fn stages_before(loss: Loss) -> Vec<Loss> {
    match loss.name() {
        LossName::None => Vec::new(),
        LossName::Huber => vec![Loss::None],
        LossName::Cauchy | LossName::Tukey | LossName::GemanMcClure => vec![Loss::None, LossName::Huber.efficient()],
    }
}

impl Solved {
    /// Residuals of the torque readings in standard deviations, as large as they would be had the fit not followed
    /// them: one a row.
    pub(crate) fn freed_residuals(&self) -> Result<Vec<f64>, EvaluateError> {
        let rows = self.posed.problem.augmented_jacobian(&self.estimate.values)?;
        let leverages = self.spectrum.leverages(&rows);
        let width = self.posed.problem.columns().len() + 1;
        let freed = |(row, leverage): (&[f64], &f64)| row[width - 1] / (1.0 - leverage).max(f64::EPSILON).sqrt();
        Ok(rows.chunks_exact(width).zip(&leverages).take(self.posed.rows.len()).map(freed).collect())
    }

    /// Standard deviation of each channel's readings by the median of its residuals, unit of the reading.
    pub(super) fn median_noise(&self, session: &Session) -> Result<Vec<f64>, EvaluateError> {
        let freed = self.freed_residuals()?;
        let rows = || self.posed.rows.iter().zip(&freed);
        let noise = |(channel, old): (usize, &f64)| {
            let own = rows().filter(|((_, other), _)| *other == channel);
            let mut sizes: Vec<f64> =
                own.map(|((pose, _), r)| r.abs() * self.readings.std(session, *pose, channel)).collect();
            let median = median(&mut sizes).unwrap_or(0.0);
            if median > 0.0 { median / NORMAL_MEDIAN } else { *old }
        };
        Ok(self.readings.noise.iter().enumerate().map(noise).collect())
    }
}
