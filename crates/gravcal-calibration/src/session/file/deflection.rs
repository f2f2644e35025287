//! `[deflection]`: how far joints may be from where their position sensors say.

use gravcal_estimation::Loss;
use serde::Deserialize;

use super::context::Context;
use super::readings::{self, ReadingsTable};
use crate::document::{Document, Field, FileError, OneOrMany};
use crate::parameter::Parameter;
use crate::session::compliance::compliance_parameters;
use crate::session::{Deflection, Session, UncertaintyChoice};
use crate::sweeps::sweeping;

/// `[deflection]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct DeflectionTable {
    hold_std_deg: Option<f64>,
    pose_std_deg: Option<f64>,
    compliance_std_rad_per_newton_metre: Option<OneOrMany<f64>>,
}

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
    let compliance = compliance_std(context, table)?.map(|std| {
        let first = further.len();
        further.extend(compliance_parameters(context.robot.chain.joints(), &std));
        first
    });
    Ok(Deflection {
        compliance,
        hold_std: angle("hold_std_deg", table.hold_std_deg)?,
        pose_std: angle("pose_std_deg", table.pose_std_deg)?,
        reading_std: readings::position_std(context, readings)?,
    })
}

fn compliance_std(context: &Context<'_>, table: &DeflectionTable) -> Result<Option<Vec<f64>>, FileError> {
    let Some(written) = &table.compliance_std_rad_per_newton_metre else { return Ok(None) };
    let field = field("compliance_std_rad_per_newton_metre");
    let std = context.document.for_each(&field, written, &context.joint_names)?;
    if let Some(wrong) = std.iter().find(|std| !(0.0..f64::INFINITY).contains(*std)) {
        let message = format!("{wrong} is no standard deviation: expected 0 (a stiff joint) or more, in rad/(N·m)");
        return Err(context.document.error(&field, message));
    }
    if std.iter().all(|std| *std == 0.0) {
        return Err(context.document.error(&field, "no joint gives way: expected a positive number of rad/(N·m)"));
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

/// What gives poses unknowns of their own, where something does.
fn unknowns_of_single_poses(session: &Session) -> Option<Field> {
    let Deflection { hold_std, pose_std, reading_std, compliance: _ } = &session.deflection;
    if reading_std.iter().any(|std| *std > 0.0) {
        Some(Field::new("readings").key("position").key("std"))
    } else if pose_std.is_some() {
        Some(field("pose_std_deg"))
    } else {
        // Poses of no sweep are holds of their own.
        (hold_std.is_some() && sweeping(session).iter().any(Option::is_none)).then(|| field("hold_std_deg"))
    }
}

/// Whether everything else that the session asks for goes with unknowns of single poses.
pub(super) fn check_single_poses(document: &Document, session: &Session) -> Result<(), FileError> {
    let Some(source) = unknowns_of_single_poses(session) else { return Ok(()) };
    let refuse = |why: &str| Err(document.error(&source, why));
    if session.noise_estimated().iter().any(|estimated| *estimated) {
        return refuse(
            "errors of each pose's positions cannot be told from noise of unknown size in its torques: state the torque \
             readings' std, or leave this out",
        );
    }
    if session.loss != Loss::None {
        return refuse("errors of each pose's positions would hide its outliers: leave [loss] out, or this");
    }
    if !matches!(session.uncertainty, UncertaintyChoice::Noise | UncertaintyChoice::Jackknife { .. }) {
        return refuse(
            "standard deviations from the scatter of blocks are not known where each pose has unknowns of its own: write \
             [uncertainty] kind = \"jackknife\" or \"noise\", or leave this out",
        );
    }
    Ok(())
}
