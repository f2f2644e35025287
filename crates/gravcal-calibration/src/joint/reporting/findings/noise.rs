//! Residuals that are larger or smaller than the stated noise makes them.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::session::Session;

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::judgement::explained;
use crate::result::{NoiseSource, UncertaintyResult};

/// From here on intervals cannot be relied on though the values may.
const DOUBT: f64 = 1.5;

impl Answer {
    /// Whether readings are explained so well that intervals may hold.
    pub(in crate::joint::reporting) fn explains_its_readings(&self) -> bool {
        self.misfit.is_none_or(|misfit| misfit < DOUBT)
    }

    /// Says where residuals are larger or smaller than the stated noise makes them.
    pub(in crate::joint::reporting) fn remark_on_noise(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<(), EvaluateError> {
        if let Some(misfit) = self.misfit {
            let consequence = match self.uncertainty {
                UncertaintyResult::Noise { widened_by: Some(_), .. } => {
                    "All standard deviations are widened by that factor, which is honest only if the errors are noise."
                }
                UncertaintyResult::LargerOfNoiseAndJackknife { widened_by: Some(_), .. } => {
                    "Standard deviations are widened by that factor, and are no smaller than those of the jackknife."
                }
                _ => "Standard deviations come from the residuals, and need no widening.",
            };
            findings.remark(format!(
                "The readings are explained {misfit:.1} times worse than their stated noise (p < 0.001). {consequence} \
                 Look at the residuals of each joint: wrong lengths or load masses, friction, motion or a few bad rows \
                 make such errors; or state the std that the sensors have."
            ));
        }
        if let Some(ratio) = self.too_well_explained(session)? {
            findings.remark(format!(
                "The readings scatter only {ratio:.2} times as much as their stated noise: its std is stated about {:.1} \
                 times too large, and so is every standard deviation here. State the std of what is recorded (a mean of \
                 n samples has 1/√n of the noise), or leave it away.",
                1.0 / ratio
            ));
        }
        Ok(())
    }

    /// How many times as large as stated residuals are, where standard deviations come from a noise that is stated too large.
    fn too_well_explained(&self, session: &Session) -> Result<Option<f64>, EvaluateError> {
        let by_noise = matches!(self.uncertainty, UncertaintyResult::Noise { source: NoiseSource::Stated, .. });
        let explained = explained(session, &self.solved, self.solved.least_chi_squared())?;
        Ok(explained.too_well().filter(|_| by_noise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::reporting::findings::testing::{answer, found};
    use crate::testing::sarcos_shoulder;

    #[test]
    fn intervals_may_hold_up_to_one_and_a_half_times_the_noise() {
        let mut answer = answer(&sarcos_shoulder().session(0));
        let reliable = [None, Some(1.4), Some(1.6)].map(|misfit| {
            answer.misfit = misfit;
            answer.explains_its_readings()
        });
        assert_eq!(reliable, [true, true, false]);
    }

    /// Stated three times too large; of standard deviations that do not come from stated noise that is no matter.
    #[test]
    fn noise_that_is_stated_too_large_is_told_where_intervals_come_from_it() {
        let mut session = sarcos_shoulder().session(0);
        session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|r| r.std = Some(2.4));
        let mut answer = answer(&session);
        let remarks =
            |answer: &Answer| found(|findings| answer.remark_on_noise(&session, findings).unwrap()).1[1].concat();
        assert!(remarks(&answer).contains("about 3.0 times too large"), "{}", remarks(&answer));
        answer.uncertainty = UncertaintyResult::Noise { source: NoiseSource::Residuals, widened_by: None };
        assert_eq!(remarks(&answer), "");
    }
}
