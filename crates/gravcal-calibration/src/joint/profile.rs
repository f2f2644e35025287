//! How well parameters are known where the problem is not linear over their errors.
//!
//! ½ χ² with one parameter held `d` from its estimate, and all others where they then explain the readings best, is its profile. Where the
//! problem is linear that grows by `½ (d/σ)²`, 2 at two standard deviations. An arc of a few degrees looks bent at an estimate
//! that noise has moved, and is no more than that where the others follow: then it grows by less, and
//!
//! ```text
//!     ½ χ²(x̂ ± d) − ½ χ²(x̂) = ½ h²      tells a standard deviation of d/h,     2 ≤ h ≤ 4
//! ```
//!
//! to that side and at that height at which it is largest (Bates and Watts, *Nonlinear Regression Analysis and Its Applications*, 1988,
//! section 6.1). A valley that is steep at first and flat beyond is as wide as it is there. The others follow in steps, each from where the
//! linear model of the last one leads. Among them gains stay plausible, which counts: a joint whose gain is zero moves no more, and any
//! constant would explain its readings. What is known many times better than it needs to be is not looked at.

use gravcal_estimation::{EvaluateError, Problem, Reference, Spectrum, Values, in_parallel};
use gravcal_robot_model::parameter::{ParameterId, Quantity};
use gravcal_robot_model::session::{KnowledgeKind, Session};

use super::error::EstimateError;
use super::nearby::BASELESS;
use super::reference::WIDTH;
use super::solved::Solved;
use crate::judgement::{MATTERS, MOST_COLUMNS};
use crate::workbench::Workbench;

/// Standard deviations at which the profile is looked at, and its growth there in a linear problem.
const AWAY: f64 = 2.0;
const GROWTH: f64 = 0.5 * AWAY * AWAY;
/// A profile that grows by this share of it, or that share of this, is as wide as the linear model says.
const LINEAR: f64 = 0.8;
/// √ of the growth, in that at two standard deviations, up to which the profile is followed: four.
const HIGHEST: f64 = 2.0;
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
        let reference = self.reference_of_others(session);
        let freedom = problem.rows().saturating_sub(self.spectrum.rank()).max(1) as f64;
        let noise = (2.0 * problem.without_reference().cost(&self.estimate.values)? / freedom).max(1.0);
        let determined: Vec<ParameterId> =
            session.parameters().into_iter().filter(|id| judgement.determines(*id)).collect();
        let wider = |id: &ParameterId| -> Result<Vec<(usize, f64)>, EstimateError> {
            let columns = problem.columns_of(self.posed.layout.block(*id));
            let Some((column, limit)) = columns.filter_map(|c| Some((c, limit_of(c)?))).next() else {
                return Ok(Vec::new());
            };
            let std = self.spectrum.covariance().std(column);
            if std < MATTERS * limit || std > limit {
                return Ok(Vec::new());
            }
            let profile =
                Profile { solved: &self, problem, id: *id, column, std, limit, reference: reference.as_ref(), noise };
            let mut found = Vec::new();
            for side in [1.0, -1.0] {
                let std = profile.wider(side, workbench)?;
                found.extend(std.map(|std| (column, std)));
                if std.is_some_and(|std| std > limit) {
                    break;
                }
            }
            Ok(found)
        };
        let found: Vec<Vec<_>> = in_parallel(&determined, wider).into_iter().collect::<Result<_, _>>()?;
        Ok(Solved { profiles: found.concat(), ..self })
    }

    /// A soft reference about the estimate; of gains one as firm as in the fit, about their nominal values: readings of a joint whose gain is
    /// zero are explained by any constant.
    fn reference_of_others(&self, session: &Session) -> Option<Reference> {
        let is_gain = |id: &ParameterId| {
            let quantity = matches!(id, ParameterId::Sensor(_, Quantity::TorqueGain | Quantity::PositionGain));
            quantity && !matches!(session.knowledge(*id).kind, KnowledgeKind::Prior { .. })
        };
        let gains: Vec<ParameterId> = session.parameters().into_iter().filter(is_gain).collect();
        let (layout, mut center) = (&self.posed.layout, self.estimate.values.clone());
        gains.iter().for_each(|id| center.set(layout.block(*id), &[session.nominal(*id)]));
        let soft = self.posed.problem.reference()?.times_as_firm(FIRMNESS).centered_at(&center);
        Some(
            gains.iter().fold(soft, |soft, id| {
                soft.with(layout.block(*id), &[WIDTH * session.limit(*id, &self.readings.spreads)])
            }),
        )
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
    /// Of the others.
    reference: Option<&'a Reference>,
    /// Of the readings, as a square, where they are explained worse than their stated noise says.
    noise: f64,
}

