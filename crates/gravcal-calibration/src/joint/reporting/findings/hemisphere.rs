//! Gravity in the other hemisphere than the declared one.

use gravcal_robot_model::session::Session;

use crate::joint::ends::symmetries::far_offsets;
use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::reporting::answer::Answer;
use crate::joint::variables::State;

impl Answer {
    pub(super) fn contradicted_hemisphere(&self) -> Option<Mistake> {
        self.solved.hemisphere_contradicted.then(|| Mistake {
            what: "gravity came out in the other hemisphere than the declared one".into(),
            advice: "The readings decide against [gravity] hemisphere: correct it, or look for torque sensors that \
                     are all reversed."
                .into(),
        })
    }

    /// Zeros of position sensors half a turn from where they are declared, where a hemisphere of gravity is: as many readings are explained by gravity in
    /// the other one and zeros as declared.
    pub(in crate::joint::reporting) fn half_turned_zeros(&self, session: &Session) -> Option<String> {
        let far = far_offsets(session, &self.solved.state(&State::nominal(session)));
        let told = self.gravity.is_some() && session.gravity.hemisphere.is_some();
        let names: Vec<String> = far.into_iter().map(|offset| session.parameter_name(offset)).collect();
        (told && !names.is_empty()).then(|| {
            format!(
                "With gravity in the declared hemisphere the zero of a position sensor comes out about half a turn from where it is declared: {}. Gravity in \
                 the other hemisphere may explain the readings as well, with zeros as declared: look at [gravity] hemisphere first.",
                names.join(", ")
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use gravcal_robot_model::parameter::SensorParameter;

    use super::*;
    use crate::joint::reporting::findings::testing::answer;
    use crate::testing::{sarcos_shoulder, with_environment};

    /// The answer of a session as if the zero of its second position sensor had come out so far from where it did, in half turns.
    fn turned(session: &Session, half_turns: f64) -> Answer {
        let mut answer = answer(session);
        let offset = answer.solved.built.variables.sensors[1][SensorParameter::PositionOffset as usize];
        let found = answer.solved.estimate.values.get(offset)[0];
        answer.solved.estimate.values.set(offset, &[found + PI * half_turns]);
        answer
    }

    #[test]
    fn a_zero_half_a_turn_away_leads_to_the_hemisphere() {
        let mut session = sarcos_shoulder().session(0);
        let told = |half_turns: f64| turned(&session, half_turns).half_turned_zeros(&session);
        let hint = told(1.0).unwrap();
        assert!(hint.contains("from where it is declared: joint2.position_offset. Gravity in the other"), "{hint}");
        assert_eq!(told(-0.9), Some(hint));
        assert_eq!([told(0.0), told(0.4), told(2.0)], [None, None, None]);
        let mut answer = turned(&session, 1.0);
        session.gravity.hemisphere = None;
        assert_eq!(answer.half_turned_zeros(&session), None, "no hemisphere can be wrong that is not declared");
        session.gravity.hemisphere = Some([0.0, 0.0, -1.0]);
        answer.gravity = None;
        assert_eq!(answer.half_turned_zeros(&session), None, "of gravity that is not told nothing is said");
    }

    /// Where something else explains what is wrong, that is told.
    #[test]
    fn it_is_the_first_reason_unless_the_estimate_has_failed() {
        let session = sarcos_shoulder().session(0);
        let mut answer = turned(&session, 1.0);
        let hint = answer.half_turned_zeros(&session).unwrap();
        let reasons = |answer: &Answer| {
            let findings = with_environment(|environment| answer.looked_over(&session, environment)).unwrap();
            (findings.failed(), findings.reported().1[0].clone())
        };
        let (failed, told) = reasons(&answer);
        assert!(!failed && told[0] == hint, "{told:?}");
        answer.solved.hemisphere_contradicted = true;
        let (failed, told) = reasons(&answer);
        assert!(failed && !told.contains(&hint), "{told:?}");
    }
}
