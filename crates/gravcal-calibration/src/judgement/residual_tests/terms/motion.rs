//! What goes with a joint's speed or acceleration.

use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use super::lacked::{Found, Lacked, Words};
use super::units::per_motion;
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::wording::shown;
use crate::result::{ResidualTest, ResidualTestKind};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    Velocity,
    Acceleration,
}

impl Lacked for Motion {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        vec![match self {
            Motion::Velocity => of.condition(channel, |pose| &pose.conditions.velocity, |_| 1.0),
            Motion::Acceleration => of.condition(channel, |pose| &pose.conditions.acceleration, |_| 1.0),
        }]
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let first = coefficients.first().copied().unwrap_or(0.0);
        match self {
            Motion::Velocity => Found::new(ResidualTestKind::Velocity, first, per_motion(of.session, channel, "s")),
            Motion::Acceleration => {
                Found::new(ResidualTestKind::Acceleration, first, per_motion(of.session, channel, "s²"))
            }
        }
    }
}

pub fn of_velocity(test: &ResidualTest) -> Words {
    Words::new(
        format!("The residual of {} goes with its speed: {}.", test.channel, shown(test)),
        "This is viscous friction (sensor_models = [{ kind = \"viscous-friction\" }]) or what comes with speed: drive slower, and both ways.",
    )
}

pub fn of_acceleration(session: &Session, test: &ResidualTest) -> Words {
    Words::new(
        format!("The residual of {} goes with its acceleration: {}. This is inertia.", test.channel, shown(test)),
        of_inertia(session, test),
    )
}

/// What to do about inertia that the model lacks.
fn of_inertia(session: &Session, test: &ResidualTest) -> &'static str {
    let joint = session.robot.chain.joints().iter().position(|joint| joint.name == test.channel);
    let Some(joint) = joint.filter(|_| session.has_windows()) else {
        return "Leave accelerated rows out ([readings.select]), let joints stand ([readings.still]), or drive steadily.";
    };
    let gain = session.nominal(ParameterId::Sensor(joint, SensorParameter::TorqueGain));
    // A rotor takes torque to speed up; what gives it is none.
    if test.size * gain > 0.0 && session.rotors.get(joint).copied().flatten().is_none() {
        return "If torque is measured by motor current, it includes the torque that accelerates the rotor: say rotor_inertia = \"unknown\" in \
                the joint's [[joint]].";
    }
    "No rotor does so: look at what the recorder did to torques (torque_lag_s and recorded_filter_hz in readings.motion), at the clock, and \
     at friction that changes its sign late."
}
