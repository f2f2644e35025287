//! Errors of readings that their noise does not explain, one variance for each channel ([`gravcal_identification::variance_beyond_noise`]).
//!
//! It is found with residuals and leverages as they are, the fit is repeated with the new weights, and so on (`solve_from.rs`), until both
//! stand. Where residuals are no larger than the noise makes them, it is zero and everything is as if there were none.
//!
//! **Beyond chance.** Of errors that are not there half the channels find some. What tells a session with a right model from others is whether the
//! residuals of any channel, or of all together, are larger than noise makes them by chance:
//!
//! ```text
//!     Σ e²/σ²  of the readings of a channel, beside χ² of Σ (1 − h) degrees of freedom
//! ```
//!
//! with `σ` the noise of a reading alone and `h` its leverage.

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_identification::{ErrorRow, RowResidual, variance_beyond_noise, variance_beyond_noise_by_median};
use gravcal_robot_model::session::{ReadingId, Session, UnexplainedError};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::joint::measurement_set::{MeasurementSet, first_noise, stated};
use crate::joint::solved::Solved;

/// Probability with which noise alone passes for errors beyond it. Errors that go unseen are small beside the noise; those that pass for such cost
/// a tenth of an interval's width.
const BY_CHANCE: f64 = 0.05;

impl MeasurementSet {
    /// The same with unexplained errors of channels where they are estimated, as large as a first guess of noise.
    pub(in crate::joint) fn with_rough_unexplained(&self, session: &Session) -> MeasurementSet {
        let rough = first_noise(session, &self.spreads);
        let errors = session.unexplained_errors();
        let variance = |(error, (rough, old)): (&UnexplainedError, (&f64, &f64))| match error {
            UnexplainedError::Estimated => rough * rough,
            _ => *old,
        };
        let unexplained = errors.iter().zip(rough.iter().zip(&self.unexplained)).map(variance).collect();
        MeasurementSet { unexplained, ..self.clone() }
    }

    /// The same as if no errors were estimated, and none were smaller than a first guess of noise: what was estimated with a mistake
    /// in the session excuses the mistake.
    pub(in crate::joint) fn unexcused(&self, session: &Session) -> MeasurementSet {
        let found = self.unexplained_found(session);
        let readings = MeasurementSet { noise: first_noise(session, &self.spreads), ..self.clone() };
        if !found {
            return readings;
        }
        MeasurementSet { unexplained: stated(session), lasting: None, ..readings }.roughly(session)
    }

    /// Whether errors that the noise does not explain were found in any channel.
    pub(crate) fn unexplained_found(&self, session: &Session) -> bool {
        let errors = session.unexplained_errors();
        errors.iter().zip(&self.unexplained).any(|(error, v)| *error == UnexplainedError::Estimated && *v > 0.0)
    }

    /// The same of one channel.
    pub(crate) fn unexplained_found_of(&self, session: &Session, channel: usize) -> bool {
        self.unexplained[channel] > 0.0 && session.unexplained_errors()[channel] == UnexplainedError::Estimated
    }

    /// By how much the variance of a channel's residuals exceeds that of its readings' noise, where such errors are estimated; nothing
    /// where it does not.
    pub(crate) fn beyond_noise(&self, session: &Session, channel: usize, residual_std: f64) -> Option<f64> {
        if session.unexplained_errors()[channel] != UnexplainedError::Estimated {
            return None;
        }
        let all = (0..session.poses.len()).map(|pose| ReadingId { pose, channel });
        let read = all.filter(|id| session.reading(*id).is_some());
        let own: Vec<f64> = read.map(|id| self.own_std(session, id).powi(2)).collect();
        let beyond = residual_std * residual_std - own.iter().sum::<f64>() / own.len().max(1) as f64;
        (beyond > 0.0).then_some(beyond)
    }

    /// Whether the size of any errors comes from the residuals.
    pub(crate) fn noise_found(&self, session: &Session) -> bool {
        session.noise_estimated().contains(&true) || self.unexplained_found(session) || self.lasting.is_some()
    }
}

impl Solved {
    /// Variance of the unexplained errors of each channel: by these residuals, the solution's own, where it is estimated, else as it is.
    pub(in crate::joint) fn unexplained(&self, session: &Session, rows: &[RowResidual]) -> Vec<f64> {
        let errors = session.unexplained_errors();
        if !errors.contains(&UnexplainedError::Estimated) {
            return self.readings().unexplained.clone();
        }
        let rows = self.unexplained_rows(session, rows);
        let variance =
            |((rows, error), old): ((&Vec<ErrorRow>, UnexplainedError), &f64)| match (error, self.readings().loss) {
                (UnexplainedError::Estimated, Loss::None) => variance_beyond_noise(rows),
                (UnexplainedError::Estimated, _) => variance_beyond_noise_by_median(rows),
                _ => *old,
            };
        rows.iter().zip(errors).zip(&self.readings().unexplained).map(variance).collect()
    }

