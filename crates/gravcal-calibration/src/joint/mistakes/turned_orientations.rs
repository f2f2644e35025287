//! Orientations of poses that turn the other way than the session says.

use std::sync::Arc;

use gravcal_recording::Orientation;
use gravcal_robot_model::session::Session;

use super::hypothesis::Hypothesis;

/// Each is the inverse of what it is taken for.
#[derive(Clone, Copy, Debug)]
struct TurnedOrientations;

/// The one there is, where poses have orientations.
pub(super) fn all(session: &Session) -> Option<Arc<dyn Hypothesis>> {
    session.readings.orientation.is_some().then(|| Arc::new(TurnedOrientations) as Arc<dyn Hypothesis>)
}

impl Hypothesis for TurnedOrientations {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        for pose in &mut made.poses {
            let transposed = |rows: Orientation| [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows[j][i]));
            pose.orientation = pose.orientation.map(transposed);
        }
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let inverse = session.readings.orientation.as_ref().is_some_and(|columns| columns.body_from_base);
        let other = if inverse { "base-from-body" } else { "body-from-base" };
        let cure = format!("Say rotation = \"{other}\" in readings.orientation.");
        ("orientations that turn the other way".to_owned(), cure)
    }
}
