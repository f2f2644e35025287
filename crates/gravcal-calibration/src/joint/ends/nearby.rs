//! What the readings say at values near the estimate that may be the true ones.

use gravcal_estimation::{RankAnalysis, Reference, Values};
use gravcal_identification::{
    AT_LEAST, BASELESS, DECISIVE, SolveEnvironment, least_informed_nearby, share_that_matters,
};
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::Session;

use crate::joint::building::reference::WITHIN_USE;
use crate::joint::ends::symmetries::{in_hemisphere, not_as_declared};
use crate::joint::error::EstimateError;
use crate::joint::identifiability::judged::mostly_open;
use crate::joint::problem::JointProblem;
use crate::joint::solved::{Nearby, Solved};
use crate::joint::solving::solve_from::solve_from;
use crate::joint::variables::State;
use crate::judgement::limits_of_use;

/// Values at which ½ χ² is larger by less are as good as the estimate: two standard deviations away.
const AS_LIKELY: f64 = 2.0;
/// Values at which ½ χ² is smaller by more are better than the estimate, which then was no minimum.
const BETTER: f64 = 0.1;
/// Standard deviation that is told at least where an end of another start lies one away that is as plausible: both are within two.
const WITHIN: f64 = 0.5;
/// How often an estimate goes on from better values, at most.
const ROUNDS: usize = 3;
/// Iterations at most to where open parameters are at their nominal values.
const ITERATIONS: usize = 100;

impl Solved {
    /// The same with values nearby that may be the true ones; from better values where there are such, as along the bend of a valley.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated nearby.
    pub(in crate::joint) fn with_nearby(
        self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let mut solved = self;
        for round in 0..=ROUNDS {
            let least = solved.estimate.cost;
            solved = solved.resting_as_declared(session, environment)?;
            solved.nearby = solved.look_around(session, environment)?;
            if round == ROUNDS {
                break;
            }
            let problem = solved.judged_problem().without_reference();
            let costs = solved.nearby.iter().map(|near| Ok((problem.cost(&near.values)?, &near.values)));
            let costs = costs.collect::<Result<Vec<_>, EstimateError>>()?;
            let lowest = costs.into_iter().min_by(|(a, _), (b, _)| a.total_cmp(b));
            let Some((_, better)) = lowest.filter(|(cost, _)| *cost < least - BETTER) else { break };
            let start = solved.built.variables.state(better, &State::nominal(session));
            // What leads nowhere leaves the estimate as it is.
            let other = solve_from(session, solved.readings(), start, environment);
            let Ok(other) = other.and_then(|other| in_hemisphere(session, other, environment)) else { break };
            let contradicts = other.hemisphere_contradicted && !solved.hemisphere_contradicted;
            let nominal = State::nominal(session);
            let [own, of_other] = [&solved, &other].map(|solution| not_as_declared(session, &solution.state(&nominal)));
            let least = if of_other > own { DECISIVE } else { 0.0 };
            if contradicts || other.minus_log_likelihood(session)? >= solved.minus_log_likelihood(session)? - least {
                break;
            }
            solved = solved.replaced_by(other);
        }
        Ok(solved)
    }

    fn look_around(&self, session: &Session, environment: &SolveEnvironment<'_>) -> Result<Vec<Nearby>, EstimateError> {
        let (problem, values) = (self.judged_problem(), &self.estimate.values);
        let Some(reference) = self.built.problem.reference() else { return Ok(Vec::new()) };
        let asked = self.limits_of_use(session);
        let known = self.analysis.covariance();
        let judgement = self.judge(session);
        let matters = share_that_matters(mostly_open(session, &judgement));
        if asked.iter().all(|(column, limit)| known.std(*column) < matters * limit) {
            return Ok(Vec::new()); // no direction makes up more of a standard deviation than there is
        }
        let plausible = reference.times_as_firm(WITHIN_USE);
        let columns = |id: &ParameterId| problem.columns_of(self.built.variables.block(*id));
        let determined: Vec<usize> =
            session.parameters().iter().filter(|id| judgement.determines(**id)).flat_map(columns).collect();
        let farther = least_informed_nearby((problem, values), &asked, &determined, (&plausible, matters))?;
        let share = |growth: f64| if growth < AS_LIKELY { 1.0 } else { AT_LEAST };
        let farther = farther.into_iter().map(|(values, growth)| (values, share(growth)));
        let (open, all) = (|id: &ParameterId| !judgement.determines(*id), |_: &ParameterId| true);
        let nominal = [
            self.nearer_to_nominal(session, open, &plausible, environment)?,
            self.nearer_to_nominal(session, all, &plausible, environment)?,
        ];
        let nominal = nominal.into_iter().flatten().map(|values| (values, 1.0));
        let aligned = self.aligned(session, &plausible, environment)?.into_iter();
        let aligned = aligned.map(|(values, growth)| (values, share(growth)));
        let mut nearby = Vec::new();
        let elsewhere = self.elsewhere.iter().map(|state| self.built.starting_at(session, state).initial);
        let elsewhere = elsewhere.map(|values| (values, 1.0));
        for (values, share) in farther.chain(nominal).chain(aligned).chain(elsewhere) {
            let analysis = RankAnalysis::new(problem, &values)?;
            let there = analysis.covariance();
            let baseless =
                |(column, limit): &&(usize, f64)| there.std(*column) > (BASELESS * known.std(*column)).max(*limit);
            let open = asked.iter().filter(baseless).map(|(column, _)| *column).collect();
            nearby.push(Nearby { values, analysis, share, open });
        }
        Ok(nearby)
    }

