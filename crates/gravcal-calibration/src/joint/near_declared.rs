//! Position sensors found far from what is declared, held against what explains the readings with these as declared.
//!
//! Where few joints move, and little, a fit may end in a valley of its own beside the true one, and its χ² says nothing of that: both
//! explain the readings. Zero positions of joints are known to a few degrees before anything is calibrated, and their gains to a few per cent. So
//! where the readings seem to determine one that is farther off, the session is solved with all such held as declared, and from there they
//! are let go:
//!
//! ```text
//!     C′ < C         that end takes the solution's place;
//!     C′ < C + 12.5  the readings tell neither from the other, and the end is kept among those that may be the true one.
//! ```

use gravcal_dynamics::JointKind;
use gravcal_identification::{IMPLAUSIBLE, SolveEnvironment};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{PriorKind, Session};

use super::error::EstimateError;
use super::measurement_set::MeasurementSet;
use super::order::Order;
use super::solve::solve;
use super::solve_from::solve_from;
use super::solved::Solved;
use super::symmetries::in_hemisphere;
use super::variables::State;

/// Farther from its nominal value, rad, no offset is declared: zero positions are known to a few degrees.
const FAR_OFFSET: f64 = 0.17;
/// Farther from its nominal value, as a share of it, no position gain is.
const FAR_GAIN: f64 = 0.1;

/// A joint and what is known of its position sensor.
type PositionParameter = (usize, SensorParameter);

impl Solved {
    /// The same, or one with position sensors nearer to what is declared where that explains the readings better; one that explains them about
    /// as well is kept beside it.
    pub(super) fn near_declared(self, session: &Session, environment: &SolveEnvironment<'_>) -> Solved {
        let far = self.told_far_from_declared(session);
        if far.is_empty() || !self.estimate.termination.converged() || self.readings.order != Order::Together {
            return self;
        }
        environment.report("position sensors as declared");
        let freed = |start: State| solve_from(session, &self.readings, start, environment);
        let found = solved_as_declared(session, &self.readings, &far, environment).and_then(freed);
        // What leads nowhere from there says nothing of the solution.
        let Ok(other) = found.and_then(|other| in_hemisphere(session, other, environment)) else { return self };
        if !other.estimate.termination.converged() || other.hemisphere_contradicted {
            return self;
        }
        let gain = self.minus_log_likelihood(session) - other.minus_log_likelihood(session);
        let (sign_known, hemisphere_contradicted) = (self.sign_known, self.hemisphere_contradicted);
        let mut elsewhere = self.elsewhere.clone();
        let (best, second) = if gain > 0.0 { (other, self) } else { (self, other) };
        elsewhere.extend((gain.abs() < IMPLAUSIBLE).then_some(second.estimate.values));
        Solved { elsewhere, sign_known, hemisphere_contradicted, ..best }
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
        let looked =
            with_environment(|environment| Ok::<_, EstimateError>(solved.near_declared(&session, environment)));
        let looked = looked.unwrap().state(&State::nominal(&session)).sensors[1][3];
        assert!((looked - found).abs() < 1e-6, "{looked} {found}");
    }
}
