//! Position readings that are in another unit than declared.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{MistakenUnit, Session};

use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::solved::Solved;
use crate::result::ParameterResult;

/// A position gain so many times larger or smaller than its nominal value is of another unit: 180/π is 57.3.
const OTHER_UNIT: f64 = 3.0;

/// Position readings that are in another unit than declared, as their gain tells.
pub(super) fn other_unit(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Option<Mistake> {
    let joints = session.robot.chain.joints().iter().enumerate();
    let mut found = joints.filter_map(|(joint, described)| {
        let name = SensorParameter::PositionGain.name(&described.name);
        let determined = parameters.iter().any(|p| p.name == name && p.determined && p.held.is_none());
        let value = solved
            .estimate
            .values
            .scalar(solved.built.variables.sensors[joint][SensorParameter::PositionGain as usize]);
        let ratio = value / session.joints[joint].of(SensorParameter::PositionGain).nominal;
        let other = determined && (ratio.abs() > OTHER_UNIT || ratio.abs() < 1.0 / OTHER_UNIT);
        other.then_some((name, ratio))
    });
    let (name, ratio) = found.next()?;
    let looks = match MistakenUnit::of_gain(ratio) {
        Some(mistaken) => format!("they {}: {}", mistaken.reported(), mistaken.cure()),
        None => "state the gain ([[joint]] position_gain = { nominal = …, unit = … })".to_owned(),
    };
    Some(Mistake {
        what: format!("{name} is {ratio:.3} times its nominal value"),
        advice: format!(
            "No position sensor is so far off its nominal gain: its readings are in another unit than declared; {looks}."
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::reporting::findings::testing::answer;
    use crate::testing::sarcos_shoulder;

    #[test]
    fn a_position_gain_three_times_off_is_of_another_unit() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let gain = answer.solved.built.variables.sensors[1][SensorParameter::PositionGain as usize];
        let mut accused = |ratio: f64, parameters: &[ParameterResult]| {
            answer.solved.estimate.values.set(gain, &[ratio]);
            other_unit(&session, &answer.solved, parameters).map(|mistake| (mistake.what, mistake.advice))
        };
        let named = |name: &str| ParameterResult { name: name.into(), ..blank(&session) };
        let determined = [named("joint1.position_gain"), named("joint2.position_gain")];
        for ratio in [2.99, 0.34, -2.99, 1.0] {
            assert!(accused(ratio, &determined).is_none(), "{ratio}");
        }
        for ratio in [3.01, 0.33, -3.01] {
            let (what, advice) = accused(ratio, &determined).unwrap();
            assert!(
                what.starts_with("joint2.position_gain is") && advice.contains("state the gain"),
                "{what} {advice}"
            );
        }
        let (_, advice) = accused(std::f64::consts::PI / 180.0, &determined).unwrap();
        assert!(advice.contains("[readings] position") && !advice.contains("state the gain"), "{advice}");
        let open = ParameterResult { determined: false, ..named("joint2.position_gain") };
        let held = ParameterResult { held: Some("given".into()), ..named("joint2.position_gain") };
        for parameter in [open, held] {
            assert!(accused(57.3, &[parameter]).is_none());
        }
    }

    fn blank(session: &Session) -> ParameterResult {
        let blank = ParameterResult::blank(session, session.parameters()[0]);
        ParameterResult { determined: true, held: None, ..blank }
    }
}
