//! What makes intervals wider than the noise of the readings does.
//!
//! | order | standard deviations | because |
//! |---|---|---|
//! | 1 | as the session chooses (`uncertainty.rs`): of the noise, times the misfit, no smaller than the jackknife's; sandwich; bootstrap | readings may err by more than their noise |
//! | 2 | each times the largest factor that places nearby, other ends and profiles give | all three ask by how much the linear model is too sure: of answers to one question the largest counts |
//! | 3 | `√(σ² + Σ Δ²)`: by each `Δ` an error moves the number that residuals or the recording show, and the model lacks | such an error has nothing to do with the others: squares add up |
//!
//! The factors of the second are those by which the noise's standard deviations are too small, whichever the session chooses. What is determined is
//! judged after it: a term that the model lacks widens a number's interval, and does not take the number away.

use std::f64::consts::{PI, TAU};

use gravcal_dynamics::JointKind;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use crate::joint::solved::{Nearby, Solved};
use crate::joint::variables::State;

/// Standard deviation that is told at least where an end of another start lies one away that is as plausible: both are within two.
const WITHIN: f64 = 0.5;

impl Solved {
    /// The same with no standard deviation less than nearby, than another end needs to be within two, than a profile tells.
    pub(in crate::joint) fn widened_beyond_linear(self, session: &Session) -> Solved {
        let known = self.analysis.covariance();
        // What nobody asks for has no factor of its own.
        let mut factors: Vec<Option<f64>> = vec![None; self.judged_problem().columns().len()];
        self.limits_of_use(session).iter().for_each(|(column, _)| factors[*column] = Some(1.0));
        let nearby = self.at_least_nearby(session);
        let other_ends = self.elsewhere.iter().flat_map(|state| self.apart(session, state));
        let other_ends = other_ends.map(|(column, apart)| (column, WITHIN * apart));
        for (column, std) in nearby.into_iter().chain(other_ends).chain(self.profiles.iter().copied()) {
            let factor = std / known.std(column).max(f64::MIN_POSITIVE);
            factors[column] = Some(factors[column].unwrap_or(1.0).max(factor));
        }
        if factors.iter().flatten().all(|factor| *factor == 1.0) {
            return self;
        }
        Solved { uncertainty: self.uncertainty.widened_together(&factors), ..self }
    }

    /// The same with each standard deviation `σ` as `√(σ² + Σ Δ²)`: by each `Δ` something that the model lacks moves the column.
    pub(in crate::joint) fn widened_by_missing_terms(self, moved: &[Vec<f64>]) -> Solved {
        // What is not determined has no standard deviation that could grow.
        let has_std: Vec<bool> =
            (0..self.judged_problem().columns().len()).map(|column| self.covariance().std(column) > 0.0).collect();
        let of_known = |moved: &Vec<f64>| {
            moved.iter().zip(&has_std).map(|(moved, has_std)| if *has_std { *moved } else { 0.0 }).collect()
        };
        let moved: Vec<Vec<f64>> = moved.iter().map(of_known).collect();
        Solved { uncertainty: self.uncertainty.with_systematic(&moved), ..self }
    }

    /// Column and standard deviation of which a place nearby tells its share. What is beyond its limit there is not determined.
    fn at_least_nearby(&self, session: &Session) -> Vec<(usize, f64)> {
        let limits = self.limits_of_use(session);
        let at_place = |Nearby { analysis, share, .. }: &Nearby| {
            let there = analysis.covariance();
            limits.iter().map(|(column, limit)| (*column, (share * there.std(*column)).min(*limit))).collect::<Vec<_>>()
        };
        self.nearby.iter().flat_map(at_place).collect()
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
            let apart = state.value(id) - self.estimate.values.scalar(block);
            let apart = if is_offset_of_turn(session, id) { within_half_a_turn(apart) } else { apart };
            problem.columns_of(block).map(move |column| (column, apart.abs()))
        };
        of_gravity.chain(session.parameters().into_iter().flat_map(of_parameter)).collect()
    }
}

/// Whether a whole turn makes no difference to a parameter.
fn is_offset_of_turn(session: &Session, id: ParameterId) -> bool {
    let turns = |joint: usize| session.robot.chain.joints()[joint].kind != JointKind::Prismatic;
    matches!(id, ParameterId::Sensor(joint, SensorParameter::PositionOffset) if turns(joint))
}

/// The same angle, rad, less whole turns.
fn within_half_a_turn(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::RankAnalysis;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// All is determined so well that nothing nearby is looked at. A whole turn of an offset is no difference.
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
        *other.value_mut(ParameterId::Sensor(1, SensorParameter::PositionOffset)) += TAU + 10.0 * std;
        let widened = Solved { elsewhere: vec![other], ..solved }.widened_beyond_linear(&session);
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
            let widened = solved.widened_beyond_linear(&session);
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
        let widened = solved.widened_beyond_linear(&session);
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
        let after = Solved { profiles, ..solved }.widened_beyond_linear(&session);
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
        let after = solved.widened_by_missing_terms(&[moved(3.0), moved(-4.0)]);
        let ratio = |column: usize| after.covariance().std(column) / before.std(column);
        assert!((ratio(5) - 26.0_f64.sqrt()).abs() < 1e-9 && (ratio(6) - 1.0).abs() < 1e-12);
    }
}
