//! What a reading keeps of what its sensor sensed before: hysteresis and creep, as data sheets of load cells state them.

use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use super::lacked::{Found, Lacked};
use crate::judgement::residual_tests::columns::{ALL_JOINTS, Columns};
use crate::judgement::residual_tests::wording::{
    SMALL, WIDENED, chance, formula, from_to, is_joint, of_all_or_each, together,
};
use crate::result::{ResidualTest, ResidualTestKind};

/// What is said of other sensors.
const OTHERS_HAVE: &str = "Other sensors may have the same: their intervals include what their own residuals allow.";
/// No sensor keeps a larger share of what changed, nor of the largest change: what goes with so little of it is something else.
const MOST_KEPT: f64 = 0.2;
/// Fewer readings hardly tell what goes with the pose before from chance.
const FEWEST: usize = 12;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EarlierLoad {
    /// By whether what is sensed rose or fell last, in the unit of the reading.
    Hysteresis,
    /// In share of what it changed by from the pose before.
    Creep,
}

impl EarlierLoad {
    /// Those that are looked for in a channel: of an arm that is read while it moves, a reading that is late shows in slopes over time.
    pub fn of_channel(of: &Columns, channel: usize) -> Vec<EarlierLoad> {
        match of.knows_changes(channel) && of.read(channel) >= FEWEST {
            true => vec![EarlierLoad::Hysteresis, EarlierLoad::Creep],
            false => Vec::new(),
        }
    }
}

impl Lacked for EarlierLoad {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        let changes = of.changes(channel);
        vec![of.reading(channel, |pose| match self {
            EarlierLoad::Hysteresis => changes[pose].rose,
            EarlierLoad::Creep => changes[pose].by,
        })]
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let first = coefficients.first().copied().unwrap_or(0.0);
        match self {
            EarlierLoad::Hysteresis => {
                Found::new(ResidualTestKind::Hysteresis, first, of.session.channel_unit(channel))
            }
            EarlierLoad::Creep => Found::new(ResidualTestKind::Creep, 100.0 * first, "%"),
        }
    }

    /// Sensors of one make creep by about the same share.
    fn is_alike_in_all_joints(&self, _of: &Columns) -> bool {
        *self == EarlierLoad::Creep
    }

    fn may_be(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> bool {
        let largest = || of.changes(channel).iter().map(|change| change.by.abs()).fold(0.0, f64::max);
        let most = match self {
            EarlierLoad::Hysteresis => MOST_KEPT * largest(),
            EarlierLoad::Creep => MOST_KEPT,
        };
        coefficients.iter().all(|coefficient| coefficient.abs() < most)
    }
}

/// Hysteresis, in one sentence; tests of one unit.
pub fn of_hysteresis(session: &Session, tests: &[&ResidualTest]) -> Option<String> {
    let (channels, [least, most], p) = together(tests)?;
    let first = tests.first()?;
    let unknown = [("half_loop", first.unit.clone(), format!("limit = {}", significant(most, 2)))];
    let estimate = match is_joint(session, &first.channel) {
        true => format!(
            "; or let a column of each joint tell whether its torque rose (1) or fell (-1), and estimate it, as for {}: further = {{ rose = \"...\" }} in [readings], and {}",
            first.channel,
            formula(&first.channel, "half_loop * further[rose]", &unknown)
        ),
        false => String::new(),
    };
    Some(format!(
        "Readings depend on whether what is sensed rose or fell from the pose before: {channels} (by ±{} {}). This is hysteresis of the sensors, or friction behind \
         them. ({}, all tests counted.) {} Come to each pose from both sides, so that it cancels{estimate}.",
        from_to(least, most, tests),
        first.unit,
        chance(p),
        consequence(tests)
    ))
}

/// Creep, in one sentence.
pub fn of_creep(tests: &[&ResidualTest]) -> Option<String> {
    let told = of_all_or_each(tests);
    let (channels, [least, most], p) = together(told)?;
    Some(format!(
        "Readings are off in proportion to how far what is sensed changed from the pose before: {channels} (by {} % of the change). The sensors creep. ({}, all tests counted.) {} \
         Let the arm stand longer before each reading, and let poses follow each other in an order in which torques change little.",
        from_to(least, most, told),
        chance(p),
        consequence(tests)
    ))
}

fn consequence(tests: &[&ResidualTest]) -> String {
    let of_all = tests.iter().any(|test| test.channel == ALL_JOINTS);
    match tests.iter().any(|test| test.spoils_intervals) {
        true if of_all => WIDENED.to_owned(),
        true => format!("{WIDENED} {OTHERS_HAVE}"),
        false => SMALL.to_owned(),
    }
}
