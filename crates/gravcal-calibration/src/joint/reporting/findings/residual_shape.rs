//! Residuals of a shape that noise has not.

use std::mem::discriminant;

use gravcal_robot_model::session::Session;

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::judgement::in_words;
use crate::result::ResidualTest;

impl Answer {
    /// Says what shape residuals have, and that intervals cannot hold where that is too large.
    pub(in crate::joint::reporting) fn remark_on_residuals(&self, session: &Session, findings: &mut Findings) {
        // What is named first is the likeliest cause of whatever else does not fit.
        let spoils = |test: &&ResidualTest| test.named && test.spoils_intervals;
        let first = self.residual_tests.iter().find(spoils).map(|first| discriminant(&first.kind));
        let of_first = |test: &ResidualTest| spoils(&test) && first == Some(discriminant(&test.kind));
        let (causes, others): (Vec<_>, Vec<_>) = self.residual_tests.iter().cloned().partition(of_first);
        in_words(session, &causes).into_iter().for_each(|cause| findings.doubt_for(cause));
        in_words(session, &others).into_iter().for_each(|remark| findings.remark(remark));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::reporting::findings::testing::answer;
    use crate::result::ResidualTestKind::{self, Crosstalk, Trend, Velocity};
    use crate::result::Verdict;
    use crate::testing::sarcos_shoulder;

    /// What is named after it may be its consequence, and what is small is harmless: remarks.
    #[test]
    fn what_residual_tests_name_first_is_why_intervals_are_in_doubt() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let some = answer.residual_tests[0].clone();
        let test = |channel: &str, kind: ResidualTestKind, named: bool, spoils_intervals: bool| {
            let channel = channel.into();
            ResidualTest { channel, kind, named, spoils_intervals, ..some.clone() }
        };
        let mut told = |tests: &[ResidualTest]| {
            answer.residual_tests = tests.to_vec();
            let mut findings = Findings::none(true);
            answer.remark_on_residuals(&session, &mut findings);
            (findings.verdict(true), findings.reported().1)
        };
        let torques_of = |joint: &str| Crosstalk { joint: joint.into() };
        let small = test("joint1", Velocity, true, false);
        let (verdict, [reasons, remarks]) = told(&[
            small.clone(),
            test("joint1", Trend, false, true),
            test("joint2", torques_of("joint1"), true, true),
            test("joint2", Trend, true, true),
            test("joint3", torques_of("joint2"), true, true),
        ]);
        let begin =
            |told: &[String]| told.iter().map(|told| told.chars().take(30).collect::<String>()).collect::<Vec<_>>();
        assert_eq!(verdict, Verdict::PartlyDetermined);
        assert_eq!(begin(&reasons), ["The reading of joint2 goes wit", "The reading of joint3 goes wit"]);
        assert_eq!(begin(&remarks[..2]), ["The residual of joint1 goes wi", "The residual of joint2 drifts "]);
        let (verdict, [reasons, remarks]) = told(&[small]);
        assert_eq!((verdict, reasons.len(), remarks.len()), (Verdict::Determined, 0, 1));
    }
}
