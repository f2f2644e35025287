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
//! to that side at which it is larger (Bates and Watts, *Nonlinear Regression Analysis and Its Applications*, 1988, section 6.1). The
//! others follow in steps, each from where the linear model of the last one leads. What is known many times better than it needs to
//! be is not looked at.

use gravcal_estimation::{EvaluateError, Problem, Spectrum, Values};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use super::error::EstimateError;
use super::nearby::BASELESS;
use super::solved::Solved;
use crate::judgement::{MATTERS, MOST_COLUMNS};
use crate::workbench::Workbench;

/// Standard deviations at which the profile is looked at, and its growth there in a linear problem.
const AWAY: f64 = 2.0;
const GROWTH: f64 = 0.5 * AWAY * AWAY;
/// A profile that grows by this share of it, or that share of this, is as wide as the linear model says.
const LINEAR: f64 = 0.8;
/// A step over which √ of the growth rises by so much more than in a linear problem, and by so much of what it is at two standard
/// deviations, is too long for the others to follow. It is followed by one of a quarter, and each other by one longer by half.
const STEEP: f64 = 1.25;
const RISE: f64 = 0.25;
const LONGER: f64 = 1.5;
/// Standard deviations over which the others can follow where those of the linear model have a basis.
const LEAST: f64 = 0.02;
/// Firmness of the reference about the estimate: the others shall follow.
const FIRMNESS: f64 = 0.1;
/// Iterations in which the others follow.
const ITERATIONS: usize = 30;

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
        let whole = AWAY * self.std;
        let (mut before, mut step) = (self.estimate(), whole);
        while before.distance <= AWAY * self.limit {
            let Some(point) = self.at(side, before.distance + step, &before, workbench)? else { return Ok(None) };
            if point.distance == whole && (LINEAR..1.0 / LINEAR).contains(&(point.height * point.height)) {
                return Ok(None);
            }
            if point.height - before.height > (STEEP * step / whole).max(RISE) {
                step /= 4.0;
                if step < LEAST * self.std {
                    return Ok(Some(BASELESS * self.std));
                }
                continue;
            }
            if point.height >= 1.0 {
                // √ of the growth is nearly straight.
                let share = (1.0 - before.height) / (point.height - before.height);
                let std = (before.distance + share * step) / AWAY;
                return Ok((std > self.std).then_some(std));
            }
            before = point;
            step *= LONGER;
        }
        Ok(Some(before.distance / AWAY))
    }

    fn estimate(&self) -> Point {
        Point { distance: 0.0, height: 0.0, values: self.solved.estimate.values.clone() }
    }

    /// Where the others are with the parameter held so far away. Nothing where they cannot be solved for.
    fn at(
        &self,
        side: f64,
        distance: f64,
        before: &Point,
        workbench: &Workbench<'_>,
    ) -> Result<Option<Point>, EvaluateError> {
        let estimate = &self.solved.estimate.values;
        let block = self.solved.posed.layout.block(self.id);
        let mut start = self.led_by(side * (distance - before.distance), before)?;
        start.set(block, &[estimate.scalar(block) + side * distance]);
        let mut held = self.problem.holding(&[block], "looked at");
        if let Some(reference) = self.solved.posed.problem.reference() {
            held = held.with_reference(reference.times_as_firm(FIRMNESS).centered_at(estimate));
        }
        let Ok(there) = workbench.within(ITERATIONS).solve(&held, &start) else { return Ok(None) };
        let height = (self.growth(&there.values)? / GROWTH).max(0.0).sqrt();
        Ok(Some(Point { distance, height, values: there.values }))
    }

    /// Growth of ½ χ² from the estimate, in units of the noise.
    fn growth(&self, values: &Values) -> Result<f64, EvaluateError> {
        let alone = self.problem.without_reference();
        let freedom = self.problem.rows().saturating_sub(self.solved.spectrum.rank()).max(1) as f64;
        let estimated = alone.cost(&self.solved.estimate.values)?;
        let noise = (2.0 * estimated / freedom).max(1.0);
        Ok((alone.cost(values)? - estimated) / noise)
    }

    /// Where the linear model at `from` has the others with the parameter so much farther.
    fn led_by(&self, farther: f64, from: &Point) -> Result<Values, EvaluateError> {
        let there;
        let known = if from.distance == 0.0 {
            self.solved.spectrum.covariance()
        } else {
            there = Spectrum::new(self.problem, &from.values)?;
            there.covariance()
        };
        let variance = known.at(self.column, self.column);
        let columns = 0..self.problem.columns().len();
        let step: Vec<f64> = columns.map(|column| known.at(column, self.column) * farther / variance).collect();
        Ok(self.problem.retract(&from.values, &step))
    }
}

/// Of a profile.
struct Point {
    /// From the estimate.
    distance: f64,
    /// √ of the growth, in that of a linear problem at two standard deviations.
    height: f64,
    /// Where the others explain the readings best.
    values: Values,
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
