//! Which words belong to which kind.

use gravcal_robot_model::session::Session;

use super::lacked::Words;
use super::{
    elastic, friction, harmonic, motion, position_zero, recorder, sensor_gain, sensor_zero, stated, surroundings,
};
use crate::result::{ResidualTest, ResidualTestKind as Kind};

/// What is said of a test that names something; nothing of kinds of which all channels are told in one sentence.
pub fn words_of(session: &Session, test: &ResidualTest) -> Option<Words> {
    Some(match &test.kind {
        Kind::Neighbours
        | Kind::Direction
        | Kind::Compliance
        | Kind::TorqueLag
        | Kind::TorqueFilter
        | Kind::Hysteresis
        | Kind::Creep => {
            return None;
        }
        Kind::Trend => sensor_zero::of_trend(session, test),
        Kind::TrendCurve => sensor_zero::of_curve(test),
        Kind::TrendInTables => sensor_zero::of_trend_in_tables(test),
        Kind::Settling => sensor_zero::of_settling(test),
        Kind::Tables { file } => sensor_zero::of_tables(session, test, file),
        Kind::TorqueHarmonic { order } => harmonic::of_torque(test, *order),
        Kind::PositionHarmonic { order } => harmonic::of_position(test, *order),
        Kind::Spring => elastic::of_spring(session, test),
        Kind::Velocity => motion::of_velocity(test),
        Kind::Acceleration => motion::of_acceleration(session, test),
        Kind::AccelerationOfOther { joint } => motion::of_acceleration_of_other(test, joint),
        Kind::Presliding => friction::of_presliding(test),
        Kind::LoadFriction => friction::of_load_friction(session, test),
        Kind::FrictionTrend => friction::of_trend(test),
        Kind::FrictionCurve { speed } => friction::of_curve(session, test, *speed),
        Kind::TorqueGain { file } => sensor_gain::of_tables(test, file),
        Kind::TorqueGainTrend => sensor_gain::of_trend(session, test),
        Kind::TorqueNonlinearity => sensor_gain::of_nonlinearity(session, test),
        Kind::Saturation => sensor_gain::of_saturation(session, test),
        Kind::Crosstalk { joint } => sensor_gain::of_crosstalk(session, test, joint),
        Kind::PositionOffset { file } => position_zero::of_tables(test, file),
        Kind::Backlash => position_zero::of_backlash(test),
        Kind::PositionJump { file, line } => position_zero::of_jump(test, file, *line),
        Kind::StatedSensor { parameter } => stated::of_sensor(session, test, parameter),
        Kind::LoadMass { load } => stated::of_load_mass(session, test, load),
        Kind::LoadPlacement { load } => stated::of_load_placement(test, load),
        Kind::LoadDistance { load, other } => stated::of_load_distance(test, load, other),
        Kind::JointPlacement { joint } => stated::of_joint_placement(session, test, joint),
        Kind::JointTilt { joint } => stated::of_joint_tilt(test, joint),
        Kind::Gravity { file } => surroundings::of_gravity(test, file),
        Kind::Pull => surroundings::of_pull(test),
        Kind::BaseGivesWay => surroundings::of_base(test),
        Kind::ClockRate => recorder::of_clock(test),
    })
}
