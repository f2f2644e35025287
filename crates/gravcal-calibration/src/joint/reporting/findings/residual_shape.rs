//! Residuals of a shape that noise has not.

use gravcal_robot_model::session::Session;

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::judgement::in_words;

impl Answer {
    /// Says what shape residuals have, and that intervals cannot hold where that is too large.
    pub(in crate::joint::reporting) fn remark_on_residuals(&self, session: &Session, findings: &mut Findings) {
        let spoilt = self.residual_tests.iter().any(|test| test.named && test.spoils_intervals);
        in_words(session, &self.residual_tests).into_iter().for_each(|remark| findings.remark(remark));
        if spoilt {
            findings.doubt();
        }
    }
}
