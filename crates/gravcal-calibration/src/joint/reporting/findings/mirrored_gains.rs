//! Gains of the other sign than declared: sensors that read the other way.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::joint::solved::Solved;
use crate::result::ParameterResult;

/// A sign is decided by so many standard deviations.
const SIGN_DECIDED: f64 = 5.0;

/// A gain of the other sign than declared is the mirror image of a solution, not an answer. Nothing is said of what did not
/// converge.
pub(super) fn mirrored_gains(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Vec<Mistake> {
    let mut mirrored = Vec::new();
    if !solved.estimate.termination.converged() {
        return mirrored;
    }
    for (joint, ids) in solved.built.variables.sensors.iter().enumerate() {
        for quantity in [SensorParameter::TorqueGain, SensorParameter::PositionGain] {
            let name = quantity.name(&session.robot.chain.joints()[joint].name);
            let value = solved.estimate.values.scalar(ids[quantity as usize]);
            let std = parameters.iter().find(|p| p.name == name && p.determined).and_then(|p| p.std);
            let decided = std.is_some_and(|std| value.abs() > SIGN_DECIDED * std);
            if decided && value * session.joints[joint].of(quantity).nominal < 0.0 {
                let kind = if quantity == SensorParameter::TorqueGain { "torque" } else { "position" };
                let joint = &session.robot.chain.joints()[joint].name;
                mirrored.push(Mistake {
                    what: format!("reversed {kind} sensor: {joint}"),
                    advice: format!(
                        "{name} came out as {value:.4}, of the other sign than declared: the {kind} sensor of {joint} reads the \
                         other way. If it is mounted so, say {kind}_sign = \"reversed\" in its [[joint]]."
                    ),
                });
            }
        }
    }
    mirrored
}

impl Answer {
    /// Takes back what signs of gains accuse sensors of, as they come from a fit of a model that is wrong for another reason.
    pub(in crate::joint::reporting) fn forget_mirrored(&self, session: &Session, findings: &mut Findings) {
        let mirrored = mirrored_gains(session, &self.solved, &self.parameters);
        findings.forget(&mirrored.into_iter().map(|mistake| mistake.advice).collect::<Vec<_>>());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::reporting::findings::testing::answer;
    use crate::testing::sarcos_shoulder;

    #[test]
    fn beside_another_cause_no_sensor_is_accused_by_the_sign_of_its_gain() {
        let mut simulation = sarcos_shoulder();
        simulation.truth.sensors[2][0] *= -1.0;
        let session = simulation.session(0);
        let answer = answer(&session);
        let accused = |remarks: &[String]| remarks.iter().any(|r| r.contains("of the other sign than"));
        let mut findings = Findings::none(true);
        answer.remark_on_contradictions(&session, &mut findings).unwrap();
        answer.forget_mirrored(&session, &mut findings);
        let remarks = findings.reported().1.concat();
        assert!(!accused(&remarks), "{remarks:?}");
        let mut findings = Findings::none(true);
        answer.remark_on_contradictions(&session, &mut findings).unwrap();
        let remarks = findings.reported().1.concat();
        assert!(accused(&remarks), "{remarks:?}");
    }

    #[test]
    fn a_sign_is_decided_by_five_standard_deviations() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let gain = answer.solved.built.variables.sensors[1][SensorParameter::TorqueGain as usize];
        let place = answer.parameters.iter().position(|p| p.name == "joint2.torque_gain").unwrap();
        let mut accused = |value: f64, std: f64, determined: bool| {
            answer.solved.estimate.values.set(gain, &[value]);
            (answer.parameters[place].std, answer.parameters[place].determined) = (Some(std), determined);
            let mirrored = mirrored_gains(&session, &answer.solved, &answer.parameters);
            mirrored.into_iter().map(|mistake| mistake.what).collect::<Vec<_>>()
        };
        assert_eq!(accused(-5.1, 1.0, true), ["reversed torque sensor: joint2"]);
        assert_eq!([accused(-4.9, 1.0, true), accused(5.1, 1.0, true), accused(-5.1, 1.0, false)], [[""; 0]; 3]);
    }
}
