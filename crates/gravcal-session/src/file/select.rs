//! `[readings.select]`: which readings of an arm in motion count.

use gravcal_dynamics::JointKind;
use gravcal_recording::{ConditionUnit, MotionLimits, Selection};
use serde::Deserialize;

use super::conditions::{acceleration_units, speed_units, units_of_joints};
use super::context::Context;
use crate::document::{Field, FileError, OneOrMany};

/// `[readings.select]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct SelectTable {
    /// Limits that every joint keeps to, or the row is left out: each joint's motion is felt in all torques.
    ///
    /// Default: none.
    /// Example: `arm = { acceleration_below = { value = 0.5, unit = "rad/s²" } }`
    #[serde(default)]
    arm: LimitsTable,
    /// Limits that the joint itself keeps to, or its torque reading is left out.
    ///
    /// Default: none.
    /// Example: `joint = { speed_above = { value = 1, unit = "deg/s" } }`
    #[serde(default)]
    joint: LimitsTable,
}

/// Limits of motion.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct LimitsTable {
    /// Least speed.
    ///
    /// Default: no limit.
    /// Example: `speed_above = { value = 1, unit = "deg/s" }`
    speed_above: Option<LimitTable>,
    /// Largest speed.
    ///
    /// Default: no limit.
    /// Example: `speed_below = { value = 0.8, unit = "rad/s" }`
    speed_below: Option<LimitTable>,
    /// Largest acceleration.
    ///
    /// Default: no limit.
    /// Example: `acceleration_below = { value = [0.5, 1], unit = "rad/s²" }`
    acceleration_below: Option<LimitTable>,
}

/// One number for all joints or a list with one for each.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct LimitTable {
    /// The limit; one for all joints, or a list.
    ///
    /// Unit: as `unit` says.
    /// Example: `value = 0.5`
    value: OneOrMany<f64>,
    /// Its unit; one for all joints, or a list.
    ///
    /// Unit: none.
    /// Default: required.
    /// Example: `unit = "rad/s²"`
    unit: Option<OneOrMany<String>>,
}

/// What `[readings.select]` comes to.
pub(super) fn resolve(context: &Context<'_>, table: &SelectTable) -> Result<Selection, FileError> {
    let field = Field::new("readings").key("select");
    Ok(Selection {
        arm: limits(context, &field.key("arm"), &table.arm)?,
        joint: limits(context, &field.key("joint"), &table.joint)?,
    })
}

fn limits(context: &Context<'_>, field: &Field, table: &LimitsTable) -> Result<MotionLimits, FileError> {
    Ok(MotionLimits {
        speed_above: limit(context, &field.key("speed_above"), table.speed_above.as_ref(), speed_units)?,
        speed_below: limit(context, &field.key("speed_below"), table.speed_below.as_ref(), speed_units)?,
        acceleration_below: limit(
            context,
            &field.key("acceleration_below"),
            table.acceleration_below.as_ref(),
            acceleration_units,
        )?,
    })
}

/// The limit of each joint, SI; empty where there is none.
fn limit(
    context: &Context<'_>,
    field: &Field,
    table: Option<&LimitTable>,
    units: impl Fn(JointKind) -> &'static [ConditionUnit],
) -> Result<Vec<f64>, FileError> {
    let Some(table) = table else { return Ok(Vec::new()) };
    let values = context.document.for_each(&field.key("value"), &table.value, &context.joint_names)?;
    let units = units_of_joints(context, field, table.unit.as_ref(), units)?;
    if let Some(value) = values.iter().find(|value| !(value.is_finite() && **value > 0.0)) {
        let message = format!("a limit of motion must be finite and greater than 0, found {value}");
        return Err(context.document.error(&field.key("value"), message));
    }
    Ok(values.iter().zip(units).map(|(value, unit)| unit.to_inside(*value)).collect())
}

#[cfg(test)]
mod tests {
    use gravcal_recording::Reading;
    use gravcal_robot_model::session::Session;

    use crate::file::tests::{assert_refused, changed};

    const TORQUE: &str = "torque = { columns = [\"y1\", \"y2\"], unit = \"count\", std = 0.8 }";

