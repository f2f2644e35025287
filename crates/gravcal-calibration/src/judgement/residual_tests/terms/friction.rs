//! Friction: that is left at rest, that builds up after a joint turned round, that grows with the load or with time, or is no line over the speed.

use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{Pose, Session};

use super::lacked::{Found, Lacked, Words};
use super::units::{of_coordinate, per_torque};
use crate::joint::sides_by_order;
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::friction_curve;
use crate::judgement::residual_tests::score::MATTERS;
use crate::judgement::residual_tests::wording::{SMALL, WIDENED, chance, formula, from_to, joint_of, shown, together};
use crate::result::{ResidualTest, ResidualTestKind};

/// Travel over which friction is taken to build up where that is looked for, rad or m: that of most gears.
const TRAVEL: f64 = 1e-3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// By the side from which a joint came.
    Direction,
    /// Of the size of a friction that is there at once.
    Presliding,
    /// Of an arm in motion, in share of the reading.
    OfLoad,
    /// Of friction that the model has, in share of it.
    Trend,
    /// Of an arm in motion, in the unit of the reading.
    Curve,
}

impl Friction {
    /// Those that are looked for in a joint.
    pub fn of_joint(of: &Columns, joint: usize) -> Vec<Friction> {
        let mut terms = vec![Friction::Direction];
        if of.session.terms.with_friction().contains(&joint) {
            terms.push(Friction::Trend);
        }
        if may_build_up(of.session, joint) {
            terms.push(Friction::Presliding);
        }
        if of.in_motion() {
            terms.extend([Friction::OfLoad, Friction::Curve]);
        }
        terms
    }
}

impl Lacked for Friction {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            Friction::Direction => vec![of.reading(channel, |pose| of.side(channel, pose))],
            Friction::Presliding => vec![of.reading(channel, |pose| not_built_up(of.session, channel, pose))],
            Friction::OfLoad => {
                let of_load = |pose: usize| of.predicted.reading(pose, channel).abs();
                vec![of.condition(channel, |pose| &pose.conditions.direction, of_load)]
            }
            Friction::Trend => vec![of.times_friction(channel, of.trend(channel, |_| 0))],
            Friction::Curve => over_speed(of, channel),
        }
    }

    fn as_modelled(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            Friction::Trend => vec![of.times_friction(channel, of.time_since(channel, |_| 0))],
            _ => self.columns(of, channel),
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let first = coefficients.first().copied().unwrap_or(0.0);
        let unit = of.session.channel_unit(channel);
        match self {
            Friction::Direction => Found::new(ResidualTestKind::Direction, first, unit),
            Friction::Presliding => Found::new(ResidualTestKind::Presliding, first, unit),
            Friction::OfLoad => Found::new(ResidualTestKind::LoadFriction, 100.0 * first.abs(), "%"),
            Friction::Trend => {
                Found::new(ResidualTestKind::FrictionTrend, 100.0 * first, format!("%/{}", of.unit_of_time()))
            }
            Friction::Curve => {
                let (size, share) = friction_curve::seen_most(coefficients).unwrap_or_default();
                let speed = share * highest_speed(of, channel);
                Found::new(ResidualTestKind::FrictionCurve { speed }, size, unit)
            }
        }
    }

    /// A friction takes a torque of the motion's sign.
    fn may_be(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> bool {
        let takes_torque = |size: &f64| size * sign_of_motion(of.session, channel) > 0.0;
        match self {
            Friction::Presliding | Friction::OfLoad => {
                !coefficients.is_empty() && coefficients.iter().all(takes_torque)
            }
            Friction::Direction | Friction::Trend | Friction::Curve => true,
        }
    }

    /// Gears grow warm together.
    fn is_alike_in_all_joints(&self, _of: &Columns) -> bool {
        *self == Friction::Trend
    }
}

/// The sign with which a joint's torque sensor reads a torque of the motion that its position sensor shows.
fn sign_of_motion(session: &Session, joint: usize) -> f64 {
    let gain = |gain| session.nominal(ParameterId::Sensor(joint, gain));
    gain(SensorParameter::TorqueGain) * gain(SensorParameter::PositionGain)
}

/// Whether a joint has friction in the model that is there at once, and it was followed how it would build up.
fn may_build_up(session: &Session, joint: usize) -> bool {
    let followed = |pose: &Pose| pose.conditions.presliding.get(joint).is_some_and(Option::is_some);
    session.terms.with_friction().contains(&joint)
        && !session.terms.with_presliding().contains(&joint)
        && session.poses.iter().any(followed)
}

/// What a friction of one that builds up over [`TRAVEL`] is less than one that is there at once; nothing where that is not known.
fn not_built_up(session: &Session, joint: usize, pose: usize) -> f64 {
    let followed = session.poses[pose].conditions.presliding.get(joint).copied().flatten();
    followed.map_or(0.0, |followed| followed.at(TRAVEL).0 - followed.at(0.0).0)
}

