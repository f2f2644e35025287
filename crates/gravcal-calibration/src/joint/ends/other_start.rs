//! Another start, and the likelier of the solution and the end to which it leads.
//!
//! With − ln of the likelihood `C` of the solution and `C′` of that end,
//!
//! ```text
//!     C′ < C         that end takes the solution's place;
//!     C′ < C + 12.5  the readings tell neither from the other, and the end is kept among those that may be the true one.
//! ```
//!
//! A start that has something as declared is kept in the same way with that held: what is let go may follow the noise again.

use gravcal_estimation::BlockId;
use gravcal_identification::{IMPLAUSIBLE, SolveEnvironment, UNSETTLED, as_of_one_direction};
use gravcal_robot_model::session::Session;

use crate::joint::ends::symmetries::in_hemisphere;
use crate::joint::error::EstimateError;
use crate::joint::problem::JointProblem;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::variables::State;
use crate::judgement::Asked;

/// Iterations at most to where the rest explains the readings with something held.
pub(super) const ITERATIONS: usize = 300;

/// Where one may start again.
pub(super) struct OtherStart {
    pub start: State,
    /// What it has as declared; nothing where it has nothing so on purpose.
    pub declared: Vec<Asked>,
}

impl Solved {
    /// The likelier of this and of the end of another start, with the other beside it where that is plausible. What leads nowhere says nothing of
    /// the solution.
    pub(super) fn or_from(
        self,
        session: &Session,
        OtherStart { start, declared }: OtherStart,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let own = self.minus_log_likelihood(session)?;
        let end_from = |start: State, environment: &SolveEnvironment<'_>| {
            let end = solve_from(session, self.readings(), start, environment)?;
            in_hemisphere(session, end, environment)
        };
        let is_likelier =
            |other: &Solved| Ok::<_, EstimateError>(other.minus_log_likelihood(session)? < own + UNSETTLED);
        let rough = end_from(start.clone(), &environment.roughly());
        let end = rough.and_then(|rough| match is_likelier(&rough)? {
            true => end_from(rough.state(&State::nominal(session)), environment),
            false => Ok(rough),
        });
        let Ok(other) = end else { return Ok(self) };
        if !other.estimate.termination.converged() || other.hemisphere_contradicted {
            return Ok(self);
        }
        let of_other = other.minus_log_likelihood(session)?;
        let held = other.with_declared_held(session, &start, &declared, environment)?;
        let nominal = State::nominal(session);
        let (here, there) = (self.state(&nominal), other.state(&nominal));
        let (mut best, second) = if of_other < own { (self.replaced_by(other), here) } else { (self, there) };
        best.elsewhere.extend(((own - of_other).abs() < IMPLAUSIBLE).then_some(second));
        // Noise that each end found for itself, of few readings, may let go where holding explains as well.
        let as_declared = held.filter(|(_, growth)| of_other + growth - own.min(of_other) < IMPLAUSIBLE);
        best.elsewhere.extend(as_declared.map(|(state, _)| state));
        Ok(best)
    }

    /// Where the rest is best with these held as a start has them, and by how much ½ χ² is larger there, as if in one direction. Nothing where
    /// none is, or that cannot be solved.
    fn with_declared_held(
        &self,
        session: &Session,
        start: &State,
        declared: &[Asked],
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<(State, f64)>, EstimateError> {
        if declared.is_empty() {
            return Ok(None);
        }
        let JointProblem { problem, initial, variables, .. } =
            self.built.starting_at(session, start).resting_at_start();
        let block = |asked: &Asked| match asked {
            Asked::Gravity => variables.gravity,
            Asked::Parameter(id) => variables.block(*id),
        };
        let blocks: Vec<BlockId> = declared.iter().map(block).collect();
        let held = problem.with_fixed(&blocks, "as declared");
        let Ok(there) = environment.roughly().within(ITERATIONS).solve(&held, &initial) else { return Ok(None) };
        let growth = problem.without_reference().cost(&there.values)? - self.estimate.cost;
        let growth = as_of_one_direction(growth.max(0.0), blocks.len(), self.freedom_of_found_noise(session));
        Ok(Some((variables.state(&there.values, start), growth)))
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::{ParameterId, SensorParameter};

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    #[test]
    fn the_lower_of_two_ends_is_the_solution_and_the_other_is_kept_where_it_is_plausible() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        with_environment(|environment| {
            // The nominal offset is far off: no end holds it.
            let looked = |solved: Solved| {
                let declared = vec![ParameterId::Sensor(1, SensorParameter::PositionOffset).into()];
                solved.or_from(&session, OtherStart { start: State::nominal(&session), declared }, environment)
            };
            let lowest = solve(&session, &readings, None, environment)?;
            let least = lowest.minus_log_likelihood(&session)?;
            let offset = |state: &State| state.sensors[1][SensorParameter::PositionOffset as usize];
            // The solution, moved away from its minimum, costs more.
            for (moved, plausible) in [(1e-3, true), (1e-2, false)] {
                let mut other = solve(&session, &readings, None, environment)?;
                let block = other.built.variables.sensors[1][SensorParameter::PositionOffset as usize];
                other.estimate.values.set(block, &[other.estimate.values.scalar(block) + moved]);
                other.estimate.cost = other.built.problem.cost(&other.estimate.values)?;
                let apart = other.minus_log_likelihood(&session)? - least;
                assert_eq!(apart < IMPLAUSIBLE, plausible, "{apart}");
                let away = offset(&other.state(&State::nominal(&session)));
                let looked = looked(other)?;
                assert!((looked.minus_log_likelihood(&session)? - least).abs() < 1e-6);
                let kept: Vec<f64> = looked.elsewhere.iter().map(offset).collect();
                assert_eq!(kept, if plausible { vec![away] } else { Vec::new() });
            }
            // What leads to the same end is no other; it is as plausible.
            let looked = looked(lowest)?;
            assert!(looked.elsewhere.len() == 1 && (looked.minus_log_likelihood(&session)? - least).abs() < 1e-9);
            Ok::<_, EstimateError>(())
        })
        .unwrap();
    }
}
