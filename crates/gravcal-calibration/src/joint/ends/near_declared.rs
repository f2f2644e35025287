//! Position sensors and gravity found far from what is declared, held against what explains the readings with these as declared.
//!
//! Where few joints move, and little, a fit may end in a valley of its own beside the true one, and its χ² says nothing of that: both
//! explain the readings. Zero positions of joints are known to a few degrees before anything is calibrated, their gains to a few per cent, and how
//! the base stands to some degrees. So where the readings seem to determine one that is farther off, the session is solved with all such held as
//! declared, and from there they are let go; first the position sensors, then gravity:
//!
//! ```text
//!     C′ < C         that end takes the solution's place;
//!     C′ < C + 12.5  the readings tell neither from the other, and the end is kept among those that may be the true one.
//! ```
//!
//! What holds them as declared is kept in the same way: what is let go may follow the noise again.

use gravcal_dynamics::JointKind;
use gravcal_estimation::BlockId;
use gravcal_identification::{IMPLAUSIBLE, SolveEnvironment, as_of_one_direction};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};
use nalgebra::Vector3;

use crate::joint::ends::symmetries::in_hemisphere;
use crate::joint::error::EstimateError;
use crate::joint::identifiability::judged::mostly_open;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::problem::JointProblem;
use crate::joint::solved::Solved;
use crate::joint::solving::solve::solve;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::start::start_around;
use crate::joint::variables::{State, VariableIndex};
use crate::judgement::Asked;

/// Farther from its nominal value, rad, no offset is declared: zero positions are known to a few degrees.
const FAR_OFFSET: f64 = 0.17;
/// Farther from its nominal value, as a share of it, no position gain is.
const FAR_GAIN: f64 = 0.1;

/// Farther from where it is declared to point, rad, no gravity is: who mounts an arm aslant says so.
const FAR_GRAVITY: f64 = 0.17;
/// Iterations at most to where the rest explains the readings with gravity held.
const ITERATIONS: usize = 300;

/// A joint and what is known of its position sensor.
type PositionParameter = (usize, SensorParameter);

impl Solved {
    /// The same, or one nearer to what is declared where that explains the readings better; what explains them about as well is kept
    /// beside it.
    ///
    /// # Errors
    /// Where an end cannot be judged.
    pub(in crate::joint) fn near_declared(
        self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        if !self.is_minimum_of_all() {
            return Ok(self);
        }
        let far = self.told_far_from_declared(session);
        let solved = match far.is_empty() {
            true => self,
            false => {
                environment.report("position sensors as declared");
                let declared = solved_as_declared(session, self.readings(), &far, environment);
                let block = |variables: &VariableIndex, (joint, quantity): PositionParameter| {
                    variables.block(ParameterId::Sensor(joint, quantity))
                };
                let blocks = |variables: &VariableIndex| far.iter().map(|id| block(variables, *id)).collect();
                self.or_from(session, declared, blocks, environment)?
            }
        };
        // What does not explain the readings has another cause, which is looked for from there.
        let explains = solved.misfit(session)?.is_none();
        if !explains || !solved.tells_gravity_far_from_declared(session) {
            return Ok(solved);
        }
        environment.report("gravity as declared");
        let declared = solved.with_gravity_as_declared(session, environment);
        solved.or_from(session, declared, |variables| vec![variables.gravity], environment)
    }