    fn with(rest: &str) -> String {
        format!("{TORQUE}\n{rest}")
    }

    fn assert_wrong(rest: &str, expected: &str) {
        assert_refused(TORQUE, &with(rest), expected);
    }

    #[test]
    fn a_limit_names_its_unit_and_stands_for_one_joint_or_all() {
        let wrong = |limit: &str| format!("select = {{ arm = {{ speed_below = {limit} }} }}");
        assert_wrong(
            &wrong("{ value = 1 }"),
            "11: readings.select.arm.speed_below.unit: the unit is missing: expected one of",
        );
        assert_wrong(
            &wrong("{ value = 1, unit = 'rad' }"),
            "11: readings.select.arm.speed_below.unit: the unit `rad` does not fit: expected one of rad/s, deg/s",
        );
        assert_wrong(
            &wrong("{ value = [1], unit = 'rad/s' }"),
            "11: readings.select.arm.speed_below.value: expected 2 entries, one for each joint (shoulder, elbow), found 1",
        );
        assert_wrong(
            &wrong("{ value = 0, unit = 'rad/s' }"),
            "11: readings.select.arm.speed_below.value: a limit of motion must be finite and greater than 0, found 0",
        );
    }

    #[test]
    fn a_limit_without_what_it_limits_names_the_cure() {
        assert_wrong(
            "select = { joint = { speed_above = { value = 1, unit = 'deg/s' } } }",
            "11: readings.select: speeds are limited, and nothing tells the velocity of each joint: name its columns, or take",
        );
        assert_wrong(
            "select = { arm = { acceleration_below = { value = 1, unit = 'deg/s²' } } }",
            "11: readings.select: accelerations are limited, and nothing tells the acceleration of each joint",
        );
    }

    #[test]
    fn a_slope_needs_time_and_what_it_is_the_slope_of() {
        let time = "time = { column = 'q1', unit = 's' }";
        assert_wrong(
            "velocity = { slope_over_s = 0.1 }",
            "8: readings.time: a slope is taken over time, and no column tells the time: name it",
        );
        assert_wrong(
            &format!("{time}\nvelocity = {{ slope_over_s = 0 }}"),
            "12: readings.velocity: the time over which a slope is taken must be finite and greater than 0, found 0 s",
        );
        assert_wrong(
            &format!("{time}\nacceleration = {{ slope_over_s = 1 }}"),
            "8: readings.velocity: an acceleration is the slope of a velocity, and nothing tells the velocities",
        );
        assert_wrong(
            &format!("{time}\nvelocity = {{ slope_over_s = 0.1, columns = 'q1', unit = 'rad/s' }}"),
            "12: readings.velocity: expected columns with their unit, or slope_over_s",
        );
        assert_wrong(
            &format!("{time}\nvelocity = {{ slope_over_s = 0.1, unit = 'rad/s' }}"),
            "12: readings.velocity.unit: a slope over time has SI units: delete this",
        );
    }

    fn readings(session: &Session) -> Vec<Vec<Option<f64>>> {
        let value = |reading: &Option<Reading>| reading.map(|reading| reading.value);
        session.poses.iter().map(|pose| pose.torque.iter().map(value).collect()).collect()
    }

    #[test]
    fn readings_that_are_left_out_are_counted() {
        let all = changed(TORQUE, TORQUE);
        let velocity = "velocity = { columns = ['q1', 'q2'], unit = 'deg/s' }";
        let joint = "select = { joint = { speed_below = { value = [45, 1000], unit = 'deg/s' } } }";
        let session = changed(TORQUE, &with(&format!("{velocity}\n{joint}")));
        assert_eq!((&session.in_motion[..], &all.in_motion[..]), (&[1, 0][..], &[0, 0][..]));
        let count = |session: &Session| readings(session).iter().flatten().flatten().count();
        assert_eq!(count(&session) + 1, count(&all));
        let note = session.selection_note().unwrap();
        assert!(note.ends_with("(readings.select): shoulder 3 of 4, elbow 3 of 3."), "{note}");
        assert_eq!(all.selection_note(), None);
    }
}
