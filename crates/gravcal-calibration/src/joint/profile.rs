//! How well parameters are known where the problem is not linear over their errors.
//!
//! ½ χ² with one parameter held `d` from its estimate, and all others where they then explain the readings best, is its profile. Where the
//! problem is linear that grows by `½ (d/σ)²`, 2 at two standard deviations. An arc of a few degrees looks bent at an estimate
//! that noise has moved, and is no more than that where the others follow: then it grows by less, and
//!
//! ```text
//!     ½ χ²(x̂ ± d) − ½ χ²(x̂) = 2      tells a standard deviation of d/2
//! ```
//!
//! to that side at which it is larger (Bates and Watts, *Nonlinear Regression Analysis and Its Applications*, 1988, section 6.1). What
//! is known many times better than it needs to be is not looked at.

use gravcal_estimation::{EvaluateError, Problem, Values};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use super::error::EstimateError;
use super::solved::Solved;
use crate::judgement::{MATTERS, MOST_COLUMNS};
use crate::workbench::Workbench;

/// Standard deviations at which the profile is looked at, and its growth there in a linear problem.
const AWAY: f64 = 2.0;
const GROWTH: f64 = 0.5 * AWAY * AWAY;
/// A profile that grows by this share of it is as wide as the linear model says.
const LINEAR: f64 = 0.8;
/// Firmness of the reference about the estimate: the others shall follow.
const FIRMNESS: f64 = 0.1;
/// Iterations in which the others follow.
const ITERATIONS: usize = 100;

impl Solved {
    /// The same with what the profiles of told parameters say where that is more than the linear model does.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated.
    pub(super) fn with_profiles(self, session: &Session, workbench: &Workbench<'_>) -> Result<Solved, EstimateError> {
        let problem = self.judged_problem();
        if problem.columns().len() > MOST_COLUMNS {
            return Ok(self);
        }
        let limits = self.limits_of_use(session);
        let limit_of = |column: usize| limits.iter().find(|(asked, _)| *asked == column).map(|(_, limit)| *limit);
        let judgement = self.judge(session);
        let mut found = Vec::new();
        for id in session.parameters().into_iter().filter(|id| judgement.determines(*id)) {
            let columns = problem.columns_of(self.posed.layout.block(id));
            let Some((column, limit)) = columns.filter_map(|c| Some((c, limit_of(c)?))).next() else { continue };
            let std = self.spectrum.covariance().std(column);
            if std < MATTERS * limit || std > limit {
                continue;
            }
            let profile = Profile { solved: &self, problem, id, column, std, limit };
            for side in [1.0, -1.0] {
                found.extend(profile.wider(side, workbench)?.map(|std| (column, std)));
            }
        }
        Ok(Solved { profiles: found, ..self })
    }
}

/// Of one parameter.
struct Profile<'a> {
    solved: &'a Solved,
    problem: &'a Problem,
    id: ParameterId,
    column: usize,
    /// By the linear model.
    std: f64,
    /// Beyond which it is of no use.
    limit: f64,
}

impl Profile<'_> {
    /// The standard deviation that the profile tells to one side, where it is larger than that of the linear model.
    fn wider(&self, side: f64, workbench: &Workbench<'_>) -> Result<Option<f64>, EstimateError> {
        let (mut before, mut distance) = ([0.0, 0.0], AWAY * self.std);
        let mut values = self.solved.estimate.values.clone();
        loop {
            let Some((there, growth)) = self.at(side * distance, &values, workbench)? else { return Ok(None) };
            let first = before[0] == 0.0;
            if first && growth > LINEAR * GROWTH {
                return Ok(None);
            }
            let height = (growth / GROWTH).max(0.0).sqrt();
            if height >= 1.0 {
                // √ of the growth is nearly straight.
                let share = (1.0 - before[1]) / (height - before[1]);
                return Ok(Some((before[0] + share * (distance - before[0])) / AWAY));
            }
            if distance > AWAY * self.limit {
                return Ok(Some(distance / AWAY));
            }
            (before, values) = ([distance, height], there);
            distance *= 2.0;
        }
    }

    /// Where the others are with the parameter held so far away, and the growth of ½ χ² in units of the noise. Nothing where they cannot be
    /// solved for.
    fn at(
        &self,
        distance: f64,
        from: &Values,
        workbench: &Workbench<'_>,
    ) -> Result<Option<(Values, f64)>, EvaluateError> {
        let estimate = &self.solved.estimate;
        let block = self.solved.posed.layout.block(self.id);
        let moved = estimate.values.scalar(block) + distance;
        let mut start = self.led_by(moved - from.scalar(block), from);
        start.set(block, &[moved]);
        let mut held = self.problem.holding(&[block], "looked at");
        if let Some(reference) = self.solved.posed.problem.reference() {
            held = held.with_reference(reference.times_as_firm(FIRMNESS).centered_at(&estimate.values));
        }
        let Ok(there) = workbench.within(ITERATIONS).solve(&held, &start) else { return Ok(None) };
        let alone = held.without_reference();
        let freedom = self.problem.rows().saturating_sub(self.solved.spectrum.rank()).max(1) as f64;
        let noise = (2.0 * alone.cost(&estimate.values)? / freedom).max(1.0);
        let growth = (alone.cost(&there.values)? - alone.cost(&estimate.values)?) / noise;
        Ok(Some((there.values, growth)))
    }

    /// Where the linear model has the others with the parameter so much farther.
    fn led_by(&self, farther: f64, from: &Values) -> Values {
        let known = self.solved.spectrum.covariance();
        let variance = self.std * self.std;
        let columns = 0..self.problem.columns().len();
        let step: Vec<f64> = columns.map(|column| known.at(column, self.column) * farther / variance).collect();
        self.problem.retract(from, &step)
    }
}

#[cfg(test)]
mod tests {
    use gravcal_session::simulation::{Disturbance, Run};

    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::{sarcos_shoulder, with_workbench};

    use super::super::solve::solve;

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
        with_workbench(|w| solve(&session, &readings, None, w)?.with_profiles(&session, w)).unwrap()
    }

    #[test]
    fn what_is_linear_over_its_errors_is_not_widened() {
        assert!(profiled(std::f64::consts::FRAC_PI_2, 0.8).profiles.is_empty());
    }

    #[test]
    fn over_short_arcs_readings_say_less_than_the_linear_model() {
        let solved = profiled(0.2, 32.0);
        let known = solved.spectrum.covariance();
        assert!(!solved.profiles.is_empty());
        for (column, std) in &solved.profiles {
            assert!(*std > 1.05 * known.std(*column), "{column}: {std}, {}", known.std(*column));
            // By hand: the others where they explain best, with the parameter two of these deviations away, to one side or the other.
            let problem = solved.judged_problem();
            let block = problem.columns()[*column].block;
            let growth = |side: f64| {
                let mut start = solved.estimate.values.clone();
                start.set(block, &[start.scalar(block) + side * AWAY * std]);
                let held = problem.holding(&[block], "by hand").without_reference();
                let there = with_workbench(|w| Ok::<_, EstimateError>(w.within(1000).solve(&held, &start)?)).unwrap();
                there.cost - solved.estimate.cost
            };
            let least = growth(1.0).min(growth(-1.0));
            assert!(least < 1.1 * GROWTH, "{column}: {least}");
        }
    }
}
