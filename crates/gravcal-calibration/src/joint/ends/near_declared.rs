//! Position sensors and gravity as declared, where they are found far from that.
//!
//! Zero positions of joints are known to a few degrees before anything is calibrated, their gains to a few per cent, and how
//! the base stands to some degrees. So where the readings seem to determine one that is farther off, the session is solved with all such held as
//! declared: from there they are let go.

use gravcal_dynamics::JointKind;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};
use nalgebra::Vector3;

use crate::joint::ends::other_start::{ITERATIONS, OtherStart};
use crate::joint::error::EstimateError;
use crate::joint::identifiability::judged::mostly_open;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::method::solve;
use crate::joint::problem::JointProblem;
use crate::joint::solved::Solved;
use crate::joint::starting::sample::telling_part;
use crate::joint::starting::start::start_around;
use crate::joint::variables::State;
use crate::judgement::Asked;

/// Farther from its nominal value, rad, no offset is declared: zero positions are known to a few degrees.
const FAR_OFFSET: f64 = 0.17;
/// Farther from its nominal value, as a share of it, no position gain is.
const FAR_GAIN: f64 = 0.1;
/// Farther from where it is declared to point, rad, no gravity is: who mounts an arm aslant says so.
const FAR_GRAVITY: f64 = 0.17;

/// A joint and what is known of its position sensor.
type PositionParameter = (usize, SensorParameter);

/// Where the session is solved with those position sensors as declared that are found far from it.
pub(super) fn positions_as_declared(
    solved: &Solved,
    session: &Session,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<OtherStart>, EstimateError> {
    let far = solved.told_far_from_declared(session);
    if far.is_empty() {
        return Ok(Vec::new());
    }
    environment.report("position sensors as declared");
    let start = solved_as_declared(session, solved.readings(), &far, environment);
    let declared = far.into_iter().map(|(joint, quantity)| ParameterId::Sensor(joint, quantity).into()).collect();
    // What cannot be solved so is no start.
    Ok(start.ok().map(|start| OtherStart { start, declared }).into_iter().collect())
}

/// Where the readings are explained with gravity as declared, if it is found far from that.
pub(super) fn gravity_as_declared(
    solved: &Solved,
    session: &Session,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<OtherStart>, EstimateError> {
    if solved.misfit(session)?.is_some() || !solved.tells_gravity_far_from_declared(session) {
        return Ok(Vec::new());
    }
    environment.report("gravity as declared");
    let start = solved.with_gravity_as_declared(session, environment).ok();
    Ok(start.map(|start| OtherStart { start, declared: vec![Asked::Gravity] }).into_iter().collect())
}

impl Solved {
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
    Ok(solve(&declared, &telling_part(session, readings), None, environment)?.state(&State::nominal(session)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::ends::other_ends::or_other_end;
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
        let looked = with_environment(|environment| or_other_end(solved, &session, environment));
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
                let looked = or_other_end(solved, &session, environment)?.state(&State::nominal(&session)).gravity;
                assert!((Vector3::from(looked) - Vector3::from(found)).norm() < 1e-6, "the base leans");
                Ok::<_, EstimateError>(())
            })
            .unwrap();
        }
    }
}
