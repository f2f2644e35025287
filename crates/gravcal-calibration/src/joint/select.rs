//! Which readings an estimator may use.

use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::building::sweep_moments::{SweepMoments, by_sweep};
use crate::joint::measurement_set::MeasurementSet;
use crate::plan::Plan;

/// Which torque readings an estimator may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signals {
    /// All of them.
    All,
    /// Only those that the paper's steps read.
    PaperSteps,
}

/// The torque readings that an estimator may use, with a first guess of unstated noise.
pub fn select(session: &Session, signals: Signals) -> MeasurementSet {
    let moments = by_sweep(session).then(|| SweepMoments::of(session));
    let entering = |id: ReadingId| {
        id.channel >= session.joints.len() || moments.as_ref().is_none_or(|moments| moments.of_pose(id.pose).is_some())
    };
    match signals {
        Signals::All => MeasurementSet::select(session, entering),
        Signals::PaperSteps => {
            let read = Plan::new(session).readings();
            MeasurementSet::select(session, |id| read.contains(&id) && entering(id))
        }
    }
}
