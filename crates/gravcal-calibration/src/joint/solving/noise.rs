//! Noise of the sensors where no reading states it: from the residuals of their channels.

use std::collections::{BTreeMap, BTreeSet};

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_identification::{
    ChannelNoise, ReadingResidual, RowResidual, noise_by_median, noise_by_squares, row_residuals,
};
use gravcal_robot_model::session::{ReadingId, Session, UnexplainedError};

use crate::joint::measurement_set::first_noise;
use crate::joint::solved::Solved;

/// Errors of the curves that are laid through the positions of an arm in motion, in what its readings span: noise of a window is no less.
pub(crate) const CURVES: f64 = 1e-5;

impl Solved {
    /// Standard deviation of each channel's residuals, allowing for the parameters that the rows themselves took up. `rows`: the solution's
    /// own, here and below.
    pub(in crate::joint) fn residual_noise(&self, session: &Session, rows: &[RowResidual]) -> Vec<f64> {
        let found = self.noise_by_squares(session, rows).into_iter();
        self.or_as_before(found.map(|found| Some(found?.std)).collect())
    }

    /// Standard deviation of each channel's readings by the median of its residuals, unit of the reading.
    pub(in crate::joint) fn median_noise(&self, session: &Session, rows: &[RowResidual]) -> Vec<f64> {
        self.or_as_before(noise_by_median(&self.reading_residuals(session, rows), self.readings().noise.len()))
    }

    /// The noise that residuals show: under a loss outliers tell nothing of it.
    pub(in crate::joint) fn noise_shown(&self, session: &Session, loss: Loss, rows: &[RowResidual]) -> Vec<f64> {
        let shown = match loss {
            Loss::None => self.residual_noise(session, rows),
            _ => self.median_noise(session, rows),
        };
        shown.iter().zip(self.errors_of_curves(session)).map(|(noise, least)| noise.max(least)).collect()
    }

    /// Whether any channel's noise that residuals show is no more than curves through the positions err.
    pub(in crate::joint) fn is_as_exact_as_curves(&self, session: &Session) -> bool {
        let noise = self.readings().noise.iter().zip(session.noise_estimated());
        noise.zip(self.errors_of_curves(session)).any(|((noise, found), least)| found && *noise <= least)
    }

    /// Of each channel, unit of its reading; zero where the arm stands.
    fn errors_of_curves(&self, session: &Session) -> impl Iterator<Item = f64> {
        let share = if session.has_windows() { CURVES } else { 0.0 };
        self.readings().spreads.iter().map(move |spread| share * spread)
    }

    /// The noises that are found from the residuals.
    pub(in crate::joint) fn noises_found(&self, session: &Session) -> Result<NoisesFound, EvaluateError> {
        let groups = alike(session);
        // Under a loss M-estimators find the size of the noise by themselves.
        if self.built.loss != Loss::None {
            let count = groups.iter().flatten().collect::<BTreeSet<&usize>>().len() as f64;
            return Ok(NoisesFound { count, of_channels: vec![None; groups.len()] });
        }
        let rows = self.row_residuals()?;
        let found = self.noise_by_squares(session, &rows);
        let found: Vec<Option<ChannelNoise>> =
            found.into_iter().zip(&groups).map(|(found, group)| found.filter(|_| group.is_some())).collect();
        let mut members: BTreeMap<usize, Vec<ChannelNoise>> = BTreeMap::new();
        for (found, group) in found.iter().zip(groups) {
            group.into_iter().for_each(|group| members.entry(group).or_default().extend(found));
        }
        let count: f64 = members.values().map(|members| noises_of(members)).sum();
        let mut of_channels: Vec<Option<f64>> = found.into_iter().map(|found| Some(found?.freedom)).collect();
        // Errors that last are told by fewer numbers than the noise, and are mostly larger.
        let with_lasting = self.freedom_with_lasting(session, &rows, &of_channels);
        for (channel, with_lasting) in of_channels.iter_mut().zip(&with_lasting) {
            *channel = with_lasting.or(*channel);
        }
        let fewest = with_lasting.into_iter().flatten().reduce(f64::min);
        let count = fewest.map_or(count, |fewest| count.max(self.freedom() as f64 / fewest));
        Ok(NoisesFound { count, of_channels })
    }