    /// Where some parameters have values nearer to their nominal ones, and the readings are explained as well: what is told must not depend
    /// on where the readings happened to leave what they do not determine.
    fn nearer_to_nominal(
        &self,
        session: &Session,
        drawn: impl Fn(&ParameterId) -> bool,
        plausible: &Reference,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Values>, EstimateError> {
        let (problem, variables) = (self.judged_problem(), &self.built.variables);
        let mut center = self.estimate.values.clone();
        for id in session.parameters().into_iter().filter(drawn) {
            center.set(variables.block(id), &[session.nominal(id)]);
        }
        let drawn = problem.with_reference(plausible.centered_at(&center));
        // What cannot be solved there says nothing.
        let Ok(there) = environment.within(ITERATIONS).solve(&drawn, &self.estimate.values) else { return Ok(None) };
        let alone = problem.without_reference();
        let growth = alone.cost(&there.values)? - alone.cost(&self.estimate.values)?;
        Ok((growth < AS_LIKELY).then_some(there.values))
    }

    /// The same with each standard deviation `σ` as `√(σ² + Σ Δ²)`: by each `Δ` something that the model lacks moves the column.
    pub(in crate::joint) fn widened_by(self, moved: &[Vec<f64>]) -> Solved {
        if moved.is_empty() {
            return self;
        }
        let factor = |column: usize| {
            let square: f64 = moved.iter().map(|moved| moved[column] * moved[column]).sum();
            let std = self.covariance().std(column);
            if std > 0.0 { (1.0 + square / (std * std)).sqrt() } else { 1.0 }
        };
        let factors: Vec<f64> = (0..self.judged_problem().columns().len()).map(factor).collect();
        Solved { uncertainty: self.uncertainty.widened(&factors), ..self }
    }

    /// The same with no standard deviation less than its share of one nearby.
    pub(in crate::joint) fn widened(self, session: &Session) -> Solved {
        let known = self.analysis.covariance();
        let mut factors = vec![1.0_f64; self.judged_problem().columns().len()];
        for Nearby { analysis, share, .. } in &self.nearby {
            let there = analysis.covariance();
            for (column, limit) in self.limits_of_use(session) {
                // What is beyond its limit there is not determined.
                let at_least = (share * there.std(column)).min(limit);
                factors[column] = factors[column].max(at_least / known.std(column).max(f64::MIN_POSITIVE));
            }
        }
        for (column, apart) in self.elsewhere.iter().flat_map(|state| self.apart(session, state)) {
            factors[column] = factors[column].max(WITHIN * apart / known.std(column).max(f64::MIN_POSITIVE));
        }
        for (column, std) in &self.profiles {
            factors[*column] = factors[*column].max(std / known.std(*column).max(f64::MIN_POSITIVE));
        }
        if factors.iter().all(|factor| *factor == 1.0) {
            return self;
        }
        Solved { uncertainty: self.uncertainty.widened(&factors), ..self }
    }

    /// The columns of gravity and of every parameter, and how far each lies from the estimate at another end.
    fn apart(&self, session: &Session, state: &State) -> Vec<(usize, f64)> {
        let (problem, id) = (self.judged_problem(), self.built.variables.gravity);
        let columns = problem.columns_of(id);
        let basis = problem.tangent_basis(&self.estimate.values, id);
        let off: Vec<f64> = state.gravity.iter().zip(self.estimate.values.get(id)).map(|(a, b)| a - b).collect();
        let width = columns.len();
        let along =
            |place: usize| off.iter().enumerate().map(|(row, off)| basis[row * width + place] * off).sum::<f64>();
        let of_gravity = columns.enumerate().map(|(place, column)| (column, along(place).abs()));
        let of_parameter = |id: ParameterId| {
            let block = self.built.variables.block(id);
            let apart = (state.value(id) - self.estimate.values.scalar(block)).abs();
            problem.columns_of(block).map(move |column| (column, apart))
        };
        of_gravity.chain(session.parameters().into_iter().flat_map(of_parameter)).collect()
    }

    /// Column and limit of use of gravity and every parameter.
    pub(in crate::joint) fn limits_of_use(&self, session: &Session) -> Vec<(usize, f64)> {
        let JointProblem { variables, .. } = &self.built;
        limits_of_use(session, (self.judged_problem(), &self.estimate.values), variables, &self.readings().spreads)
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// All is determined so well that nothing nearby is looked at.
    #[test]
    fn an_end_of_another_start_widens_what_differs_there() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        assert!(solved.nearby.is_empty() && solved.profiles.is_empty());
        let block = solved.built.variables.block(ParameterId::Sensor(1, SensorParameter::PositionOffset));
        let column = solved.judged_problem().columns_of(block).next().unwrap();
        let std = solved.uncertainty.covariance().std(column);
        let mut other = solved.state(&State::nominal(&session));
        *other.value_mut(ParameterId::Sensor(1, SensorParameter::PositionOffset)) += 10.0 * std;
        let widened = Solved { elsewhere: vec![other], ..solved }.widened(&session);
        // The other end lies within two of the standard deviations that are told.
        assert!((widened.uncertainty.covariance().std(column) / (5.0 * std) - 1.0).abs() < 1e-9);
    }

    /// All that is determined, by all of the readings; and what half of the poses would say at the same values.
    fn with_half_nearby(share: f64) -> (Session, Solved) {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let (problem, poses) = (solved.judged_problem(), solved.built.poses);
        let half = problem.factors().iter().enumerate().filter(|(place, _)| *place >= poses || place % 2 == 0);
        let half = problem.with_factors(half.map(|(_, factor)| factor.clone()).collect()).unwrap();
        let values = solved.estimate.values.clone();
        let analysis = RankAnalysis::new(&half, &values).unwrap();
        let nearby = vec![Nearby { values, analysis, share, open: Vec::new() }];
        (session, Solved { nearby, ..solved })
    }

    #[test]
    fn no_standard_deviation_is_less_than_its_share_of_one_nearby() {
        for share in [1.0, 0.8, 0.1] {
            let (session, solved) = with_half_nearby(share);
            let [here, there] = [&solved.analysis, &solved.nearby[0].analysis].map(|a| a.covariance().clone());
            let asked = solved.limits_of_use(&session);
            let widened = solved.widened(&session);
            for (column, _) in asked {
                let expected = here.std(column).max(share * there.std(column));
                let told = widened.covariance().std(column);
                assert!((told - expected).abs() <= 1e-9 * expected, "{column}: {told} {expected}");
            }
        }
    }

    #[test]
    fn beyond_the_limit_of_use_nothing_is_widened() {
        let (session, solved) = with_half_nearby(1e9);
        let asked = solved.limits_of_use(&session);
        let known: Vec<usize> =
            asked.iter().map(|(column, _)| *column).filter(|column| solved.covariance().std(*column) > 0.0).collect();
        let widened = solved.widened(&session);
        for (column, limit) in asked.into_iter().filter(|(column, _)| known.contains(column)) {
            assert!((widened.covariance().std(column) / limit - 1.0).abs() < 1e-9, "{column}");
        }
    }

    #[test]
    fn a_profile_that_says_less_widens_its_column_alone() {
        let (session, solved) = with_half_nearby(0.0);
        let before = solved.covariance().clone();
        let (first, second) = (3, 4);
        let profiles = vec![(first, 3.0 * before.std(first)), (second, 0.5 * before.std(second))];
        let after = Solved { profiles, ..solved }.widened(&session);
        let ratio = |column: usize| after.covariance().std(column) / before.std(column);
        assert!((ratio(first) - 3.0).abs() < 1e-9 && (ratio(second) - 1.0).abs() < 1e-12);
    }

    /// `√(σ² + (3σ)² + (4σ)²)`.
    #[test]
    fn what_the_model_lacks_adds_to_the_variance() {
        let (_, solved) = with_half_nearby(0.0);
        let (before, count) = (solved.covariance().clone(), solved.judged_problem().columns().len());
        let moved = |times: f64| -> Vec<f64> {
            (0..count).map(|column| if column == 5 { times * before.std(column) } else { 0.0 }).collect()
        };
        let after = solved.widened_by(&[moved(3.0), moved(-4.0)]);
        let ratio = |column: usize| after.covariance().std(column) / before.std(column);
        assert!((ratio(5) - 26.0_f64.sqrt()).abs() < 1e-9 && (ratio(6) - 1.0).abs() < 1e-12);
    }
}
