//! Errors that are large beside what gravity makes a sensor read, in words: a wrong model makes such errors.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::mistakes::hypotheses::Mistake;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::conclusion::of_instruments;
use crate::joint::reporting::findings::Findings;
use crate::result::UnexplainedResult;

/// Errors of so large a share of what gravity makes a sensor read contradict the model; from the smaller one on they are told.
const LARGE: f64 = 0.1;
pub(in crate::joint) const WARNING: f64 = 0.03;

/// The errors of one channel.
struct Errors {
    /// Of what gravity makes the channel read.
    share: f64,
    /// The channel and their size.
    text: String,
}

impl Errors {
    fn of(session: &Session, channel: usize, std: f64, share: f64) -> Errors {
        let (name, unit) = (session.channel_name(channel), session.channel_unit(channel));
        Errors { share, text: format!("{name} ({} {unit}, {:.0} %)", significant(std, 2), 100.0 * share) }
    }
}

impl Answer {
    /// Says where unexplained errors are large beside what gravity makes a sensor read. A stated size is judged as the noise is.
    pub(in crate::joint) fn remark_on_unexplained(&self, session: &Session, findings: &mut Findings) {
        let reported = self.unexplained.iter().enumerate().filter_map(|(channel, size)| {
            let UnexplainedResult { std, estimated, share_of_gravity, .. } = (*size)?;
            let share = share_of_gravity.filter(|share| estimated && *share > WARNING)?;
            Some(Errors::of(session, channel, std, share))
        });
        let (failing, warned): (Vec<_>, Vec<_>) = reported.partition(|errors| errors.share > LARGE);
        if !warned.is_empty() {
            findings.remark(format!(
                "Errors that the noise does not explain, beside what gravity makes the sensor read: {}. Intervals allow for them \
                 as far as they differ from pose to pose; what is the same in many poses (friction from one side, a drift, a \
                 wrong length or load mass) shifts values beyond their intervals.",
                listed(warned)
            ));
        }
        if !failing.is_empty() {
            findings.fail(Mistake {
                what: format!("the model contradicts the readings of {}", listed(failing)),
                advice: format!(
                    "So large a share of what gravity makes these sensors read is explained neither by gravity nor by noise. \
                         What to look at: the sign of a torque sensor (torque_sign = \"reversed\"), units, swapped columns, the \
                         hemisphere of gravity, the loads' masses, distances and poses, values given as fixed, what touches the arm or \
                         pulls at it, single bad rows.{}",
                    of_instruments(session)
                ),
            });
        }
    }

    /// Says where noise that nobody stated is so large beside what gravity makes a sensor read that something else is wrong, and whether
    /// it is.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint) fn remark_on_noise_found(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<bool, EvaluateError> {
        if !self.solved.estimate.termination.converged() {
            return Ok(false);
        }
        let sizes = self.solved.noise_beside_gravity(session)?;
        let large = sizes.iter().enumerate().filter_map(|(channel, size)| {
            let (std, share) = size.filter(|(_, share)| *share > LARGE)?;
            Some(Errors::of(session, channel, std, share))
        });
        let large: Vec<Errors> = large.collect();
        if large.is_empty() {
            return Ok(false);
        }
        let large = listed(large);
        findings.doubt_for(match session.has_windows() {
            true => format!(
                "Residuals are large beside the torque of gravity and inertia: {large}. They are taken \
                 for noise. Noise of windows is seldom so large: look at friction that is more than a Coulomb and a viscous term, at the \
                 clock, at what the recorder did to torques (torque_lag_s, recorded_filter_hz), at units, signs and swapped columns."
            ),
            false => format!(
                "Residuals are large beside the torque of gravity: {large}. They are taken for \
                 noise, as no std is stated. Noise so large is rare: look at units, signs, swapped columns, a rotation or an order of \
                 quaternions that is another, load masses, poses that are not static, single bad rows ([loss] finds these). State \
                 the std that the sensors have: what it does not explain is then told."
            ),
        });
        Ok(true)
    }
}

/// The channels, that of the largest share first.
fn listed(mut errors: Vec<Errors>) -> String {
    errors.sort_by(|a, b| b.share.total_cmp(&a.share));
    errors.into_iter().map(|errors| errors.text).collect::<Vec<_>>().join(", ")
}
