//! `[deflection]`: how far joints may be from where their position sensors say.

use gravcal_dynamics::JointKind;
use gravcal_robot_model::parameter::{Parameter, SensorParameter};
use gravcal_robot_model::session::compliance::compliance_parameters;
use gravcal_robot_model::session::{Deflection, Session};
use serde::Deserialize;

use super::context::Context;
use super::readings::{self, ReadingsTable};
use crate::document::{Document, Field, FileError, OneOrMany};

/// `[deflection]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct DeflectionTable {
    /// Of a joint that stands while another sweeps: one unknown for each in a sweep, known beforehand to this.
    ///
    /// Default: no deflection but what a coarse position sensor's rounding leaves.
    /// Example: `hold_std_deg = 0.5`
    hold_std_deg: Option<f64>,
    /// Of a joint that stands: one unknown for each in a pose.
    ///
    /// Default: no deflection.
    /// Example: `pose_std_deg = 0.05`
    pose_std_deg: Option<f64>,
    /// In proportion to the torque, one unknown for each joint; 0 where position sensors sit behind the gears and see what bends.
    ///
    /// Default: stiff; an unknown of arms in motion, of slow sweeps in recordings, of standstills whose errors beyond the noise may hide it, and of tables
    /// whose residuals show friction or compliance.
    /// Example: `compliance_std_rad_per_newton_metre = 1e-4`
    compliance_std_rad_per_newton_metre: Option<OneOrMany<f64>>,
}

/// Position sensors with steps of less than this, rad, are taken as exact: that of 18 bits a turn. It changes the torque of an arm by a 40,000th
/// of what its gravity makes.
const FINE: f64 = 2.5e-5;

fn field(key: &str) -> Field {
    Field::new("deflection").key(key)
}

/// What `[deflection]` and the noise of the position readings come to.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &DeflectionTable,
    readings: &ReadingsTable,
    further: &mut Vec<Parameter>,
) -> Result<Deflection, FileError> {
    let angle = |key: &str, degrees: Option<f64>| {
        let what = "the standard deviation of a deflection";
        let angle = degrees.map(|degrees| context.document.positive(&field(key), degrees, what, "degrees"));
        Ok::<_, FileError>(angle.transpose()?.map(f64::to_radians))
    };
    let std = compliance_std(context, table)?;
    let stiff = std.as_ref().is_some_and(|std| std.iter().all(|std| *std == 0.0));
    let compliance = std.filter(|_| !stiff).map(|std| {
        let first = further.len();
        further.extend(compliance_parameters(context.robot.chain.joints(), &std));
        first
    });
    Ok(Deflection {
        compliance,
        stiff,
        hold_std: angle("hold_std_deg", table.hold_std_deg)?,
        pose_std: angle("pose_std_deg", table.pose_std_deg)?,
        rounding_std: Vec::new(),
        reading_std: readings::position_std(context, readings)?,
    })
}

/// What rounding leaves of the angle of each joint that stands in slow sweeps, rad; nothing of joints that slide, whose steps are too small to
/// matter, or whose noise is stated.
pub(super) fn rounding_std(session: &Session) -> Vec<f64> {
    let turns = |joint: usize| session.robot.chain.joints()[joint].kind == JointKind::Revolute;
    let stated = |joint: usize| session.deflection.reading_std.get(joint).is_some_and(|std| *std > 0.0);
    let of_joint = |joint: usize| {
        let sweeps = session.fitted_recordings().filter_map(|searched| searched.sweeps.as_ref());
        let gain = session.joints[joint].of(SensorParameter::PositionGain).nominal.abs();
        let turn = gain * sweeps.map(|sweeps| sweeps.position_steps[joint]).fold(0.0, f64::max);
        if turn > FINE && turns(joint) && !stated(joint) { turn / f64::sqrt(12.0) } else { 0.0 }
    };
    (0..session.joints.len()).map(of_joint).collect()
}

fn compliance_std(context: &Context<'_>, table: &DeflectionTable) -> Result<Option<Vec<f64>>, FileError> {
    let Some(written) = &table.compliance_std_rad_per_newton_metre else { return Ok(None) };
    let field = field("compliance_std_rad_per_newton_metre");
    let std = context.document.for_each(&field, written, &context.joint_names)?;
    if let Some(wrong) = std.iter().find(|std| !(0.0..f64::INFINITY).contains(*std)) {
        let message = format!("{wrong} is no standard deviation: expected 0 (a stiff joint) or more, in rad/(N·m)");
        return Err(context.document.error(&field, message));
    }
    Ok(Some(std))
}

/// Whether what gives way is known to everything that is read.
pub(super) fn check_instruments(document: &Document, session: &Session) -> Result<(), FileError> {
    if session.compliances().is_empty() || session.instruments.is_empty() {
        return Ok(());
    }
    let message = "joints that give way under their torque move the instruments on them, which is not modelled: leave this \
                   out, and state hold_std_deg instead";
    Err(document.error(&field("compliance_std_rad_per_newton_metre"), message))
}
