//! What the residuals of the readings say.

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_robot_model::session::Session;
use std::sync::Arc;

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use crate::joint::{NORMAL_MEDIAN, Readings, Solved, median};
use crate::result::{Fit, HeldOut, JointFit, ReadingResidual, UnexplainedResult};

/// Probability below which the stated noise is taken not to explain the residuals.
const SIGNIFICANCE: f64 = 1e-3;

/// Residuals of readings, collected by channel.
#[derive(Clone, Debug)]
pub(crate) struct JointResiduals {
    /// `(residual, standard deviation of the noise)` in the unit of the reading, by channel.
    by_channel: Vec<Vec<(f64, f64)>>,
    /// Range of the readings, by channel.
    ranges: Arc<[f64]>,
}

impl JointResiduals {
    /// From whitened residuals whose first rows are the given readings.
    pub fn new(session: &Session, readings: &Readings, rows: &[(usize, usize)], whitened: &[f64]) -> Self {
        let mut by_channel = vec![Vec::new(); session.channel_count()];
        for ((pose, channel), r) in rows.iter().zip(whitened) {
            let own = readings.own_std(session, *pose, *channel);
            by_channel[*channel].push((r * readings.std(session, *pose, *channel), own));
        }
        JointResiduals { by_channel, ranges: Arc::clone(&readings.spreads) }
    }

    /// `unexplained`: by channel; may be empty.
    fn tell(&self, session: &Session, unexplained: &[Option<UnexplainedResult>]) -> Vec<JointFit> {
        let estimated = session.noise_estimated();
        self.by_channel
            .iter()
            .enumerate()
            .filter(|(_, rows)| !rows.is_empty())
            .map(|(channel, rows)| {
                let count = rows.len() as f64;
                JointFit {
                    joint: session.channel_name(channel),
                    unit: session.channel_unit(channel),
                    readings: rows.len(),
                    rms: (rows.iter().map(|(r, _)| r * r).sum::<f64>() / count).sqrt(),
                    largest: rows.iter().fold(0.0, |m, (r, _)| m.max(r.abs())),
                    noise_std: rows.iter().map(|(_, std)| std).sum::<f64>() / count,
                    noise_estimated: estimated[channel],
                    unexplained: unexplained.get(channel).copied().flatten(),
                    range: self.ranges[channel],
                }
            })
            .collect()
    }
}

/// How well the readings are explained as a whole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Explained {
    chi_squared: f64,
    degrees_of_freedom: usize,
    p_value: Option<f64>,
    median_ratio: Option<f64>,
}

impl Explained {
    pub fn of(session: &Session, solved: &Solved, chi_squared: f64) -> Result<Explained, EvaluateError> {
        let degrees_of_freedom = solved.judged_problem().rows().saturating_sub(solved.spectrum.rank());
        let stated = !solved.readings.noise_found(session);
        let (p_value, median_ratio) = match (stated, solved.posed.loss) {
            (false, _) => (None, None),
            (true, Loss::None) => (by_chi_squared(chi_squared, degrees_of_freedom), None),
            (true, _) => by_median(&solved.freed_residuals()?),
        };
        Ok(Explained { chi_squared, degrees_of_freedom, p_value, median_ratio })
    }

    /// How many times worse than their stated noise the readings are explained, where that is no accident: `√(χ²/dof)`,
    /// under a loss by the median.
    pub fn misfit(&self) -> Option<f64> {
        let by_squares = || (self.chi_squared / self.degrees_of_freedom as f64).sqrt();
        let ratio = self.median_ratio.unwrap_or_else(by_squares);
        self.p_value.filter(|p| *p < SIGNIFICANCE).map(|_| ratio)
    }
}

/// Tells the fit of a solved problem with these whitened residuals.
pub(crate) fn fit(session: &Session, solved: &Solved, whitened: &[f64]) -> Result<Fit, EvaluateError> {
    let chi_squared = whitened.iter().map(|r| r * r).sum();
    let Explained { degrees_of_freedom, p_value, median_ratio, .. } = Explained::of(session, solved, chi_squared)?;
    let unexplained = solved.unexplained_sizes(session)?;
    Ok(Fit {
        chi_squared,
        degrees_of_freedom,
        p_value,
        median_ratio,
        joints: JointResiduals::new(session, &solved.readings, &solved.posed.rows, whitened)
            .tell(session, &unexplained),
        held_out: None,
        held_out_missing: None,
        residuals: by_reading(session, solved, whitened)?,
    })
}