    fn noise_by_squares(&self, session: &Session, rows: &[RowResidual]) -> Vec<Option<ChannelNoise>> {
        noise_by_squares(&self.reading_residuals(session, rows), &alike(session))
    }

    fn or_as_before(&self, found: Vec<Option<f64>>) -> Vec<f64> {
        found.into_iter().zip(&self.readings().noise).map(|(found, old)| found.unwrap_or(*old)).collect()
    }

    /// Those of the readings, in the order of the rows.
    pub(in crate::joint) fn row_residuals(&self) -> Result<Vec<RowResidual>, EvaluateError> {
        row_residuals(&self.built.problem, &self.estimate.values, &self.analysis, self.built.rows.len())
    }

    /// Channel and residual of each reading whose noise is stated, and whose errors are not taken to be larger.
    pub(crate) fn stated_residuals(&self, session: &Session) -> Result<Vec<(usize, RowResidual)>, EvaluateError> {
        let stated: Vec<bool> = errors_found(session).into_iter().map(|found| !found).collect();
        if !self.built.rows.iter().any(|id| stated[id.channel]) {
            return Ok(Vec::new());
        }
        let rows = self.built.rows.iter().zip(self.row_residuals()?);
        Ok(rows.filter(|(id, _)| stated[id.channel]).map(|(id, row)| (id.channel, row)).collect())
    }

    /// Of all readings but those that friction may have moved to either side, or holds by themselves: these tell nothing of the noise.
    fn reading_residuals(&self, session: &Session, rows: &[RowResidual]) -> Vec<ReadingResidual> {
        let of = |(id, row): (&ReadingId, &RowResidual)| {
            let std = self.readings().std(session, *id);
            ReadingResidual { channel: id.channel, std, row: *row }
        };
        let readings = self.readings();
        let tells = |(id, _): &(&ReadingId, &RowResidual)| {
            readings.of_unknown_side(session, **id) == 0.0 && readings.lasting_alone(**id) == 0.0
        };
        self.built.rows.iter().zip(rows).filter(tells).map(of).collect()
    }

    /// − ln of the likelihood with noise that was found counted only by the degrees of freedom that found it, but for what all sessions with
    /// these readings share: a fit that took up most of its readings explains the rest by chance.
    pub(in crate::joint) fn minus_log_likelihood(&self, session: &Session) -> Result<f64, EvaluateError> {
        let found = errors_found(session);
        let unit = first_noise(session, &self.readings().spreads);
        let size = |ReadingResidual { channel, std, row }: ReadingResidual| match found[channel] {
            true => (1.0 - row.leverage).max(0.0) * (std / unit[channel]).ln(),
            false => 0.0,
        };
        let rows = self.row_residuals()?;
        let of_readings: f64 = self.reading_residuals(session, &rows).into_iter().map(size).sum();
        let of_lasting: f64 = self
            .lasting_errors(session, &rows)
            .into_iter()
            .map(|error| error.freedom * (error.std / unit[error.joint]).ln())
            .sum();
        Ok(self.least_cost() + of_readings + of_lasting)
    }
}

/// Of each channel whose noise is found, the number of those that are alike: torque sensors of joints, forces of an instrument, its moments.
fn alike(session: &Session) -> Vec<Option<usize>> {
    let group = |channel: usize| session.axis(channel).map_or(0, |(instrument, axis)| 1 + 2 * instrument + axis / 3);
    let estimated = session.noise_estimated().into_iter().enumerate();
    estimated.map(|(channel, estimated)| estimated.then(|| group(channel))).collect()
}

/// The noises that residuals tell.
pub(in crate::joint) struct NoisesFound {
    /// How many there are, each with as many degrees of freedom as the others. Channels that are alike have one; of `k` that differ, and of which each
    /// has `d₀` degrees of freedom from the others beside its own, `D` in all, there are `D/(D/k + d₀)`.
    pub count: f64,
    /// The degrees of freedom that tell each channel's: those of all channels that are alike where these have one noise.
    pub of_channels: Vec<Option<f64>>,
}

/// How many noises those of channels that are alike count as; of none, one.
fn noises_of(members: &[ChannelNoise]) -> f64 {
    if members.is_empty() {
        return 1.0;
    }
    let own: f64 = members.iter().map(|member| member.own).sum();
    let freedom: f64 = members.iter().map(|member| member.freedom).sum();
    (own * members.len() as f64 / freedom).max(1.0)
}

