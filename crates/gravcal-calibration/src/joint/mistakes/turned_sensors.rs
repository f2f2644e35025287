//! A position sensor that reads the other way or from half a turn away, and an axis that points the other way.

use std::f64::consts::PI;
use std::sync::Arc;

use gravcal_dynamics::JointKind;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use super::hypothesis::Hypothesis;

/// A joint whose sensors are turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TurnedSensors {
    joint: usize,
    how: Turned,
}

/// How sensors of a joint are turned.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turned {
    /// The position sensor reads the other way.
    Position,
    /// Torque and position sensor both: its axis points the other way.
    Axis,
    /// The position sensor's zero is half a turn from where it is said to be.
    HalfATurn,
}

impl TurnedSensors {
    /// Each way of each joint.
    pub fn all(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
        let joints = 0..session.joints.len();
        let turns = |joint: &usize| session.robot.chain.joints()[*joint].kind == JointKind::Revolute;
        let position = joints.clone().map(TurnedSensors::position);
        let axis = joints.clone().map(TurnedSensors::axis);
        let half_turned = joints.filter(turns).map(TurnedSensors::half_a_turn);
        position.chain(axis).chain(half_turned).map(|turned| Arc::new(turned) as Arc<dyn Hypothesis>).collect()
    }

    fn position(joint: usize) -> TurnedSensors {
        TurnedSensors { joint, how: Turned::Position }
    }

    pub fn axis(joint: usize) -> TurnedSensors {
        TurnedSensors { joint, how: Turned::Axis }
    }

    pub fn half_a_turn(joint: usize) -> TurnedSensors {
        TurnedSensors { joint, how: Turned::HalfATurn }
    }
}

impl Hypothesis for TurnedSensors {
    fn made(&self, session: &Session) -> Session {
        let mut made = session.clone();
        let sensor = &mut made.joints[self.joint].parameters;
        match self.how {
            Turned::Position => sensor[SensorParameter::PositionGain as usize].nominal *= -1.0,
            Turned::Axis => {
                for gain in [SensorParameter::PositionGain, SensorParameter::TorqueGain] {
                    sensor[gain as usize].nominal *= -1.0;
                }
            }
            Turned::HalfATurn => {
                let offset = &mut sensor[SensorParameter::PositionOffset as usize].nominal;
                *offset += if *offset > 0.0 { -PI } else { PI };
            }
        }
        made
    }

    fn words(&self, session: &Session) -> (String, String) {
        let name = &session.robot.chain.joints()[self.joint].name;
        let (what, cure) = match self.how {
            Turned::Position => {
                (format!("reversed position sensor: {name}"), "Say position_sign = \"reversed\" in its [[joint]].")
            }
            Turned::Axis => (
                format!("joint that turns the other way than the robot's description says: {name}"),
                "Turn its axis round there, or say position_sign = \"reversed\" and torque_sign = \"reversed\" in its [[joint]].",
            ),
            Turned::HalfATurn => (
                format!("position sensor whose zero is half a turn away: {name}"),
                "Say position_offset = { nominal = 180, unit = \"deg\" } in its [[joint]], or add half a turn to what stands there.",
            ),
        };
        (what, cure.to_owned())
    }

    fn looks_like_others(&self) -> bool {
        self.how == Turned::Axis
    }
}