/// Terms of a friction that is no line over the speed.
fn over_speed(of: &Columns, joint: usize) -> Vec<Vec<f64>> {
    let fastest = highest_speed(of, joint);
    let term = |term: usize| {
        of.reading(joint, |pose| {
            let conditions = &of.session.poses[pose].conditions;
            let of_joint = |values: &[f64]| values.get(joint).copied().unwrap_or(0.0);
            let [direction, speed] = [&conditions.direction, &conditions.velocity].map(|values| of_joint(values));
            friction_curve::terms(direction, speed / fastest)[term]
        })
    };
    if fastest > 0.0 { (0..friction_curve::TERMS).map(term).collect() } else { Vec::new() }
}

/// The highest speed of a joint's windows, rad/s or m/s.
fn highest_speed(of: &Columns, joint: usize) -> f64 {
    let speed = |pose: usize| of.session.poses[pose].conditions.velocity.get(joint).map_or(0.0, |speed| speed.abs());
    of.poses(joint).map(speed).fold(0.0, f64::max)
}

pub fn of_presliding(test: &ResidualTest) -> Words {
    Words::new(
        format!(
            "The residual of {} shows friction that builds up after each reversal: {} of it are not there at once.",
            test.channel,
            shown(test)
        ),
        "Where the torque sensor is behind the gear this is pre-sliding: say kind = \"presliding-friction\" instead of \"coulomb-friction\".",
    )
}

pub fn of_load_friction(session: &Session, test: &ResidualTest) -> Words {
    let channel = &test.channel;
    let joint = joint_of(session, channel);
    let share = [("share", per_torque(session, joint, joint, ""), "limit = 0.01".into())];
    Words::new(
        format!("The friction of {channel} grows with its torque: by {} of it.", shown(test)),
        format!("Estimate it: {}.", formula(channel, "share * abs(torque) * direction", &share)),
    )
}

pub fn of_trend(test: &ResidualTest) -> Words {
    Words::new(
        format!("The residuals show that friction of {} changes with time, by {} of it.", test.channel, shown(test)),
        "Gears that warm up do so: move the arm until it is warm, and record it then; or leave the first minutes out (from_s in [[poses]]).",
    )
}

/// Friction that is no line over the speed, and how to estimate what it is more or less.
pub fn of_curve(session: &Session, test: &ResidualTest, speed: f64) -> Words {
    let ResidualTest { channel, unit, size, .. } = test;
    let joint = joint_of(session, channel);
    let coordinate = of_coordinate(session, joint);
    let more = if size * sign_of_motion(session, joint) > 0.0 { "more" } else { "less" };
    let (size, by, speed) = (significant(*size, 1), significant(size.abs(), 1), significant(speed, 1));
    let unknowns = [
        ("extra", unit.clone(), format!("nominal = {size}, limit = {by}")),
        ("speed", format!("{coordinate}/s"), format!("nominal = {speed}, limit = {speed}")),
    ];
    Words::new(
        format!(
            "The friction of {channel} is no line over its speed: it is about {by} {unit} {more} where the joint hardly moves, which falls to a third \
             at {speed} {coordinate}/s."
        ),
        format!("Estimate it: {}.", formula(channel, "extra * direction * exp(-abs(velocity) / speed)", &unknowns)),
    )
}

/// Friction that is left at rest, in one sentence; tests of one unit.
pub fn of_direction(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let (channels, [least, most], p) = together(tests)?;
    let size = from_to(least, most, tests);
    let unit = &tests.first()?.unit;
    let by_order = !sides_by_order(session).is_empty();
    let taken = if by_order { ", as the order of the rows tells it" } else { "" };
    let seen = tests.iter().any(|test| test.in_noise >= MATTERS);
    let (consequence, cure) = match tests.iter().any(|test| test.spoils_intervals) {
        true if by_order => (
            WIDENED,
            "Come to each pose from both sides, say from which (direction in [readings]), and estimate it (sensor_models = [{ kind = \"coulomb-friction\" }] in the \
             joint's [[joint]]).",
        ),
        true => (
            WIDENED,
            "Estimate it (sensor_models = [{ kind = \"coulomb-friction\" }] in the joint's [[joint]]), and come to each pose from both sides.",
        ),
        false if !seen => (SMALL, "To halve it, come to each pose from both sides."),
        false if by_order => (
            "It is an unknown of the estimate, and intervals allow for it.",
            "To halve it, come to each pose from both sides, and say from which (direction in [readings]): rows of one pose do not tell it.",
        ),
        false => ("Intervals allow for it.", "To halve it, come to each pose from both sides."),
    };
    Some(format!(
        "The residual of {channels} depends on the direction of approach{taken} (±{size} {unit}): friction. ({}, all tests counted.) {consequence} {cure}",
        chance(p)
    ))
}
