//! What is looked at about a solution, and the places that are found there.

use gravcal_estimation::{Reference, Values};
use gravcal_identification::{AT_LEAST, share_that_matters};
use gravcal_robot_model::session::Session;

use crate::joint::building::reference::WITHIN_USE;
use crate::joint::identifiability::judged::mostly_open;
use crate::joint::solved::Solved;
use crate::judgement::Judgement;

/// Values at which ½ χ² is larger by less are as good as the estimate: two standard deviations away.
pub(super) const AS_LIKELY: f64 = 2.0;

/// A solution, and what is asked of its surroundings.
pub(super) struct Surroundings<'a> {
    pub session: &'a Session,
    pub solved: &'a Solved,
    pub judgement: Judgement,
    /// Column and limit of use of gravity and every parameter.
    pub asked: Vec<(usize, f64)>,
    /// Lets what the readings leave open vary by its limits of use.
    pub plausible: Reference,
    /// Share of a limit of use below which a standard deviation is of no interest.
    pub matters: f64,
}

impl<'a> Surroundings<'a> {
    /// Nothing where no direction makes up more of a standard deviation than there is.
    pub fn of(solved: &'a Solved, session: &'a Session) -> Option<Surroundings<'a>> {
        let plausible = solved.built.problem.reference()?.times_as_firm(WITHIN_USE);
        let (asked, judgement) = (solved.limits_of_use(session), solved.judge(session));
        let matters = share_that_matters(mostly_open(session, &judgement));
        let known = solved.analysis.covariance();
        let all_known = asked.iter().all(|(column, limit)| known.std(*column) < matters * limit);
        (!all_known).then_some(Surroundings { session, solved, judgement, asked, plausible, matters })
    }
}

/// Where the truth may be.
pub(super) struct Place {
    pub values: Values,
    /// Share of standard deviations there that is told at least.
    pub share: f64,
}

impl Place {
    /// Where ½ χ² is larger by so much than at the estimate.
    pub fn of_growth(values: Values, growth: f64) -> Place {
        Place { values, share: if growth < AS_LIKELY { 1.0 } else { AT_LEAST } }
    }
}
