//! `[readings.sweeps]`: the tables are recordings of an arm in motion, and poses are the angles that a joint passes slowly in both
//! directions while the others stand.

use gravcal_recording::{PoseMapping, SweepRule, WIDEST_BIN};
use gravcal_robot_model::session::JointPriors;
use gravcal_robot_model::session::travel::{BIN, STEADY, travels};
use serde::Deserialize;

use super::context::Context;
use super::still::refuse_said_twice;
use crate::document::{Field, FileError};

/// `[readings.sweeps]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct SweepsTable {
    /// Width of the bins of the angle of the joint that sweeps; each bin is one pose. If it is not stated, it is 1, or 2 or 4 where the speed
    /// and the rate of the recording leave too few samples in narrower bins.
    ///
    /// Default: 1, 2 or 4.
    /// Example: `bin_deg = 2`
    bin_deg: Option<f64>,
    /// Largest acceleration of what counts as slow. The square of the speed, in rad/s, obeys the same number.
    ///
    /// Default: 0.05.
    /// Example: `acceleration_below_rad_per_s2 = 0.05`
    acceleration_below_rad_per_s2: Option<f64>,
}

/// What it comes to.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &SweepsTable,
    mapping: &PoseMapping,
    joints: &[JointPriors],
) -> Result<SweepRule, FileError> {
    let field = Field::new("readings").key("sweeps");
    refuse_said_twice(context, &field, mapping)?;
    let positive = |key: &str, written: Option<f64>, what: &str, unit: &str| {
        written.map(|number| context.document.positive(&field.key(key), number, what, unit)).transpose()
    };
    let said = positive("bin_deg", table.bin_deg, "a width", "deg")?.map(f64::to_radians);
    let acceleration = table.acceleration_below_rad_per_s2;
    let acceleration = positive("acceleration_below_rad_per_s2", acceleration, "an acceleration", "rad/s²")?;
    Ok(SweepRule {
        bin: said.unwrap_or(BIN),
        widest: said.unwrap_or(WIDEST_BIN),
        acceleration: acceleration.unwrap_or(STEADY),
        travel: travels(&context.robot.chain, joints),
        ..SweepRule::default()
    })
}
