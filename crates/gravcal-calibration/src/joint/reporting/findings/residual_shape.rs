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
