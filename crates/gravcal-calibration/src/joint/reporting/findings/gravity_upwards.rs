//! Gravity that comes out upwards where no hemisphere says so.

use gravcal_robot_model::session::Session;

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;

impl Answer {
    /// Torques of the other sign are those of gravity the other way up: where it comes out upwards and no hemisphere says so, one of both
    /// is the case.
    pub(in crate::joint::reporting) fn remark_on_gravity_upwards(&self, session: &Session, findings: &mut Findings) {
        let Some(gravity) = self.gravity.as_ref().filter(|_| session.gravity.hemisphere.is_none()) else { return };
        if gravity.vector_m_per_s2[2] <= 0.0 {
            return;
        }
        findings.doubt();
        findings.reason_first([
            "Gravity comes out upwards in base coordinates. Either the base hangs or leans over, or all torques are recorded with the \
             other sign: the readings are the same in both cases. Say which: [gravity] hemisphere = [0, 0, -1] for an upright base, \
             and torque_sign = \"reversed\" ([joints]; sign of a [[force_torque_sensor]]) if the signs are the other ones; hemisphere = \
             [0, 0, 1] for a base that hangs."
                .to_owned(),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use crate::joint::reporting::findings::testing::{answer, found};
    use crate::testing::sarcos_shoulder;

    #[test]
    fn gravity_upwards_is_doubted_where_no_hemisphere_says_so() {
        let mut session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let reasons = |answer: &super::Answer, session: &super::Session| {
            found(|findings| answer.remark_on_gravity_upwards(session, findings)).1[0].len()
        };
        let declared = session.gravity.hemisphere.take();
        assert_eq!(reasons(&answer, &session), 0, "it points down");
        answer.gravity.as_mut().unwrap().vector_m_per_s2[2] = 0.1;
        assert_eq!(reasons(&answer, &session), 1);
        session.gravity.hemisphere = declared;
        assert_eq!(reasons(&answer, &session), 0);
        (session.gravity.hemisphere, answer.gravity) = (None, None);
        assert_eq!(reasons(&answer, &session), 0, "of gravity that is not told nothing is said");
    }
}
