//! `[ask]`: changes to what is asked for.

use gravcal_robot_model::parameter::{Parameter, SensorParameter};
use gravcal_robot_model::session::{Ask, JointPriors};
use serde::Deserialize;

use super::context::Context;
use crate::document::{Field, FileError};

/// `[ask]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct AskTable {
    /// Parameters that count besides.
    ///
    /// Default: `[]`.
    /// Example: `add = ["shoulder.position_offset"]`
    #[serde(default)]
    add: Vec<String>,
    /// Parameters that do not count.
    ///
    /// Default: `[]`.
    /// Example: `drop = ["shoulder.torque_gain"]`
    #[serde(default)]
    drop: Vec<String>,
}

/// What `[ask]` comes to.
pub(super) fn resolve(
    context: &Context<'_>,
    joints: &[JointPriors],
    further: &[Parameter],
    table: &AskTable,
) -> Result<Ask, FileError> {
    let [add, drop] = ["add", "drop"].map(|key| Field::new("ask").key(key));
    table.add.iter().enumerate().try_for_each(|(i, name)| check_added(context, joints, further, &add.at(i), name))?;
    for (i, name) in table.drop.iter().enumerate() {
        parameter(context, further, &drop.at(i), name)?;
        if table.add.contains(name) {
            return Err(context.document.error(&drop.at(i), format!("`{name}` is added as well: keep one")));
        }
    }
    Ok(Ask { add: table.add.clone(), drop: table.drop.clone() })
}

fn check_added(
    context: &Context<'_>,
    joints: &[JointPriors],
    further: &[Parameter],
    field: &Field,
    name: &str,
) -> Result<(), FileError> {
    match parameter(context, further, field, name)? {
        Some((joint, SensorParameter::TorqueGain | SensorParameter::TorqueBias))
            if joints[joint].torque_unit.is_none() =>
        {
            let joint = context.joint_names[joint];
            Err(context.document.error(field, format!("joint `{joint}` has no column in readings.torque: name one")))
        }
        _ => Ok(()),
    }
}

/// The joint's sensor parameter of that name; `None` for gravity and the further parameters.
fn parameter(
    context: &Context<'_>,
    further: &[Parameter],
    field: &Field,
    name: &str,
) -> Result<Option<(usize, SensorParameter)>, FileError> {
    if name == "gravity" || further.iter().any(|parameter| parameter.name() == name) {
        return Ok(None);
    }
    // From the right: joints of a URDF may have dots in their names.
    let Some((joint, quantity)) = name.rsplit_once('.') else {
        let message =
            format!("`{name}` is no parameter: expected `gravity` or <joint>.<quantity>, such as joint1.torque_gain");
        return Err(context.document.error(field, message));
    };
    let joint = context.document.lookup(field, "joint", joint, &context.joint_names)?;
    let known = SensorParameter::ALL.map(SensorParameter::as_str);
    let quantity = context.document.lookup(field, "quantity", quantity, &known)?;
    Ok(Some((joint, SensorParameter::ALL[quantity])))
}
