//! How well told parameters are known where the joint problem is not linear over their errors.
//!
//! Among what follows a parameter ([`gravcal_identification::Profiled`]) gains stay plausible: a joint whose gain is zero moves no more, and
//! any constant would explain its readings.

use gravcal_estimation::Reference;
use gravcal_identification::{MOST_COLUMNS, Profiled, SolveEnvironment, share_that_matters};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};

use crate::joint::building::reference::WIDTH;
use crate::joint::error::EstimateError;
use crate::joint::identifiability::judged::mostly_open;
use crate::joint::solved::Solved;

/// Firmness of the reference about the estimate: the others shall follow.
const FIRMNESS: f64 = 0.1;

impl Solved {
    /// The same with what the profiles of told parameters say where that is more than the linear model does.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated.
    pub(in crate::joint) fn with_profiles(
        self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let problem = self.judged_problem();
        if problem.columns().len() > MOST_COLUMNS {
            return Ok(self);
        }
        let limits = self.limits_of_use(session);
        let limit_of = |column: usize| limits.iter().find(|(asked, _)| *asked == column).map(|(_, limit)| *limit);
        let judgement = self.judge(session);
        let reference = self.reference_of_others(session);
        let determined = session.parameters().into_iter().filter(|id| judgement.determines(*id));
        let reported = |id: ParameterId| {
            let mut columns = problem.columns_of(self.built.variables.block(id));
            columns.find_map(|column| Some((column, limit_of(column)?)))
        };
        let reported: Vec<(usize, f64)> = determined.filter_map(reported).collect();
        let (values, analysis) = (&self.estimate.values, &self.analysis);
        let mostly_open = mostly_open(session, &judgement);
        let matters = share_that_matters(mostly_open);
        // Where much is open, valleys beside the one that was found explain the readings as well.
        let starts = if mostly_open { self.open_as_declared(session).into_iter().collect() } else { Vec::new() };
        let reference = reference.as_ref();
        let profiled = Profiled { problem, values, analysis, reference, matters, starts: &starts };
        let profiles = profiled.wider(&reported, environment)?;
        Ok(Solved { profiles, ..self })
    }

    /// A soft reference about the estimate; of gains one as firm as in the fit, about their nominal values: readings of a joint whose gain is
    /// zero are explained by any constant.
    fn reference_of_others(&self, session: &Session) -> Option<Reference> {
        let is_gain = |id: &ParameterId| {
            let quantity =
                matches!(id, ParameterId::Sensor(_, SensorParameter::TorqueGain | SensorParameter::PositionGain));
            quantity && !matches!(session.prior(*id).kind, PriorKind::Gaussian { .. })
        };
        let gains: Vec<ParameterId> = session.parameters().into_iter().filter(is_gain).collect();
        let (variables, mut center) = (&self.built.variables, self.estimate.values.clone());
        gains.iter().for_each(|id| center.set(variables.block(*id), &[session.nominal(*id)]));
        let soft = self.built.problem.reference()?.times_as_firm(FIRMNESS).centered_at(&center);
        Some(gains.iter().fold(soft, |soft, id| {
            soft.with(variables.block(*id), &[WIDTH * session.limit(*id, &self.readings().spreads)])
        }))
    }
}

#[cfg(test)]
mod tests {
    use gravcal_session::simulation::{Disturbance, Run};

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A simulated arm whose joints sweep this far to either side, rad, with noise of so many counts: solved, and its profiles looked at.
    fn profiled(reach: f64, counts: f64) -> Solved {
        let mut simulation = sarcos_shoulder();
        for run in &mut simulation.runs {
            let Run::Sweep { range, .. } = run else { panic!("all are sweeps") };
            *range = range.map(|end| end.signum() * reach);
        }
        simulation.disturbance = Disturbance::noise(vec![counts; 3]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        with_environment(|w| solve(&session, &readings, None, w)?.with_profiles(&session, w)).unwrap()
    }

    #[test]
    fn what_is_linear_over_its_errors_is_not_widened() {
        assert!(profiled(std::f64::consts::FRAC_PI_2, 0.8).profiles.is_empty());
    }

    #[test]
    fn over_short_arcs_readings_say_less_than_the_linear_model() {
        let solved = profiled(0.2, 32.0);
        let known = solved.analysis.covariance();
        assert!(!solved.profiles.is_empty());
        for (column, std) in &solved.profiles {
            assert!(*std > 1.05 * known.std(*column), "{column}: {std}, {}", known.std(*column));
            // By hand: the others where they explain best, with the parameter two to four of these deviations away, to one side or the
            // other, and the growth in that of a linear problem.
            let problem = solved.judged_problem();
            let block = problem.columns()[*column].block;
            let growth = |side: f64, deviations: f64| {
                let mut start = solved.estimate.values.clone();
                start.set(block, &[start.scalar(block) + side * deviations * std]);
                let fixed = problem.with_fixed(&[block], "by hand").without_reference();
                let there =
                    with_environment(|w| Ok::<_, EstimateError>(w.within(1000).solve(&fixed, &start)?)).unwrap();
                (there.cost - solved.estimate.cost) / (0.5 * deviations * deviations)
            };
            let least = [2.0, 2.5, 3.0, 3.5, 4.0].map(|d| growth(1.0, d).min(growth(-1.0, d)));
            let least = least.into_iter().fold(f64::INFINITY, f64::min);
            assert!(least < 1.1, "{column}: {least}");
        }
    }
}