/// Every reading's residual, with that of sensors at their nominal values. These may be out of the model's reach, where a residual is
/// no number.
fn by_reading(session: &Session, solved: &Solved, whitened: &[f64]) -> Result<Vec<ReadingResidual>, EvaluateError> {
    let (problem, values) = (&solved.posed.problem, &solved.estimate.values);
    let mut before = values.clone();
    for id in session.parameters() {
        before.set(solved.posed.layout.block(id), &[session.nominal(id)]);
    }
    let nominal = problem.residuals(&before).unwrap_or_else(|_| vec![f64::NAN; whitened.len()]);
    let weights = problem.weights(values)?;
    let rows = solved.posed.rows.iter().zip(whitened).zip(nominal.iter().zip(weights));
    let told = rows.map(|(((pose, channel), whitened), (nominal, weight))| {
        let std = solved.readings.std(session, *pose, *channel);
        ReadingResidual {
            pose: *pose,
            channel: *channel,
            residual: std * whitened,
            nominal_residual: std * nominal,
            std,
            weight,
        }
    });
    Ok(told.collect())
}

fn by_chi_squared(chi_squared: f64, degrees_of_freedom: usize) -> Option<f64> {
    if degrees_of_freedom == 0 {
        return None;
    }
    ChiSquared::new(degrees_of_freedom as f64).ok().map(|distribution| distribution.sf(chi_squared))
}

/// Probability of as many residuals beyond the median of normal noise, of which each is with probability one half, and
/// how far their own median lies from it. A tenth of outliers moves it little, a model that is wrong for all of them far.
fn by_median(residuals: &[f64]) -> (Option<f64>, Option<f64>) {
    let count = residuals.len() as f64;
    let beyond = residuals.iter().filter(|r| r.abs() > NORMAL_MEDIAN).count() as f64;
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    let ratio = median(&mut sizes).map(|median| median / NORMAL_MEDIAN);
    (ratio.map(|_| Normal::standard().sf((2.0 * beyond - count) / count.sqrt())), ratio)
}

/// Tells how well poses were predicted that a fit did not see; `whitened` are the residuals of exactly `rows`.
pub(crate) fn held_out(session: &Session, readings: &Readings, rows: &[(usize, usize)], whitened: &[f64]) -> HeldOut {
    let mut poses: Vec<usize> = rows.iter().map(|(pose, _)| *pose).collect();
    poses.dedup();
    HeldOut {
        poses: poses.len(),
        stretches: poses.chunk_by(|a, b| a + 1 == *b && session.poses[*a].table == session.poses[*b].table).count(),
        files: Vec::new(),
        chi_squared: whitened[..rows.len()].iter().map(|r| r * r).sum(),
        readings: rows.len(),
        joints: JointResiduals::new(session, readings, rows, whitened).tell(session, &[]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_outliers_does_not_contradict_the_noise_and_twice_the_noise_does() {
        // Quantiles of the normal distribution.
        let quantile = |k: usize| Normal::standard().inverse_cdf((k as f64 + 0.5) / 1000.0);
        let normal: Vec<f64> = (0..1000).map(quantile).collect();
        let (p, ratio) = by_median(&normal);
        assert!((p.unwrap() - 0.5).abs() < 0.05 && (ratio.unwrap() - 1.0).abs() < 0.01, "{p:?} {ratio:?}");
        let spoilt: Vec<f64> = normal.iter().enumerate().map(|(k, r)| if k % 20 == 0 { 50.0 } else { *r }).collect();
        assert!(by_median(&spoilt).0.unwrap() > 1e-2);
        let twice: Vec<f64> = normal.iter().map(|r| 2.0 * r).collect();
        let (p, ratio) = by_median(&twice);
        assert!(p.unwrap() < 1e-9 && (ratio.unwrap() - 2.0).abs() < 0.02);
    }
}
