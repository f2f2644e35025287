//! What a recorder did: torques that come late or passed a filter, a clock that runs fast.

use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::Columns;
use crate::judgement::residual_tests::delayed::{cut_off, half_square};
use crate::judgement::residual_tests::wording::{SMALL, WIDENED, chance, of_all_or_each, shown_amount, together};
use crate::result::{ResidualTest, ResidualTestKind};

/// Of an arm in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Recorder {
    TorqueLag,
    TorqueFilter,
    /// Of all channels: the rate of the clock, in share of it.
    ClockRate,
}

impl Recorder {
    /// Those that are looked for in a joint.
    pub fn of_joint(of: &Columns) -> Vec<Recorder> {
        if of.in_motion() { vec![Recorder::TorqueLag, Recorder::TorqueFilter] } else { Vec::new() }
    }
}

impl Lacked for Recorder {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            Recorder::TorqueLag => vec![of.of_slopes(channel, |[slope, _]| -slope)],
            Recorder::TorqueFilter => vec![of.of_slopes(channel, |[_, bend]| bend)],
            Recorder::ClockRate => of.fast_clock.clone(),
        }
    }

    fn found(&self, _of: &Columns, _channel: usize, coefficients: &[f64]) -> Found {
        let first = coefficients.first().copied().unwrap_or(0.0);
        match self {
            Recorder::TorqueLag => Found::new(ResidualTestKind::TorqueLag, first, "s"),
            Recorder::TorqueFilter => Found::new(ResidualTestKind::TorqueFilter, first, "s²"),
            Recorder::ClockRate => Found::new(ResidualTestKind::ClockRate, 100.0 * first, "%"),
        }
    }

    /// A recorder does the same to all torques.
    fn is_alike_in_all_joints(&self, _of: &Columns) -> bool {
        *self != Recorder::ClockRate
    }
}

pub fn of_clock(test: &ResidualTest) -> Words {
    Words::new(
        format!(
            "The residuals of all joints look as if the clock ran {}, by {}: torques of inertia are off by twice that.",
            if test.size > 0.0 { "fast" } else { "slow" },
            shown_amount(test)
        ),
        "Times must be seconds of the controller that sampled the readings, not numbers of rows at a rate that is written down.",
    )
}

/// What a recorder did to torques, in one sentence: tests of one kind.
pub fn of_recorder(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let tests = of_all_or_each(tests);
    let (channels, _, p) = together(tests)?;
    let mut sizes: Vec<f64> = tests.iter().map(|test| test.size).collect();
    sizes.sort_by(f64::total_cmp);
    let (least, most, middle) = (*sizes.first()?, *sizes.last()?, sizes[sizes.len() / 2]);
    let range = |of: &dyn Fn(f64) -> f64| match (significant(of(least), 2), significant(of(most), 2)) {
        (low, high) if low == high => low,
        (low, high) => format!("{low} to {high}"),
    };
    let spoilt = tests.iter().any(|test| test.spoils_intervals);
    let allowed = session.searched.iter().find_map(|searched| searched.windows.as_ref());
    let (what, cure) = match tests.first()?.kind {
        ResidualTestKind::TorqueLag => {
            let lag = significant(allowed.map_or(0.0, |windows| windows.torque_lag) + middle, 2);
            (
                match middle < 0.0 {
                    false => {
                        format!("The torques of {channels} come {} s later than the positions.", range(&|lag| lag))
                    }
                    true => {
                        format!("The torques of {channels} come {} s earlier than the positions.", range(&|lag| -lag))
                    }
                },
                format!(
                    "Look at how the recorder stamps them. If all joints show about as much, say torque_lag_s = {lag} in readings.motion; \
                     if only some do, it is friction that changes its sign late, or a gear that gives way."
                ),
            )
        }
        _ => {
            let allowed = allowed.and_then(|windows| windows.recorded_filter).map(half_square);
            let what = match (middle > 0.0, allowed) {
                (true, None) => format!("The torques of {channels} are smoother than their motion: as if by a filter"),
                (true, Some(_)) => format!("The torques of {channels} are smoother still: as if by another filter"),
                (false, _) => format!("The motion of {channels} is smoother than the torques: as if by a filter"),
            };
            (format!("{what} of {} Hz.", range(&cut_off)), of_filter(allowed.unwrap_or(0.0) + middle))
        }
    };
    let said = format!("{what} ({}, all tests counted.)", chance(p));
    Some(match spoilt {
        true => format!("{said} {WIDENED} {cure}"),
        false => format!("{said} {SMALL}"),
    })
}

/// What to do about a filter of which so much is seen in all, s².
fn of_filter(in_all: f64) -> String {
    if in_all > 0.0 {
        return format!(
            "If the recorder filtered torques and not positions, say recorded_filter_hz = {} in readings.motion, and look at what is left.",
            significant(cut_off(in_all), 2)
        );
    }
    "Positions were filtered before they were recorded, or are so noisy or coarse that smoothing them takes motion away, or their clock is wrong: \
     record both raw, or take longer windows (window_s in readings.motion)."
        .into()
}
