//! Where a solution rests of which the readings leave much open.
//!
//! Along what the readings do not say a fit follows their noise, and each method ends elsewhere: the gain of a joint that carries nothing is the
//! amplitude of a sine that is not there, and the gain of its position sensor the frequency, with as many minima as a periodogram has lines.
//! What is told must not depend on that. So with `W` from the limits of use (a standard deviation beyond which a number would mislead)
//!
//! ```text
//!     x₁ = argmin ½ χ²(x) + ½ |x − declared|²_W        one minimum, wherever the fit ended
//!     x_k = argmin ½ χ²(x) + ½ |x − x_(k−1)|²_W        and without the pull on what is determined
//! ```
//!
//! In a direction of standard deviation `σ` and limit `l` the share `(σ²/(σ² + l²))^k` of the way to what is declared is left: what is determined ends
//! where the readings want it, and what is open stays at what is declared. Where the readings do not rule that out, it is the solution.
//!
//! Why it is so, and what was tried: `docs/decisions/resting.md`.

use gravcal_estimation::{Estimate, Problem, Reference, Values};
use gravcal_identification::{IMPLAUSIBLE, SolveEnvironment, as_of_one_direction};
use gravcal_robot_model::session::Session;
use nalgebra::{Matrix3, Vector3};

use crate::joint::building::reference::WITHIN_USE;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::starting::start::start_around;
use crate::joint::variables::State;
use crate::judgement::Asked;

/// `k`: where a standard deviation is as large as its limit, an eighth of the way to what is declared is left.
const ROUNDS: usize = 3;
/// What has moved by more standard deviations is at another minimum.
const BEYOND_ERRORS: f64 = 2.0;
/// Iterations of each at most.
const ITERATIONS: usize = 3000;
/// How often one goes on at most, and how little it lowers ½ χ² then if it has ended.
const MORE: usize = 50;
const NOTHING: f64 = 1e-7;

impl Solved {
    /// The same with what is open at its declared values, or as near to them as the readings let it be.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated there.
    pub(in crate::joint) fn resting_as_declared(
        self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let open = self.open(session);
        let stays = open.is_empty() || !self.is_minimum_of_all() || !self.built.problem.constraints().is_empty();
        let Some(reference) = self.built.problem.reference().filter(|_| !stays) else { return Ok(self) };
        let firm = reference.times_as_firm(WITHIN_USE);
        let starts = [self.open_as_declared(session), Some(self.estimate.values.clone())];
        let rests = starts.into_iter().flatten();
        let mut rests = rests.map(|start| self.where_it_rests(session, &start, &firm, environment));
        let growth = |cost: f64| (cost - self.estimate.cost).max(0.0);
        let plausible = |(_, cost): &(Values, f64)| {
            as_of_one_direction(growth(*cost), open.len(), self.freedom_of_found_noise(session)) <= IMPLAUSIBLE
        };
        // What cannot be solved there says nothing.
        let Some((values, cost)) = rests.find_map(|found| found.ok().filter(plausible)) else { return Ok(self) };
        let growth_at_rest = growth(cost);
        let problem = self.built.problem.with_reference(reference.centered_at(&values));
        let built = self.built.clone().with_problem(problem);
        let estimate = Estimate { values, cost, normal_equations: None, ..self.estimate.clone() };
        let rested = Solved::judged(built, estimate)?;
        let ended = self.state(&State::nominal(session));
        let mut rested = Solved { growth_at_rest, ..self.replaced_by(rested) };
        // The pull may lead over to another minimum. Then the one before is as likely.
        let is_another = rested.has_moved_from(session, &ended);
        rested.elsewhere.extend(is_another.then_some(ended));
        Ok(rested)
    }

    /// Whether gravity or a parameter that is determined here lies beyond its errors from where it was.
    pub(in crate::joint) fn has_moved_from(&self, session: &Session, before: &State) -> bool {
        let judgement = self.judge(session);
        let here = self.state(&State::nominal(session));
        let determined = session.parameters().into_iter().filter(|id| judgement.determines(*id));
        let mut moved = determined.map(|id| ((here.value(id) - before.value(id)).abs(), self.parameter_std(id)));
        let beyond = |apart: f64, std: f64| std > 0.0 && apart > BEYOND_ERRORS * std;
        let [g, g_before] = [&here, before].map(|state| Vector3::from(state.gravity));
        let gravity_std = Matrix3::from_row_slice(&self.gravity_covariance()).trace().max(0.0).sqrt();
        let gravity_moved = judgement.determines(Asked::Gravity) && beyond((g - g_before).norm(), gravity_std);
        gravity_moved || moved.any(|(apart, std)| beyond(apart, std))
    }

    /// `x_k`, and ½ χ² there.
    fn where_it_rests(
        &self,
        session: &Session,
        start: &Values,
        firm: &Reference,
        environment: &SolveEnvironment<'_>,
    ) -> Result<(Values, f64), EstimateError> {
        let environment = environment.within(ITERATIONS);
        let mut values = start.clone();
        let mut center = self.built.starting_at(session, &State::nominal(session)).initial;
        for _ in 0..ROUNDS {
            let pulled = self.built.problem.with_reference(firm.centered_at(&center));
            values = to_the_end(&pulled, &values, &environment)?;
            center = values.clone();
        }
        let cost = self.built.problem.without_reference().cost(&values)?;
        Ok((values, cost))
    }

    /// The solution with what is open as declared, and what is linear where it then explains the readings best. Nothing where that cannot be
    /// said.
    pub(super) fn open_as_declared(&self, session: &Session) -> Option<Values> {
        let mut start = self.state(&State::nominal(session));
        self.open(session).into_iter().for_each(|id| *start.value_mut(id) = session.nominal(id));
        let start = start_around(session, self.readings(), &start).ok()?;
        Some(self.built.starting_at(session, &start).initial)
    }
}

