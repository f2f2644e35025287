//! How well is known numerically what bending does to the readings of windows: the torque that joints carry is followed over a width of moments
//! (`carried.rs`), and over the next it would be followed otherwise.

use gravcal_estimation::statistics::StatisticsError;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::model_error::bending_in_motion::bent_arm::{BentArm, compliances, difference};
use crate::joint::model_error::bending_in_motion::carried::WIDTHS;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// What readings would be otherwise does to the numbers.
#[derive(Clone, Debug, Default)]
pub(in crate::joint) struct UnresolvedBending {
    /// By how much each column of the problem that is judged may be off; nothing where joints do not bend in motion.
    pub moved: Vec<Vec<f64>>,
    /// What is told of it: whether intervals that allow for it hold, and words.
    pub told: Option<(bool, String)>,
}

impl Solved {
    /// By how much the numbers hang on the width over which torques are followed.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(in crate::joint) fn unresolved_bending(&self, session: &Session) -> Result<UnresolvedBending, StatisticsError> {
        let state = self.state(&State::nominal(session));
        let in_motion = self.readings().bending.as_ref().is_some_and(|bending| !bending.in_motion.is_empty());
        let arm = BentArm::of(session, self.readings(), &state).filter(|_| in_motion);
        let Some(arm) = arm else { return Ok(UnresolvedBending::default()) };
        let compliances = compliances(&state, session.joints.len());
        let (carried, place) = arm.moments.carried_by_bent_joints(&arm.session, &state, &compliances);
        let (other, agree) = arm.moments.carried_over(WIDTHS[place + 1], &arm.session, &state, &compliances);
        let [one, other] = [&carried, &other].map(|carried| arm.predictions(&compliances, carried));
        let apart = difference(&one?, &other?, 1.0);
        let Some(errors) = self.errors_of(session, |id| apart[id.pose][id.channel]) else {
            return Ok(UnresolvedBending::default());
        };
        let mut shifted = self.shifted_by(session, &[errors])?;
        let matters = shifted.iter().any(|shifted| shifted.matters);
        let largest = |channel: usize| apart.iter().map(|pose| pose[channel].abs()).fold(0.0, f64::max);
        let told = matters.then(|| (agree, in_words(session, largest, agree)));
        Ok(UnresolvedBending { moved: shifted.drain(..).map(|shifted| shifted.moved).collect(), told })
    }
}

/// `largest`: by which a reading of a channel would be otherwise, in its unit.
fn in_words(session: &Session, largest: impl Fn(usize) -> f64, agree: bool) -> String {
    let of_joint = |joint: usize| {
        let (name, unit) = (session.channel_name(joint), session.channel_unit(joint));
        format!("{name} ({} {unit})", significant(largest(joint), 2))
    };
    let listed: Vec<String> = (0..session.joints.len()).map(of_joint).collect();
    let intervals = match agree {
        true => "Intervals allow for it.",
        false => {
            "The arm moves near the frequency at which it swings on its gears, or beyond: intervals, which allow for so much, need not hold."
        }
    };
    format!(
        "The arm moves so fast that it is not known well how its joints bend, which position sensors on the motors' side do not see. Readings may be off \
         at times by as much as: {}. {intervals} Move more slowly; or, if the position sensors sit behind the gears, say so ([deflection] \
         compliance_std_rad_per_newton_metre = 0).",
        listed.join(", ")
    )
}