impl Profile<'_> {
    /// The standard deviation that the profile tells to one side, where it is larger than that of the linear model.
    fn wider(&self, side: f64, workbench: &Workbench<'_>) -> Result<Option<f64>, EstimateError> {
        let Some(mut before) = self.at(side, 0.0, &self.estimate(), workbench)? else { return Ok(None) };
        let (whole, lowest) = (AWAY * self.std, before.cost);
        let (mut step, mut height, mut std) = (whole, 0.0, self.std);
        while height < HIGHEST && std <= self.limit && before.distance <= AWAY * self.limit {
            let Some(point) = self.at(side, before.distance + step, &before, workbench)? else { break };
            let risen = ((point.cost - lowest) / self.noise / GROWTH).max(0.0).sqrt();
            let is_linear = (LINEAR..1.0 / LINEAR).contains(&(risen - height).powi(2)) && step == whole;
            if !is_linear && risen - height > (STEEP * step / whole).max(RISE) {
                step /= 4.0;
                if step < LEAST * self.std {
                    std = std.max(BASELESS * self.std);
                    break;
                }
                continue;
            }
            if height < 1.0 && risen >= 1.0 {
                // √ of the growth is nearly straight.
                std = std.max((before.distance + (1.0 - height) / (risen - height) * step) / AWAY);
            }
            if risen >= 1.0 {
                std = std.max(point.distance / risen / AWAY);
            }
            (before, height) = (point, risen);
            step *= if is_linear { 1.0 } else { LONGER };
        }
        if height < 1.0 {
            std = std.max(before.distance / AWAY);
        }
        Ok((std > self.std / LINEAR).then_some(std))
    }

    fn estimate(&self) -> Point {
        Point { distance: 0.0, cost: 0.0, values: self.solved.estimate.values.clone() }
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
        if let Some(reference) = self.reference {
            held = held.with_reference(reference.clone());
        }
        let Ok(there) = workbench.within(ITERATIONS).solve(&held, &start) else { return Ok(None) };
        Ok(Some(Point { distance, cost: there.cost, values: there.values }))
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
    /// What readings, knowledge and the others' reference cost there.
    cost: f64,
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
            // By hand: the others where they explain best, with the parameter two to four of these deviations away, to one side or the
            // other, and the growth in that of a linear problem.
            let problem = solved.judged_problem();
            let block = problem.columns()[*column].block;
            let growth = |side: f64, deviations: f64| {
                let mut start = solved.estimate.values.clone();
                start.set(block, &[start.scalar(block) + side * deviations * std]);
                let held = problem.holding(&[block], "by hand").without_reference();
                let there = with_workbench(|w| Ok::<_, EstimateError>(w.within(1000).solve(&held, &start)?)).unwrap();
                (there.cost - solved.estimate.cost) / (0.5 * deviations * deviations)
            };
            let least = [2.0, 2.5, 3.0, 3.5, 4.0].map(|d| growth(1.0, d).min(growth(-1.0, d)));
            let least = least.into_iter().fold(f64::INFINITY, f64::min);
            assert!(least < 1.1, "{column}: {least}");
        }
    }
}
