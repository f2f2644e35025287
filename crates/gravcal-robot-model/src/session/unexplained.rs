//! Errors of readings beyond their stated or measured noise: friction at rest, creeping currents, whatever the model leaves out.

use super::choices::UnexplainedError;
use super::contents::Session;

impl Session {
    /// By channel. Where no noise is stated there is nothing beyond it: what is estimated from the residuals is all.
    pub fn unexplained_errors(&self) -> Vec<UnexplainedError> {
        if self.unexplained.is_empty() {
            return vec![UnexplainedError::Absent; self.channel_count()];
        }
        let of_channel =
            |(said, unstated): (&UnexplainedError, bool)| if unstated { Default::default() } else { *said };
        self.unexplained.iter().zip(self.noise_estimated()).map(of_channel).collect()
    }
}
