//! What a check says of errors that the noise does not explain: it supposes some, and friction at rest halves where poses come in pairs.

use gravcal_robot_model::session::{Session, UnexplainedError};
use gravcal_robot_model::sweeps::stand_alike;

use super::hypothetical::ROUGH;

/// Share of the standstills with one beside them that was come to from the other side, from which on they are said to come in pairs.
const PAIRED: f64 = 0.8;

/// The share of a joint's largest torque that is supposed; nothing where the size of such errors is stated, or there are none.
pub(super) fn supposed(session: &Session) -> Option<f64> {
    session.unexplained_errors().contains(&UnexplainedError::Estimated).then_some(ROUGH)
}

/// In words; nothing where nothing is supposed.
pub(super) fn notes(session: &Session) -> Vec<String> {
    let Some(share) = supposed(session) else { return Vec::new() };
    let hypothetical = format!(
        "Standard deviations to expect allow for errors that the noise does not explain, of {} % of the largest torque that each joint carries: \
         most arms' friction leaves so much. calibrate finds how large they are: on an arm that errs less, its standard deviations are several times smaller. If \
         yours are known, state them (unexplained_std beside the std of [readings] torque).",
        100.0 * share
    );
    [hypothetical].into_iter().chain(pairs(session)).collect()
}

/// That poses should come in pairs, where those of recordings do not.
fn pairs(session: &Session) -> Option<String> {
    let stood = session.searched.iter().any(|searched| searched.standstills.is_some());
    let came = |pose: &usize| session.poses[*pose].conditions.direction.iter().any(|side| *side != 0.0);
    let poses: Vec<usize> = (0..session.poses.len()).filter(came).collect();
    if !stood || poses.is_empty() {
        return None;
    }
    let paired = poses.iter().filter(|pose| has_other_side(session, **pose)).count();
    ((paired as f64) < PAIRED * poses.len() as f64).then(|| {
        format!(
            "{paired} of {} standstills have one beside them in which the joints stand alike and came from the other side. Friction that is \
             left at rest changes its sign with the side: come to every pose from both sides, one right after the other, and it \
             cancels ([uncertainty] kind = \"jackknife\", blocks = \"pairs\" keeps them together).",
            poses.len()
        )
    })
}

/// Whether the standstill before or after is the same pose, come to from the other side by every joint that moved.
fn has_other_side(session: &Session, pose: usize) -> bool {
    let neighbours = [pose.checked_sub(1), Some(pose + 1).filter(|next| *next < session.poses.len())];
    neighbours.into_iter().flatten().any(|other| {
        let sides = [pose, other].map(|pose| &session.poses[pose].conditions.direction);
        let opposite = sides[0].iter().zip(sides[1]).all(|(a, b)| a * b <= 0.0);
        session.poses[pose].table == session.poses[other].table && opposite && stand_alike(session, pose, other)
    })
}
