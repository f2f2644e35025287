//! What goes with a joint's speed or acceleration.

use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use super::lacked::{Found, Lacked, Words};
use super::units::per_motion;
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::wording::shown;
use crate::result::{ResidualTest, ResidualTestKind};

/// What to do about inertia where poses are taken as static.
const AT_REST: &str = "Leave accelerated rows out ([readings.select]), let joints stand ([readings.still]), drive steadily, or take a recording with its inertia \
                       ([readings] motion = {}).";

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    Velocity,
    Acceleration,
    /// Of all other joints whose acceleration is known.
    AccelerationOfOthers,
}

impl Motion {
    /// Those that are looked for in a joint. Where the arm is read in motion, its inertia is in the model.
    pub fn of_joint(of: &Columns) -> Vec<Motion> {
        let mut terms = vec![Motion::Velocity, Motion::Acceleration];
        if !of.in_motion() {
            terms.push(Motion::AccelerationOfOthers);
        }
        terms
    }
}

impl Lacked for Motion {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            Motion::Velocity => vec![of.condition(channel, |pose| &pose.conditions.velocity, |_| 1.0)],
            Motion::Acceleration => vec![of.reading(channel, |pose| acceleration(of, pose, channel))],
            Motion::AccelerationOfOthers => {
                let others = others_accelerated(of, channel).into_iter();
                others.map(|(other, _)| of.reading(channel, |pose| acceleration(of, pose, other))).collect()
            }
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let first = coefficients.first().copied().unwrap_or(0.0);
        match self {
            Motion::Velocity => {
                Found::new(ResidualTestKind::Velocity, first, per_motion(of.session, (channel, channel), "s"))
            }
            Motion::Acceleration => {
                let unit = per_motion(of.session, (channel, channel), "s²");
                Found::new(ResidualTestKind::Acceleration, first, unit)
            }
            Motion::AccelerationOfOthers => {
                let others = others_accelerated(of, channel).into_iter().zip(coefficients);
                let shows = |((_, largest), coefficient): &((usize, f64), &f64)| (*coefficient * largest).abs();
                let most = others.max_by(|a, b| shows(a).total_cmp(&shows(b)));
                let (other, size) = most.map_or((channel, 0.0), |((other, _), size)| (other, *size));
                let joint = of.session.channel_name(other);
                let unit = per_motion(of.session, (channel, other), "s²");
                Found::new(ResidualTestKind::AccelerationOfOther { joint }, size, unit)
            }
        }
    }
}

/// rad/s² or m/s²; zero where it is not known.
fn acceleration(of: &Columns, pose: usize, joint: usize) -> f64 {
    of.session.poses[pose].conditions.acceleration.get(joint).copied().unwrap_or(0.0)
}

/// The other joints that are accelerated where a channel is read, each with how much at most.
fn others_accelerated(of: &Columns, channel: usize) -> Vec<(usize, f64)> {
    let largest = |joint: usize| of.poses(channel).map(|pose| acceleration(of, pose, joint).abs()).fold(0.0, f64::max);
    let others = (0..of.session.joints.len()).filter(|joint| *joint != channel);
    others.map(|joint| (joint, largest(joint))).filter(|(_, largest)| *largest > 0.0).collect()
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

pub fn of_acceleration_of_other(test: &ResidualTest, other: &str) -> Words {
    Words::new(
        format!(
            "The residual of {} goes with accelerations of other joints, most with that of {other}: {}. This is inertia.",
            test.channel,
            shown(test)
        ),
        AT_REST,
    )
}

/// What to do about inertia that the model lacks.
fn of_inertia(session: &Session, test: &ResidualTest) -> &'static str {
    let joint = session.robot.chain.joints().iter().position(|joint| joint.name == test.channel);
    let Some(joint) = joint.filter(|_| session.has_windows()) else {
        return AT_REST;
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
