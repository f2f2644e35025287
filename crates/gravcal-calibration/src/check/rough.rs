//! What a check says of errors that the noise does not explain: it supposes some, and what friction leaves at rest is known where joints come from both sides.

use gravcal_robot_model::session::{Session, UnexplainedError};

use super::hypothetical::ROUGH;

/// Share of its standstills to which a joint came from the same side, from which on that is said.
const ONE_SIDED: f64 = 0.8;
/// Fewer standstills to which a joint came tell nothing of its sides.
const LEAST: usize = 6;

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
    [hypothetical].into_iter().chain(from_both_sides(session)).collect()
}

/// That joints should come to their standstills from both sides, where they do not.
fn from_both_sides(session: &Session) -> Option<String> {
    let one_sided = |joint: &usize| {
        let sides = session.poses.iter().filter_map(|pose| pose.conditions.direction.get(*joint).copied());
        let sides: Vec<f64> = sides.filter(|side| *side != 0.0).collect();
        let rising = sides.iter().filter(|side| **side > 0.0).count();
        let more = rising.max(sides.len() - rising);
        sides.len() >= LEAST && more as f64 >= ONE_SIDED * sides.len() as f64
    };
    let joints: Vec<String> =
        (0..session.joints.len()).filter(one_sided).map(|joint| session.channel_name(joint)).collect();
    let stood = session.searched.iter().any(|searched| searched.standstills.is_some());
    (stood && !joints.is_empty()).then(|| {
        format!(
            "To most standstills these joints came from one side: {}. What friction leaves at rest changes its sign with the side; where \
             that is always the same, it is in the torque bias, whose interval is wider for it. Come to some poses from each side.",
            joints.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use gravcal_recording::Standstills;
    use gravcal_robot_model::session::Searched;

    use super::*;
    use crate::testing::sarcos_shoulder;

    #[test]
    fn joints_that_come_from_one_side_are_named() {
        let mut session = sarcos_shoulder().session(0);
        session.searched = vec![Searched { standstills: Some(Standstills::default()), ..Searched::default() }];
        for (index, pose) in session.poses.iter_mut().enumerate() {
            let turns = if index % 2 == 0 { 1.0 } else { -1.0 };
            pose.conditions.direction = vec![turns, if index == 3 { -1.0 } else { 1.0 }, 0.0];
        }
        let told = from_both_sides(&session).unwrap();
        assert!(told.contains("came from one side: joint2."), "{told}");
        session.poses.iter_mut().step_by(2).for_each(|pose| pose.conditions.direction[1] = -1.0);
        assert_eq!(from_both_sides(&session), None);
    }
}
