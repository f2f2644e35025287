//! How well is known numerically what bending does to the readings of windows: the torque that joints carry is followed over a width of moments
//! (`carried.rs`), and over the next it would be followed otherwise. What the solution rests on is held against that.

use gravcal_estimation::statistics::StatisticsError;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::measurement_set::{Bending, Effect};
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
        let bending = self.readings().bending.as_ref().filter(|bending| !bending.in_motion.is_empty());
        let state = self.state(&State::nominal(session));
        let arm = bending.and_then(|_| BentArm::of(session, self.readings(), &state));
        let (Some(bending), Some(arm)) = (bending, arm) else { return Ok(UnresolvedBending::default()) };
        let compliances = compliances(&state, session.joints.len());
        let (carried, place) = arm.moments.carried_by_bent_joints(&arm.session, &state, &compliances);
        let (next, agree) = arm.moments.carried_over(WIDTHS[place + 1], &arm.session, &state, &compliances);
        let stiff = arm.predictions(&vec![0.0; compliances.len()], &carried)?;
        let by_next = difference(&arm.predictions(&compliances, &next)?, &stiff, 1.0);
        let apart = difference(&bending.done_in_motion(&compliances, &stiff), &by_next, 1.0);
        let errors: Vec<Vec<f64>> = self.errors_of(session, |id| apart[id.pose][id.channel]).into_iter().collect();
        let shifted = self.shifted_by(session, &errors)?;
        let matters = shifted.iter().any(|shifted| shifted.matters) || !agree;
        let largest = |channel: usize| apart.iter().map(|pose| pose[channel].abs()).fold(0.0, f64::max);
        let told = matters.then(|| (agree, in_words(session, largest, agree)));
        Ok(UnresolvedBending { moved: shifted.into_iter().map(|shifted| shifted.moved).collect(), told })
    }
}

impl Bending {
    /// What joints that bend by these compliances do to the readings of windows, as the fit has it; `like`: of the same shape.
    fn done_in_motion(&self, compliances: &[f64], like: &Effect) -> Effect {
        let bending = (0..compliances.len()).filter(|joint| self.std[*joint] > 0.0);
        let mut done: Effect = like.iter().map(|pose| vec![0.0; pose.len()]).collect();
        for (joint, effect) in bending.zip(&self.in_motion) {
            for (sum, of_pose) in done.iter_mut().zip(effect) {
                sum.iter_mut().zip(of_pose).for_each(|(sum, own)| *sum += compliances[joint] * own);
            }
        }
        done
    }
}

/// `largest`: by which a reading of a channel would be otherwise, in its unit.
fn in_words(session: &Session, largest: impl Fn(usize) -> f64, agree: bool) -> String {
    let of_joint = |joint: usize| {
        let (name, unit) = (session.channel_name(joint), session.channel_unit(joint));
        format!("{name} ({} {unit})", significant(largest(joint), 2))
    };
    let listed: Vec<String> = (0..session.joints.len()).filter(|joint| largest(*joint) > 0.0).map(of_joint).collect();
    let by = if listed.is_empty() {
        String::new()
    } else {
        format!(" The model may be off at times by as much as: {}.", listed.join(", "))
    };
    let intervals = match agree {
        true => "Intervals allow for it.",
        false => {
            "The arm moves near the frequency at which it swings on its gears, or beyond: intervals, which allow for so much, need not hold."
        }
    };
    format!(
        "The arm moves so fast that it is not known well how its joints bend, which position sensors on the motors' side do not see.{by} {intervals} \
         Move more slowly; or, if the position sensors sit behind the gears, say so ([deflection] compliance_std_rad_per_newton_metre = 0)."
    )
}