    /// Whether the residuals of a channel where such errors are estimated, or of all of these together, are larger than noise makes them by chance. A
    /// weaker sign than the one that makes friction an unknown ([`MeasurementSet::errs_beyond_chance`]): errors that only widen intervals cost little.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint) fn residuals_exceed_noise(&self, session: &Session) -> Result<bool, EvaluateError> {
        let rows = self.unexplained_rows(session, &self.row_residuals()?);
        let estimated = session.unexplained_errors().into_iter().map(|error| error == UnexplainedError::Estimated);
        let channels: Vec<Vec<ErrorRow>> =
            rows.into_iter().zip(estimated).filter_map(|(rows, estimated)| estimated.then_some(rows)).collect();
        let all: Vec<ErrorRow> = channels.iter().flatten().copied().collect();
        let smallest = channels.iter().filter_map(|rows| noise_alone(rows)).fold(1.0, f64::min);
        let of_all = noise_alone(&all).unwrap_or(1.0);
        Ok((channels.len() as f64 * smallest).min(of_all) < BY_CHANCE)
    }

    /// The readings of each channel.
    fn unexplained_rows(&self, session: &Session, rows: &[RowResidual]) -> Vec<Vec<ErrorRow>> {
        let mut by_channel = vec![Vec::new(); session.channel_count()];
        for (id, row) in self.built.rows.iter().zip(rows) {
            let residual = row.whitened * self.readings().std(session, *id);
            let readings = self.readings();
            let noise = readings.own_std(session, *id).powi(2)
                + readings.of_unknown_side(session, *id)
                + readings.lasting_alone(*id);
            // What is found is the variance where a joint carries as much as in the mean.
            let scatter = readings.growing_scatter(session, *id).powi(2);
            by_channel[id.channel].push(ErrorRow {
                noise: noise / scatter,
                squared: residual * residual / scatter,
                freedom: (1.0 - row.leverage).max(0.0),
            });
        }
        by_channel
    }

    /// Whether unexplained errors of these variances are those of the solution but for a share of each channel's error.
    pub(in crate::joint) fn stands_with(&self, session: &Session, unexplained: &[f64], tolerance: f64) -> bool {
        let mut own = vec![(0.0, 0.0); session.channel_count()];
        for id in &self.built.rows {
            let noise = self.readings().own_std(session, *id).powi(2);
            own[id.channel] = (own[id.channel].0 + noise, own[id.channel].1 + 1.0);
        }
        let stands = |((new, old), (noise, count)): ((&f64, &f64), (f64, f64))| {
            (new - old).abs() <= 2.0 * tolerance * (noise / f64::max(count, 1.0) + old)
        };
        unexplained.iter().zip(&self.readings().unexplained).zip(own).all(stands)
    }
}

/// Probability of residuals at least as large if they are noise alone; nothing where no degree of freedom is left.
fn noise_alone(rows: &[ErrorRow]) -> Option<f64> {
    let left = || rows.iter().filter(|row| row.freedom > 0.0);
    let statistic: f64 = left().map(|row| row.squared / row.noise).filter(|share| !share.is_nan()).sum();
    let law = ChiSquared::new(left().map(|row| row.freedom).sum()).ok()?;
    Some(if statistic.is_finite() { law.sf(statistic) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `χ²` of two degrees of freedom is exponential: `p = e^(−χ²/2)`.
    #[test]
    fn residuals_are_held_against_noise_alone() {
        let row = |squared: f64| ErrorRow { noise: 4.0, squared, freedom: 0.5 };
        let rows = [row(4.0), row(8.0), row(0.0), row(12.0)];
        assert!((noise_alone(&rows).unwrap() - (-3.0_f64).exp()).abs() < 1e-12);
        assert_eq!(noise_alone(&[]), None);
        assert_eq!(noise_alone(&[ErrorRow { freedom: 0.0, ..row(1.0) }]), None, "nothing is left of it");
        // A sensor that reads the same number throughout a dwell has no noise of its own.
        let exact = ErrorRow { noise: 0.0, ..row(1.0) };
        assert_eq!(noise_alone(&[row(4.0), exact]), Some(0.0));
        assert_eq!(noise_alone(&[row(4.0), ErrorRow { squared: 0.0, ..exact }]), noise_alone(&[row(4.0), row(0.0)]));
    }
}