    /// The same, or the end to which a solution leads that holds some blocks as declared, once these are let go. What leads nowhere says
    /// nothing of the solution.
    fn or_from(
        self,
        session: &Session,
        declared: Result<State, EstimateError>,
        blocks: impl Fn(&VariableIndex) -> Vec<BlockId>,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Solved, EstimateError> {
        let Ok(declared) = declared else { return Ok(self) };
        let freed = solve_from(session, self.readings(), declared.clone(), environment);
        let Ok(other) = freed.and_then(|other| in_hemisphere(session, other, environment)) else { return Ok(self) };
        if !other.estimate.termination.converged() || other.hemisphere_contradicted {
            return Ok(self);
        }
        let [own, of_other] = [self.minus_log_likelihood(session)?, other.minus_log_likelihood(session)?];
        let held = other.growth_of_holding(session, &declared, &blocks(&other.built.variables), environment)?;
        let mut best = self.or_end(session, other)?;
        let least = own.min(of_other);
        // Noise that each end found for itself, of few readings, may let go where holding explains as well.
        let as_declared = held.filter(|(_, growth)| of_other + growth - least < IMPLAUSIBLE);
        best.elsewhere.extend(as_declared.map(|(state, _)| state));
        Ok(best)
    }

    /// The likelier of two ends, with the other beside it where that is plausible.
    pub(super) fn or_end(self, session: &Session, other: Solved) -> Result<Solved, EstimateError> {
        let nominal = State::nominal(session);
        let (here, there) = (self.state(&nominal), other.state(&nominal));
        let gain = self.minus_log_likelihood(session)? - other.minus_log_likelihood(session)?;
        let (mut best, second) = if gain > 0.0 { (self.replaced_by(other), here) } else { (self, there) };
        best.elsewhere.extend((gain.abs() < IMPLAUSIBLE).then_some(second));
        Ok(best)
    }

    /// Where some blocks are as in a state and the rest is best, and by how much ½ χ² is larger there, as if in one direction. Nothing
    /// where that cannot be solved.
    fn growth_of_holding(
        &self,
        session: &Session,
        declared: &State,
        blocks: &[BlockId],
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<(State, f64)>, EstimateError> {
        let JointProblem { problem, initial, variables, .. } =
            self.built.starting_at(session, declared).resting_at_start();
        let held = problem.with_fixed(blocks, "as declared");
        let Ok(there) = environment.within(ITERATIONS).solve(&held, &initial) else { return Ok(None) };
        let growth = problem.without_reference().cost(&there.values)? - self.estimate.cost;
        let growth = as_of_one_direction(growth.max(0.0), blocks.len(), self.freedom_of_found_noise(session));
        Ok(Some((variables.state(&there.values, declared), growth)))
    }

    /// Whether the readings seem to determine gravity, far from where it is declared to point; where nothing is declared but little determined,
    /// from that of an upright base.
    fn tells_gravity_far_from_declared(&self, session: &Session) -> bool {
        let found = Vector3::from(self.state(&State::nominal(session)).gravity);
        let is_far = found.angle(&Vector3::from(session.gravity.assumed())) > FAR_GRAVITY;
        let judgement = self.judge(session);
        let doubtful = session.gravity.hemisphere.is_some() || mostly_open(session, &judgement);
        is_far && doubtful && judgement.determines(Asked::Gravity)
    }

    /// What explains the readings with gravity as it is declared.
    fn with_gravity_as_declared(
        &self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<State, EstimateError> {
        let declared = State { gravity: session.gravity.assumed(), ..State::nominal(session) };
        let start = start_around(session, self.readings(), &declared)?;
        let JointProblem { problem, initial, variables, .. } = self.built.starting_at(session, &start);
        let held = problem.with_fixed(&[variables.gravity], "as declared");
        let there = environment.within(ITERATIONS).solve(&held, &initial)?;
        Ok(variables.state(&there.values, &start))
    }

    /// The free offsets of joints that turn, and free position gains, that the readings seem to determine far from what is declared.
    fn told_far_from_declared(&self, session: &Session) -> Vec<PositionParameter> {
        let (found, judgement) = (self.state(&State::nominal(session)), self.judge(session));
        let is_far = |&(joint, quantity): &PositionParameter| {
            let id = ParameterId::Sensor(joint, quantity);
            let nominal = session.nominal(id);
            let far = match quantity {
                SensorParameter::PositionGain => FAR_GAIN * nominal.abs(),
                _ => FAR_OFFSET,
            };
            session.fixed(id).is_none() && judgement.determines(id) && (found.value(id) - nominal).abs() > far
        };
        let joints = session.robot.chain.joints().iter().enumerate();
        let turning = joints.filter(|(_, joint)| joint.kind == JointKind::Revolute).map(|(joint, _)| joint);
        let parameters = turning.flat_map(|joint| {
            [SensorParameter::PositionGain, SensorParameter::PositionOffset].map(|quantity| (joint, quantity))
        });
        parameters.filter(is_far).collect()
    }
}

/// Where the session is solved that takes these as declared.
fn solved_as_declared(
    session: &Session,
    readings: &MeasurementSet,
    parameters: &[PositionParameter],
    environment: &SolveEnvironment<'_>,
) -> Result<State, EstimateError> {
    let mut declared = session.clone();
    for (joint, quantity) in parameters {
        declared.joints[*joint].parameters[*quantity as usize].kind = PriorKind::Fixed;
    }
    Ok(solve(&declared, readings, None, environment)?.state(&State::nominal(session)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// The second joint's offset is declared so much off.
    fn declared_off(off: f64) -> (Session, Solved) {
        let mut session = sarcos_shoulder().session(0);
        session.joints[1].parameters[SensorParameter::PositionOffset as usize].nominal += off;
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        (session, solved)
    }

    #[test]
    fn what_is_found_as_declared_needs_no_second_look() {
        let (session, solved) = declared_off(0.0);
        assert_eq!(solved.told_far_from_declared(&session), []);
    }

    #[test]
    fn readings_that_contradict_a_declared_offset_keep_their_end() {
        let (session, solved) = declared_off(0.5);
        assert_eq!(solved.told_far_from_declared(&session), [(1, SensorParameter::PositionOffset)]);
        let found = solved.state(&State::nominal(&session)).sensors[1][3];
        let looked = with_environment(|environment| solved.near_declared(&session, environment));
        let looked = looked.unwrap().state(&State::nominal(&session)).sensors[1][3];
        assert!((looked - found).abs() < 1e-6, "{looked} {found}");
    }

    /// The shoulder on a base that leans so far, rad.
    fn leaning(tilt: f64) -> Session {
        let mut simulation = sarcos_shoulder();
        simulation.truth.gravity = [9.8 * tilt.sin(), 0.0, -9.8 * tilt.cos()];
        simulation.template.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        simulation.session(0)
    }

    #[test]
    fn gravity_is_looked_for_where_it_is_declared_if_it_is_found_far_from_there() {
        for (tilt, far) in [(0.1, false), (0.3, true)] {
            let session = leaning(tilt);
            let readings = select(&session, Signals::All);
            with_environment(|environment| {
                let solved = solve(&session, &readings, None, environment)?;
                assert_eq!(solved.tells_gravity_far_from_declared(&session), far);
                let found = solved.state(&State::nominal(&session)).gravity;
                let looked = solved.near_declared(&session, environment)?.state(&State::nominal(&session)).gravity;
                assert!((Vector3::from(looked) - Vector3::from(found)).norm() < 1e-6, "the base leans");
                Ok::<_, EstimateError>(())
            })
            .unwrap();
        }
    }

    #[test]
    fn the_lower_of_two_ends_is_the_solution_and_the_other_is_kept_where_it_is_plausible() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        with_environment(|environment| {
            // The nominal offset is far off: no end holds it.
            let looked = |solved: Solved| {
                let offset = |variables: &VariableIndex| vec![variables.sensors[1][3]];
                solved.or_from(&session, Ok(State::nominal(&session)), offset, environment)
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
