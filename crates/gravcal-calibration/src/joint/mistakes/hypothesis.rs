//! One thing that a session may have got wrong, and how the session would be right.

use std::fmt::Debug;
use std::sync::Arc;

use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// A mistake, and what to do about it.
#[derive(Clone, Debug)]
pub(in crate::joint) struct Mistake {
    /// In a few words.
    pub what: String,
    /// In sentences.
    pub advice: String,
}

/// A mistake that explains what a solution does not.
#[derive(Clone, Debug)]
pub(in crate::joint) struct Cause {
    pub mistake: Mistake,
    /// Whether next to nothing is left to explain: what else was found of the residuals comes of it then.
    pub explains_all: bool,
}

impl From<Mistake> for Cause {
    fn from(mistake: Mistake) -> Cause {
        Cause { mistake, explains_all: true }
    }
}

/// What may be tried: each kind of mistake has a file that implements it, and `search.rs` lists them.
pub(super) trait Hypothesis: Debug + Send + Sync {
    /// The session as it would be right.
    fn made(&self, session: &Session) -> Session;

    /// The readings as that session has them.
    fn read(&self, readings: &MeasurementSet) -> MeasurementSet {
        readings.clone()
    }

    /// What it is, in a few words, and what to do about it, in sentences.
    fn words(&self, session: &Session) -> (String, String);

    /// What the session as it would be right is held against.
    fn rival(&self, _session: &Session) -> Rival {
        Rival::AsItStands
    }

    /// The same mistake where it explains the readings best with the values `found` for it; nothing of one that has no place.
    ///
    /// # Errors
    /// Where no problem can be built.
    fn placed(
        &self,
        _session: &Session,
        _readings: &MeasurementSet,
        _found: &State,
    ) -> Result<Option<Arc<dyn Hypothesis>>, EstimateError> {
        Ok(None)
    }

    /// Whether it is tried first, whatever its start costs.
    fn is_suspected(&self, _session: &Session, _solved: &Solved) -> bool {
        false
    }

    /// How many others of its kind could explain as much by chance, beside those that are listed.
    fn alternatives(&self, _session: &Session) -> f64 {
        0.0
    }

    /// Whether arms of few joints look much alike with it as with another mistake.
    fn looks_like_others(&self) -> bool {
        false
    }
}

/// What a hypothesis has to explain the readings better than.
pub(super) enum Rival {
    /// The session as it stands, from the start that is best for it.
    AsItStands,
    /// The solution that was found: an image of it would explain the readings as well, and is not as declared.
    Solution,
    /// The session as it stands, or this one that states less: it could explain the readings as well.
    AlsoWith(Box<Session>),
}
