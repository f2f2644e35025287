//! What a recording shows.

use gravcal_calibration::result::{EstimatorResult, deciding};
use gravcal_robot_model::Session;

use crate::explanation::Explanation;

/// What is shown.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationRecording<'a> {
    /// Identifies the recording: the same for the same input, such as a hash of it.
    pub id: &'a str,
    /// What was said beforehand, and the poses.
    pub session: &'a Session,
    /// What the estimators answered.
    pub results: &'a [EstimatorResult],
    /// All values, as a table for people.
    pub table: &'a str,
}

impl CalibrationRecording<'_> {
    /// The result that decides.
    pub(crate) fn deciding(&self) -> Option<&EstimatorResult> {
        deciding(self.results)
    }

    /// Everyone who says what the readings should be, nominal sensors first.
    pub(crate) fn explanations(&self) -> Vec<Explanation<'_>> {
        let nominal = self.deciding().and_then(Explanation::nominal);
        nominal.into_iter().chain(self.results.iter().filter_map(Explanation::of)).collect()
    }

    /// Channels of which anyone says anything, in the session's order.
    pub(crate) fn channels(&self) -> Vec<usize> {
        let explanations = self.explanations();
        let reported = |channel: &usize| explanations.iter().any(|explanation| explanation.tells(*channel));
        (0..self.session.channel_count()).filter(reported).collect()
    }
}
