//! What a reader must know before any number, and the verdict: decided here, once.
//!
//! | verdict | when |
//! |---|---|
//! | failed | the solver did not converge, or something contradicts the readings or the session |
//! | partly determined | something that is asked for is open, or something was found that leaves intervals in doubt |
//! | determined | else |

use crate::joint::mistakes::hypothesis::{Cause, Mistake};
use crate::result::Verdict;

/// What was found of a solution.
#[derive(Debug)]
pub(in crate::joint) struct Findings {
    converged: bool,
    /// Why there is no answer to rely on, beyond that.
    failure: Option<String>,
    /// Whether intervals are in doubt.
    doubt: bool,
    /// Remarks that say why it failed, or why intervals are in doubt, in the order in which they are told.
    reasons: Vec<String>,
    /// All others, told after these.
    remarks: Vec<String>,
}

impl Findings {
    /// Nothing yet of a solution; `converged`: whether it is one.
    pub fn none(converged: bool) -> Findings {
        Findings { converged, failure: None, doubt: false, reasons: Vec::new(), remarks: Vec::new() }
    }

    /// Whether nothing can be relied on.
    pub fn failed(&self) -> bool {
        !self.converged || self.failure.is_some()
    }

    pub fn remark(&mut self, remark: String) {
        self.remarks.push(remark);
    }

    /// A likely cause, before all other reasons.
    pub fn reason_first(&mut self, reasons: impl IntoIterator<Item = String>) {
        self.reasons.splice(0..0, reasons);
    }

    /// Takes remarks back.
    pub fn forget(&mut self, remarks: &[String]) {
        [&mut self.reasons, &mut self.remarks]
            .into_iter()
            .for_each(|reported| reported.retain(|reported| !remarks.contains(reported)));
    }

    /// Intervals are in doubt.
    pub fn doubt(&mut self) {
        self.doubt = true;
    }

    /// The same, for this reason.
    pub fn doubt_for(&mut self, reason: String) {
        self.doubt = true;
        self.reasons.push(reason);
    }

    /// Nothing can be relied on, for this reason if there is none yet.
    pub fn fail(&mut self, mistake: Mistake) {
        if self.failure.is_none() || !self.converged {
            self.failure = Some(mistake.what);
        }
        self.reasons.push(mistake.advice);
    }

    /// Nothing can be relied on, and this is why.
    pub fn fail_first(&mut self, mistake: Mistake) {
        self.failure = Some(mistake.what);
        self.reason_first([mistake.advice]);
    }

    /// Nothing can be relied on, and this is why. Where it explains all, what else was found is only remarked on: it comes of the same.
    pub fn fail_because_of(&mut self, Cause { mistake, explains_all }: Cause) {
        if explains_all {
            self.remarks.splice(0..0, std::mem::take(&mut self.reasons));
        }
        self.fail_first(mistake);
    }

    /// The verdict; `complete`: whether all that is asked for is determined.
    pub fn verdict(&self, complete: bool) -> Verdict {
        match (self.failed(), complete && !self.doubt) {
            (true, _) => Verdict::Failed,
            (false, true) => Verdict::Determined,
            (false, false) => Verdict::PartlyDetermined,
        }
    }

    /// Why there is no answer to rely on, if something else than the solver says so; reasons for the verdict, and remarks.
    pub fn reported(self) -> (Option<String>, [Vec<String>; 2]) {
        (self.failure, [self.reasons, self.remarks])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mistake(what: &str) -> Mistake {
        Mistake { what: what.into(), advice: format!("mend {what}") }
    }

    #[test]
    fn a_verdict_is_the_worst_of_what_was_found() {
        let mut findings = Findings::none(true);
        assert_eq!([true, false].map(|all| findings.verdict(all)), [Verdict::Determined, Verdict::PartlyDetermined]);
        findings.doubt();
        assert_eq!(findings.verdict(true), Verdict::PartlyDetermined);
        findings.fail(mistake("a"));
        assert_eq!(findings.verdict(true), Verdict::Failed);
        assert_eq!(Findings::none(false).verdict(true), Verdict::Failed);
    }

    #[test]
    fn the_first_failure_is_the_reason_unless_one_comes_before_all() {
        let mut findings = Findings::none(true);
        findings.remark("a remark".into());
        findings.fail(mistake("a"));
        findings.fail(mistake("b"));
        findings.forget(&["a remark".into()]);
        findings.fail_first(mistake("c"));
        findings.remark("another".into());
        findings.doubt_for("d".into());
        let (failure, [reasons, remarks]) = findings.reported();
        assert_eq!(failure.as_deref(), Some("c"));
        assert_eq!(reasons, ["mend c", "mend a", "mend b", "d"]);
        assert_eq!(remarks, ["another"]);
    }

    #[test]
    fn what_explains_all_is_the_only_reason() {
        let reported = |explains_all: bool| {
            let mut findings = Findings::none(true);
            findings.fail(mistake("a"));
            findings.remark("a remark".into());
            findings.fail_because_of(Cause { mistake: mistake("b"), explains_all });
            findings.reported()
        };
        let (failure, [reasons, remarks]) = reported(true);
        assert_eq!(
            (failure.as_deref(), reasons, remarks),
            (Some("b"), vec!["mend b".into()], vec!["mend a".to_owned(), "a remark".into()])
        );
        let (failure, [reasons, remarks]) = reported(false);
        assert_eq!(
            (failure.as_deref(), reasons, remarks),
            (Some("b"), vec!["mend b".into(), "mend a".to_owned()], vec!["a remark".into()])
        );
    }
}
