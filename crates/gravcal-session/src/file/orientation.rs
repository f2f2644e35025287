//! `[readings.orientation]`: how the body that carries the instruments stood in each pose, where no joints tell it.
//!
//! Such a session names no robot. What it calibrates hangs on one body, `body`, which somebody turned:
//!
//! ```text
//!     y = K u(v) + b,     v = R_mᵀ Rᵀ g
//! ```
//!
//! with the rotation `R` of the body (`v_base = R v_body`) in the columns, and `R_m` that of the instrument's mounting on it,
//! which is none unless `mounting` says so: see [`gravcal_robot_model::residuals::AuxiliarySensorReading`].

use gravcal_dynamics::Chain;
use gravcal_recording::{OrientationColumns, OrientationForm};
use gravcal_robot_model::robot::Robot;
use serde::Deserialize;

use super::readings::ReadingsTable;
use crate::document::{Document, Field, FileError};
use crate::robot_file::RobotSource;

/// Names of the base and of the body.
const BASE: &str = "base";
const BODY: &str = "body";

// What must be said is read as optional, so that the error can say what fits.
/// A quaternion needs both `order` and `rotation`, a matrix `rotation`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct OrientationTable {
    /// Four columns of a quaternion, or nine of a rotation matrix, row by row.
    ///
    /// Example: `columns = ["qx", "qy", "qz", "qw"]`
    columns: Vec<String>,
    /// Order of a quaternion. None for a matrix.
    ///
    /// Example: `order = "xyzw"`
    order: Option<Order>,
    /// What it turns into what.
    ///
    /// Example: `rotation = "base-from-body"`
    rotation: Option<Rotation>,
}

/// Which of four columns is which.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Order {
    Xyzw,
    Wxyz,
}

/// Which way the rotation goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Rotation {
    BaseFromBody,
    BodyFromBase,
}

/// The body in place of a robot.
pub(super) fn free_body() -> Robot {
    Robot { name: "body without joints".to_owned(), chain: Chain::free_body(BASE, BODY), sensors: Vec::new() }
}

/// Either a robot's joints or columns say how what reads gravity stood.
pub(super) fn check_robot(
    document: &Document,
    robot: Option<&RobotSource>,
    readings: &ReadingsTable,
) -> Result<(), FileError> {
    let field = |key: &str| Field::new("readings").key(key);
    match (robot, &readings.orientation) {
        (Some(_), None) if readings.position.is_none() => {
            let message = "the position readings are missing: name their columns, readings.position = { columns = \
                           [...], unit = \"...\" }";
            Err(document.error(&field("position"), message))
        }
        (Some(_), None) => Ok(()),
        (Some(_), Some(_)) => {
            let message = "the robot's joint angles already tell how its links stand: delete this, or the robot and its \
                           joints' readings";
            Err(document.error(&field("orientation"), message))
        }
        (None, None) => {
            let message = "which robot? name its file; or, for instruments that are turned without one, how they stood: \
                           readings.orientation = { columns = [...], order = \"xyzw\", rotation = \"base-from-body\" }";
            Err(document.error(&Field::new("robot"), message))
        }
        (None, Some(_)) => match readings.of_joints().first() {
            Some(key) => {
                let message = "there are no joints, as no robot is named: delete this, or name the robot in place of \
                               readings.orientation";
                Err(document.error(&field(key), message))
            }
            None => Ok(()),
        },
    }
}

/// What it comes to.
pub(super) fn resolve(document: &Document, table: &OrientationTable) -> Result<OrientationColumns, FileError> {
    let field = |key: &str| Field::new("readings").key("orientation").key(key);
    let form = match (table.columns.len(), table.order) {
        (4, Some(Order::Xyzw)) => OrientationForm::QuaternionXyzw,
        (4, Some(Order::Wxyz)) => OrientationForm::QuaternionWxyz,
        (4, None) => {
            let message =
                "does the real part of the quaternion stand first or last? write order = \"wxyz\" or \"xyzw\"";
            return Err(document.error(&field("order"), message));
        }
        (9, None) => OrientationForm::Matrix,
        (9, Some(_)) => {
            let message = "nine columns are a rotation matrix, row by row, which has no other order: delete this";
            return Err(document.error(&field("order"), message));
        }
        (found, _) => {
            let message = format!(
                "expected the four columns of a quaternion, or the nine of a rotation matrix row by row, found {found}"
            );
            return Err(document.error(&field("columns"), message));
        }
    };
    let Some(rotation) = table.rotation else {
        let message = "which way does it turn? write rotation = \"base-from-body\" where it turns vectors in the body's \
                       frame into the base's (v_base = R v_body), or \"body-from-base\"";
        return Err(document.error(&field("rotation"), message));
    };
    Ok(OrientationColumns { columns: table.columns.clone(), form, body_from_base: rotation == Rotation::BodyFromBase })
}
