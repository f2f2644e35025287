//! What the readings contradict: then there is no answer to rely on.

use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::mirrored_gains::mirrored_gains;
use crate::joint::reporting::findings::other_unit::other_unit;
use crate::joint::reporting::findings::verdict::Findings;

impl Answer {
    /// Finds all of it; of what did not converge only that it explains nothing.
    pub(in crate::joint::reporting) fn remark_on_contradictions(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<(), EstimateError> {
        self.contradicted_noise(session)?.into_iter().for_each(|mistake| findings.fail(mistake));
        if !self.solved.estimate.termination.converged() {
            return Ok(());
        }
        let found = self.contradicted_hemisphere().into_iter().chain(self.passed_constraints());
        let of_gains = mirrored_gains(session, &self.solved, &self.parameters);
        let of_unit = other_unit(session, &self.solved, &self.parameters);
        found.chain(of_gains).chain(of_unit).for_each(|mistake| findings.fail(mistake));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{ActiveConstraint, Termination};

    use crate::joint::reporting::findings::testing::{answer, found};
    use crate::testing::sarcos_shoulder;

    #[test]
    fn what_the_readings_contradict_fails_and_what_has_not_converged_contradicts_nothing() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let failure = |answer: &super::Answer| {
            found(|findings| answer.remark_on_contradictions(&session, findings).unwrap()).0.unwrap_or_default()
        };
        assert_eq!(failure(&answer), "");
        let active = |name: &str| ActiveConstraint { name: name.into(), multiplier: 1.0, holds: Vec::new() };
        answer.solved.estimate.active = vec![active("mass of link1"), active("mass of link2")];
        answer.solved.leans = vec![4.9, 4.9];
        assert_eq!(failure(&answer), "");
        answer.solved.leans = vec![4.9, 5.6];
        assert_eq!(failure(&answer), "the readings contradict \"mass of link2\" by 6 standard deviations");
        answer.solved.hemisphere_contradicted = true;
        assert!(failure(&answer).contains("hemisphere"));
        answer.solved.estimate.termination = Termination::NoProgress;
        assert_eq!(failure(&answer), "");
    }
}
