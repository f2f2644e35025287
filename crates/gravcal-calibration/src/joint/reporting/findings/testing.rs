//! What the tests of findings share.

use gravcal_robot_model::session::Session;

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::joint::{Signals, method, select};
use crate::judgement::TestsWanted;
use crate::testing::with_environment;

/// The answer to a session, before it is looked over.
pub fn answer(session: &Session) -> Answer {
    let readings = select(session, Signals::All);
    with_environment(|environment| method::answer(session, &readings, None, TestsWanted::All, environment)).unwrap()
}

/// What something finds of a solution that has converged: why it failed, if it did, and all reasons and remarks.
pub fn found(find: impl FnOnce(&mut Findings)) -> (Option<String>, [Vec<String>; 2]) {
    let mut findings = Findings::none(true);
    find(&mut findings);
    findings.reported()
}