/// Of each channel, whether the size of its errors is found from the residuals.
pub(in crate::joint) fn errors_found(session: &Session) -> Vec<bool> {
    let errors = session.unexplained_errors().into_iter().map(|error| error == UnexplainedError::Estimated);
    errors.zip(session.noise_estimated()).map(|(errors, noise)| errors || noise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::measurement_set::MeasurementSet;
    use crate::joint::solving::solve_from::{solve_built, solve_from};
    use crate::joint::variables::State;
    use crate::joint::{Signals, build_problem, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A shoulder of which every sixth pose is read, with or without stated noise.
    fn few(stated: bool) -> (Session, MeasurementSet) {
        let mut session = sarcos_shoulder().session(0);
        if !stated {
            session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|r| r.std = None);
        }
        let readings = select(&session, Signals::All).only(|id| id.pose % 6 == 0);
        (session, readings)
    }

    fn solved(session: &Session, readings: &MeasurementSet) -> Solved {
        let start = State::nominal(session);
        with_environment(|environment| solve_from(session, readings, start, environment)).unwrap()
    }

    #[test]
    fn stated_noise_counts_by_the_cost_alone() {
        let (session, readings) = few(true);
        let solved = solved(&session, &readings);
        assert_eq!(solved.minus_log_likelihood(&session).unwrap(), solved.estimate.cost);
    }

    #[test]
    fn noises_that_are_alike_are_one_and_those_that_differ_nearly_as_many_as_they_are() {
        let members = |freedom: f64| vec![ChannelNoise { std: 1.0, own: 11.0, freedom }; 4];
        assert_eq!(noises_of(&members(44.0)), 1.0);
        // 44 degrees of freedom, of which each noise has 11 and one of the others.
        assert!((44.0 / noises_of(&members(12.0)) - 12.0).abs() < 1e-12);
        assert_eq!((noises_of(&members(11.0)), noises_of(&[])), (4.0, 1.0));
    }

    #[test]
    fn a_noise_that_is_found_beside_stated_ones_has_its_own_degrees_of_freedom() {
        let mut session = sarcos_shoulder().session(0);
        session.poses.iter_mut().filter_map(|pose| pose.torque[0].as_mut()).for_each(|reading| reading.std = None);
        let readings = select(&session, Signals::All).only(|id| id.pose % 6 == 0);
        let solved = solved(&session, &readings);
        let own = solved.built.rows.iter().filter(|id| id.channel == 0).count() as f64;
        let found = solved.noises_found(&session).unwrap();
        assert!(found.of_channels[1..].iter().all(Option::is_none), "{:?}", found.of_channels);
        let freedom = found.of_channels[0].unwrap();
        // Of all unknowns of three joints some are its own.
        assert!(
            (own - 12.0..own - 1.0).contains(&freedom),
            "{freedom} of {own}, and {} rows in all",
            solved.built.rows.len()
        );
    }

    /// `½ χ² / f² + (n − rank) ln f` is least at the noise that the degrees of freedom give, and not at that which all readings would.
    #[test]
    fn noise_that_was_found_is_the_likeliest_by_its_degrees_of_freedom() {
        let (session, readings) = few(false);
        let found = solved(&session, &readings);
        let at = |times: f64| {
            let noise = found.readings().noise.iter().map(|noise| times * noise).collect();
            let readings = MeasurementSet { noise, ..found.readings().clone() };
            let built = build_problem(&session, &readings, &found.state(&State::nominal(&session))).unwrap();
            let solved = with_environment(|environment| solve_built(built, environment)).unwrap();
            solved.minus_log_likelihood(&session).unwrap()
        };
        let (rows, rank) = (found.judged_problem().rows() as f64, found.analysis.rank() as f64);
        let by_all = ((rows - rank) / rows).sqrt();
        assert!(by_all < 0.96, "{by_all}");
        let step = 1.0 - by_all;
        let [less, own, more] = [1.0 - 0.4 * step, 1.0, 1.0 + 0.4 * step].map(at);
        assert!(own < less && own < more, "{less} {own} {more}");
    }
}
