//! What the residuals of the readings say.

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_identification::{Explained, RowResidual};
use gravcal_robot_model::session::{ReadingId, Session};
use std::sync::Arc;

use super::torque_parts::torque_parts;
use crate::joint::{MeasurementSet, Solved};
use crate::result::{Fit, HeldOut, JointFit, ReadingResidual, UnexplainedResult};

/// Residuals of readings, collected by channel.
#[derive(Clone, Debug)]
pub(crate) struct JointResiduals {
    /// `(residual, standard deviation of the noise)` in the unit of the reading, by channel.
    by_channel: Vec<Vec<(f64, f64)>>,
    /// Range of the readings, by channel.
    ranges: Arc<[f64]>,
    /// Variance, by channel, of errors that last while a joint stands.
    lasting: Vec<f64>,
}

impl JointResiduals {
    /// From whitened residuals whose first rows are the given readings.
    pub fn new(session: &Session, readings: &MeasurementSet, rows: &[ReadingId], whitened: &[f64]) -> Self {
        let mut by_channel = vec![Vec::new(); session.channel_count()];
        for (id, r) in rows.iter().zip(whitened) {
            by_channel[id.channel].push((r * readings.std(session, *id), readings.own_std(session, *id)));
        }
        let lasting = (0..session.channel_count()).map(|channel| readings.lasting_variance(channel)).collect();
        JointResiduals { by_channel, ranges: Arc::clone(&readings.spreads), lasting }
    }

    /// `unexplained`: by channel; may be empty.
    fn report(&self, session: &Session, unexplained: &[Option<UnexplainedResult>]) -> Vec<JointFit> {
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
                    lasting_std: Some(self.lasting[channel].sqrt()).filter(|std| *std > 0.0),
                    range: self.ranges[channel],
                }
            })
            .collect()
    }
}

/// How well a solved problem explains its readings as a whole: those whose noise is stated, by it.
pub(crate) fn explained(session: &Session, solved: &Solved, chi_squared: f64) -> Result<Explained, EvaluateError> {
    let degrees_of_freedom = solved.judged_problem().rows().saturating_sub(solved.analysis.rank());
    let loss = solved.built.loss;
    if !solved.readings().noise_found(session) && loss == Loss::None {
        return Ok(Explained::by_chi_squared(chi_squared, degrees_of_freedom));
    }
    let stated: Vec<RowResidual> = solved.stated_residuals(session)?.into_iter().map(|(_, row)| row).collect();
    Ok(match loss {
        _ if stated.is_empty() => Explained::by_own_noise(chi_squared, degrees_of_freedom),
        Loss::None => Explained::by_stated_rows(chi_squared, degrees_of_freedom, &stated),
        _ => {
            let freed: Vec<f64> = stated.into_iter().map(RowResidual::freed).collect();
            Explained::by_median(chi_squared, degrees_of_freedom, &freed)
        }
    })
}

/// Tells the fit of a solved problem with these whitened residuals.
pub(crate) fn fit(session: &Session, solved: &Solved, whitened: &[f64]) -> Result<Fit, EvaluateError> {
    let at_rest: f64 = whitened.iter().map(|r| r * r).sum();
    let chi_squared = at_rest - 2.0 * solved.growth_at_rest;
    let Explained { degrees_of_freedom, p_value, median_ratio, times_noise, .. } =
        explained(session, solved, chi_squared)?;
    let unexplained = solved.unexplained_sizes(session)?;
    Ok(Fit {
        chi_squared,
        degrees_of_freedom,
        p_value,
        times_noise: p_value.map(|_| times_noise),
        median_ratio,
        joints: JointResiduals::new(session, solved.readings(), &solved.built.rows, whitened)
            .report(session, &unexplained),
        held_out: None,
        held_out_missing: None,
        smaller_models: Vec::new(),
        residuals: by_reading(session, solved, whitened)?,
    })
}

/// Every reading's residual, with that of sensors at their nominal values. These may be out of the model's reach, where a residual is
/// no number.
fn by_reading(session: &Session, solved: &Solved, whitened: &[f64]) -> Result<Vec<ReadingResidual>, EvaluateError> {
    let (problem, values) = (&solved.built.problem, &solved.estimate.values);
    let mut before = values.clone();
    for id in session.parameters() {
        before.set(solved.built.variables.block(id), &[session.nominal(id)]);
    }
    let nominal = problem.residuals(&before).unwrap_or_else(|_| vec![f64::NAN; whitened.len()]);
    let weights = problem.weights(values)?;
    let parts = torque_parts(session, solved)?;
    let rows = solved.built.rows.iter().zip(whitened).zip(nominal.iter().zip(weights).zip(parts));
    let reported = rows.map(|((id, whitened), ((nominal, weight), torque))| {
        let std = solved.readings().std(session, *id);
        ReadingResidual { id: *id, residual: std * whitened, nominal_residual: std * nominal, std, weight, torque }
    });
    Ok(reported.collect())
}

/// Tells how well poses were predicted that a fit did not see; `whitened` are the residuals of exactly `rows`.
pub(crate) fn held_out(session: &Session, readings: &MeasurementSet, rows: &[ReadingId], whitened: &[f64]) -> HeldOut {
    let mut poses: Vec<usize> = rows.iter().map(|id| id.pose).collect();
    poses.dedup();
    HeldOut {
        poses: poses.len(),
        stretches: poses.chunk_by(|a, b| a + 1 == *b && session.poses[*a].table == session.poses[*b].table).count(),
        files: Vec::new(),
        chi_squared: whitened[..rows.len()].iter().map(|r| r * r).sum(),
        readings: rows.len(),
        joints: JointResiduals::new(session, readings, rows, whitened).report(session, &[]),
    }
}
