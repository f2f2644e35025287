//! Joints that give way under their torque, and what pulls at them like a spring.

use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::score::MATTERS;
use crate::judgement::residual_tests::wording::{
    SMALL, WIDENED, chance, formula, from_to, joint_of, of_all_or_each, shown_amount, together,
};
use crate::result::{ResidualTest, ResidualTestKind};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elastic {
    /// Of a joint's coordinate, under its own torque.
    Compliance,
    /// Of a joint's own position reading and its square, in the unit of the torque reading at the ends of what it moves.
    Spring,
}

impl Lacked for Elastic {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            Elastic::Compliance => vec![of.coordinate(channel, |pose| of.torques[pose][channel])],
            Elastic::Spring => spring(of, channel),
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let [first, second] = [0, 1].map(|place| coefficients.get(place).copied().unwrap_or(0.0));
        match self {
            Elastic::Compliance => Found::new(ResidualTestKind::Compliance, first, "rad/(N·m)"),
            Elastic::Spring => {
                let (ahead, behind) = (first + second, second - first);
                let size = if ahead.abs() > behind.abs() { ahead } else { behind };
                Found::new(ResidualTestKind::Spring, size, of.session.channel_unit(channel))
            }
        }
    }

    /// What bends most passes for a position gain, and a joint's own test has little power: it needs that of all most.
    fn is_alike_in_all_joints(&self, _of: &Columns) -> bool {
        *self == Elastic::Compliance
    }
}

/// A torque that goes with a joint's own position reading, and with its square: from the middle to the ends of what it moves.
fn spring(of: &Columns, joint: usize) -> Vec<Vec<f64>> {
    let position = |pose: usize| of.session.poses[pose].position[joint];
    let (low, high) = of
        .poses(joint)
        .map(position)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let half = 0.5 * (high - low);
    let from_middle = |pose: usize| (position(pose) - low) / half - 1.0;
    let power = |power: i32| of.reading(joint, |pose| from_middle(pose).powi(power));
    if half > 0.0 { [1, 2].map(power).into() } else { Vec::new() }
}

pub fn of_spring(session: &Session, test: &ResidualTest) -> Words {
    let channel = &test.channel;
    let joint = joint_of(session, channel);
    let limit = || format!("limit = {}", significant(test.size.abs(), 1));
    let by = |power: &str| format!("{}/{}{power}", session.channel_unit(joint), session.joints[joint].position_unit);
    let unknowns = [("stiffness", by(""), limit()), ("bend", by("²"), limit())];
    Words::new(
        format!(
            "The residual of {channel} goes with its own position as if a spring pulled at the joint: by up to {}.",
            shown_amount(test)
        ),
        format!(
            "A cable, a hose or a balancer that is bent or stretched as the joint moves does so: take it off, or estimate it: {}.",
            formula(channel, "stiffness * position + bend * position^2", &unknowns)
        ),
    )
}

/// Joints that bend, in one sentence; nothing where none is named.
pub fn of_compliance(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let tests = of_all_or_each(tests);
    let (channels, [least, most], p) = together(tests)?;
    let size = from_to(least, most, tests);
    let spoilt = tests.iter().any(|test| test.spoils_intervals);
    let in_fit = !spoilt && !session.deflection.stiff && tests.iter().any(|test| test.in_noise >= MATTERS);
    let consequence = match in_fit {
        _ if spoilt => WIDENED,
        true => "It is an unknown of the estimate, and intervals allow for it.",
        false => SMALL,
    };
    // What gives way moves instruments, which only deflections of unknown cause can say.
    let cure = match session.instruments.is_empty() {
        true if in_fit => "Heavier loads tell it from position gains.".into(),
        true if session.deflection.stiff => {
            "Position sensors that sit behind the gears would see it: leave out [deflection] compliance_std_rad_per_newton_metre = 0 if they do not.".into()
        }
        true if session.has_windows() => {
            "Only standstills tell how joints give way: record them (readings.still), and calibrate them by themselves with [deflection].".into()
        }
        true => format!("Estimate it: [deflection] compliance_std_rad_per_newton_metre = {most:.0e}."),
        false => "Allow for it: [deflection] hold_std_deg, by how much a standing joint bends.".into(),
    };
    Some(format!(
        "The residuals show that {channels} give way under their torque, by {size} rad/(N·m), which position sensors do not see. ({}, all \
         tests counted.) {consequence} {cure}",
        chance(p)
    ))
}
