//! Errors of readings beyond their stated or measured noise: friction at rest, creeping currents, whatever the model leaves out.

use super::Session;

/// How the errors of a channel's readings are taken that their noise does not explain: as one more normal error of each reading, of
/// the same standard deviation in all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum UnexplainedError {
    /// There are none: readings scatter by their noise alone.
    #[default]
    Absent,
    /// The residuals tell how large they are.
    Estimated,
    /// They are known.
    Stated {
        /// Standard deviation, unit of the reading.
        std: f64,
    },
}

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
