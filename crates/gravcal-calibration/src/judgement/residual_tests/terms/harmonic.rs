//! What goes with a joint's own angle, some times a turn.

use std::ops::RangeInclusive;

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::score::dot;
use crate::judgement::residual_tests::wording::{shown, shown_size};
use crate::result::{ResidualTest, ResidualTestKind};

/// Harmonics that are looked for.
const ORDERS: RangeInclusive<u32> = 1..=4;

/// Two coefficients: of sine and cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Harmonic {
    /// Of the torque reading.
    Torque(u32),
    /// Of the coordinate.
    Position(u32),
}

impl Harmonic {
    /// Those of a joint's torque reading.
    pub fn of_torque(of: &Columns, joint: usize) -> Vec<Harmonic> {
        if of.slides(joint) { Vec::new() } else { ORDERS.map(Harmonic::Torque).collect() }
    }

    /// Those of a joint's coordinate.
    pub fn of_position() -> impl Iterator<Item = Harmonic> {
        ORDERS.map(Harmonic::Position)
    }
}

impl Lacked for Harmonic {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        let both = [f64::sin, f64::cos];
        let angle = |order: u32, pose: usize| f64::from(order) * of.angle(channel, pose);
        match *self {
            Harmonic::Torque(order) => {
                both.map(|function| of.reading(channel, |pose| function(angle(order, pose)))).into()
            }
            Harmonic::Position(order) => {
                both.map(|function| of.coordinate(channel, |pose| function(angle(order, pose)))).into()
            }
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let amplitude = dot(coefficients, coefficients).sqrt();
        match *self {
            Harmonic::Torque(order) => {
                Found::new(ResidualTestKind::TorqueHarmonic { order }, amplitude, of.session.channel_unit(channel))
            }
            Harmonic::Position(order) => Found::new(ResidualTestKind::PositionHarmonic { order }, amplitude, "rad"),
        }
    }
}

pub fn of_torque(test: &ResidualTest, order: u32) -> Words {
    Words::new(
        format!("The residual of {} goes with its own angle, {}, by {}.", test.channel, periods(order), shown(test)),
        "A cable, a gear or a sensor that is loaded from the side does so: look at what pulls at the joint; spread the poses over its whole range.",
    )
}

pub fn of_position(test: &ResidualTest, order: u32) -> Words {
    Words::new(
        format!(
            "The residuals show a coordinate of {} that runs unevenly, {}, by {} rad.",
            test.channel,
            periods(order),
            shown_size(test)
        ),
        format!(
            "Estimate it: sensor_models = [{{ kind = \"position-harmonics\", orders = [{order}] }}] in its [[joint]]."
        ),
    )
}

fn periods(order: u32) -> String {
    match order {
        1 => "once a turn".into(),
        2 => "twice a turn".into(),
        _ => format!("{order} times a turn"),
    }
}