/// Where a solve ends that goes on until it lowers the cost no more: along a bent valley each stops early.
fn to_the_end(problem: &Problem, start: &Values, environment: &SolveEnvironment<'_>) -> Result<Values, EstimateError> {
    let mut estimate = environment.solve(problem, start)?;
    for _ in 0..MORE {
        let next = environment.solve(problem, &estimate.values)?;
        let lowered = estimate.cost - next.cost;
        estimate = next;
        if lowered < NOTHING {
            break;
        }
    }
    Ok(estimate.values)
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::{ParameterId, SensorParameter};

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    const FIRST_GAIN: usize = SensorParameter::PositionGain as usize;

    /// A shoulder on a base that leans by so much, rad.
    fn leaning(tilt: f64) -> Session {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [9.8 * tilt.sin(), 0.0, -9.8 * tilt.cos()];
        simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        simulation.session(0)
    }

    /// Its solution, moved to where the first position gain is so many times as large, and where that rests.
    fn rested(session: &Session, times: f64) -> Solved {
        let readings = select(session, Signals::All);
        with_environment(|environment| {
            let Solved { built, mut estimate, .. } = solve(session, &readings, None, environment)?;
            let gain = built.variables.sensors[0][FIRST_GAIN];
            estimate.values.set(gain, &[times * estimate.values.scalar(gain)]);
            estimate.cost = built.problem.without_reference().cost(&estimate.values)?;
            Solved::judged(built, estimate)?.resting_as_declared(session, environment)
        })
        .unwrap()
    }

    #[test]
    fn what_is_open_rests_as_declared_wherever_the_fit_ended() {
        let session = leaning(0.0);
        let nominal = State::nominal(&session);
        let [one, other] = [0.7, 1.4].map(|times| rested(&session, times));
        let open = one.open(&session);
        let first = ParameterId::Sensor(0, SensorParameter::PositionGain);
        assert!(open.contains(&first), "an upright first joint reads nothing of its angle");
        let [a, b] = [&one, &other].map(|solved| solved.state(&nominal));
        assert!((a.value(first) / nominal.value(first) - 1.0).abs() < 0.05, "{}", a.value(first));
        for id in session.parameters().into_iter().filter(|id| session.fixed(*id).is_none()) {
            let apart = (a.value(id) - b.value(id)).abs();
            assert!(apart < 0.01 * one.parameter_std(id), "{}: {apart}", session.parameter_name(id));
        }
    }

    #[test]
    fn what_is_determined_is_left_where_the_readings_want_it() {
        let session = leaning(0.0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let (nominal, judgement) = (State::nominal(&session), solved.judge(&session));
        let resting = rested(&session, 1.0);
        let [before, after] = [&solved, &resting].map(|solved| solved.state(&nominal));
        let determined = |id: &ParameterId| session.fixed(*id).is_none() && judgement.determines(*id);
        for id in session.parameters().into_iter().filter(determined) {
            let (moved, std) = ((before.value(id) - after.value(id)).abs(), resting.parameter_std(id));
            assert!(moved < 0.2 * std, "{}: {moved} of {std}", session.parameter_name(id));
        }
        let cost = resting.built.problem.without_reference().cost(&resting.estimate.values).unwrap();
        assert!((cost - resting.growth_at_rest - solved.estimate.cost).abs() < 1e-6);
    }

    #[test]
    fn where_nothing_is_open_nothing_moves() {
        let session = leaning(0.3);
        let resting = rested(&session, 1.0);
        assert_eq!((resting.open(&session).len(), resting.growth_at_rest), (0, 0.0));
    }

    /// What resting moves beyond its errors was another place that explains the readings: it is not forgotten.
    #[test]
    fn where_resting_moves_gravity_the_place_before_is_kept_beside() {
        let session = leaning(0.0);
        let nominal = State::nominal(&session);
        let from_turned = |turn: f64| {
            let readings = select(&session, Signals::All);
            with_environment(|environment| {
                let Solved { built, mut estimate, .. } = solve(&session, &readings, None, environment)?;
                let g = Vector3::from_column_slice(estimate.values.get(built.variables.gravity));
                let turned = nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), turn) * g;
                estimate.values.set(built.variables.gravity, turned.as_slice());
                // As if the readings were explained there, too.
                Solved::judged(built, estimate)?.resting_as_declared(&session, environment)
            })
            .unwrap()
        };
        assert!(from_turned(0.0).elsewhere.is_empty());
        let rested = from_turned(0.05);
        let [before] = rested.elsewhere.as_slice() else { panic!("{} are kept", rested.elsewhere.len()) };
        let here = rested.state(&nominal);
        let apart = Vector3::from(before.gravity).angle(&Vector3::from(here.gravity));
        assert!((apart - 0.05).abs() < 0.01, "{apart}");
    }

    #[test]
    fn two_standard_deviations_are_no_other_place() {
        let session = leaning(0.3);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let here = solved.state(&State::nominal(&session));
        let gravity_std = Matrix3::from_row_slice(&solved.gravity_covariance()).trace().sqrt();
        let gravity_moved = |deviations: f64| {
            let mut before = here.clone();
            before.gravity[1] += deviations * gravity_std;
            solved.has_moved_from(&session, &before)
        };
        assert!(gravity_moved(2.01) && !gravity_moved(1.99));
        let second = ParameterId::Sensor(1, SensorParameter::PositionOffset);
        let parameter_moved = |deviations: f64| {
            let mut before = here.clone();
            *before.value_mut(second) -= deviations * solved.parameter_std(second);
            solved.has_moved_from(&session, &before)
        };
        assert!(parameter_moved(2.01) && !parameter_moved(1.99));
    }
}
