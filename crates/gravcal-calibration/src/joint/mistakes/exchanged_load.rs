//! Tables with and without the one load there is, exchanged.

use std::sync::Arc;

use gravcal_robot_model::session::Session;

use super::hypothesis::Hypothesis;

/// Poses that are said to be bare carry the load, and the other way round.
#[derive(Clone, Copy, Debug)]
struct ExchangedLoad;

/// The one there is, where some poses carry the only load, and some none.
pub(super) fn all(session: &Session) -> Option<Arc<dyn Hypothesis>> {
    let loaded = session.poses.iter().filter(|pose| pose.load.is_some()).count();
    let exchangeable = session.loads.len() == 1 && (1..session.poses.len()).contains(&loaded);
    exchangeable.then(|| Arc::new(ExchangedLoad) as Arc<dyn Hypothesis>)
}

impl Hypothesis for ExchangedLoad {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        made.poses.iter_mut().for_each(|pose| pose.load = if pose.load.is_some() { None } else { Some(0) });
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let what = format!("tables with and without load {} exchanged", session.loads[0].name);
        (what, "Exchange load = … among the [[poses]].".to_owned())
    }
}
