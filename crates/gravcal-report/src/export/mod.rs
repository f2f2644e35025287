//! A calibration in the forms that others take: parameters of a driver, code, a robot description, tables.
//!
//! | format | what it holds |
//! |---|---|
//! | `ros2` | parameters of a ROS 2 node (YAML): each joint's gain and bias, forward and inverse |
//! | `urdf` | the session's URDF with joints' origins moved by their position offsets, a root that hangs as gravity says, and identified inertias |
//! | `mujoco` | the arm as a MuJoCo model (MJCF) with identified inertias and gravity |
//! | `payload` | loads of unknown mass and the mount's gravity, as the drivers of some makers take them |
//! | `c`, `python` | functions from a reading to what it truly says |
//! | `csv` | every parameter with its interval, for programs |
//! | `markdown`, `latex` | every parameter with its standard deviation, rounded, for people |
//!
//! Each states its convention in the file. All numbers but those of the tables for people have all their digits.
//!
//! **What is not determined** has no value: `csv`, `markdown` and `latex` say so, the others refuse it by name, or take its nominal
//! value and mark it where that is asked for. **Sensors beyond gain and bias** stand in `csv`, `markdown` and `latex` with the equation of
//! each parameter; the others know gain and bias only, and refuse such a joint or instrument by name. Mass and moment of a tool and the
//! mounting of an accelerometer are in these three alone, which the others say, and no instrument is in a URDF.

mod c_header;
mod corrections;
mod csv;
mod instruments;
mod latex;
mod latex_text;
mod markdown;
mod mujoco;
mod numbers;
mod payload;
mod python;
mod ros2;
mod rows;
#[cfg(test)]
mod tests;
mod urdf;

use std::fmt;
use std::str::FromStr;

use gravcal_dynamics::{Chain, UrdfError};
use gravcal_recording::EarlierEstimate;
use thiserror::Error;

use corrections::Corrections;
use numbers::one_line;
pub use urdf::RobotDescription;

/// The formats that a user can choose by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Parameters of a ROS 2 node.
    Ros2,
    /// The robot's description, corrected.
    Urdf,
    /// The arm for MuJoCo.
    Mujoco,
    /// Loads of unknown mass and the mount's gravity, as drivers take them.
    Payload,
    /// Every parameter, for programs.
    Csv,
    /// A header with functions.
    C,
    /// A module with functions.
    Python,
    /// A table.
    Markdown,
    /// A table.
    Latex,
}

impl ExportFormat {
    /// Every format.
    pub const ALL: [ExportFormat; 9] = [
        ExportFormat::Ros2,
        ExportFormat::Urdf,
        ExportFormat::Mujoco,
        ExportFormat::Payload,
        ExportFormat::Csv,
        ExportFormat::C,
        ExportFormat::Python,
        ExportFormat::Markdown,
        ExportFormat::Latex,
    ];

    /// The name on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            ExportFormat::Ros2 => "ros2",
            ExportFormat::Urdf => "urdf",
            ExportFormat::Mujoco => "mujoco",
            ExportFormat::Payload => "payload",
            ExportFormat::Csv => "csv",
            ExportFormat::C => "c",
            ExportFormat::Python => "python",
            ExportFormat::Markdown => "markdown",
            ExportFormat::Latex => "latex",
        }
    }

    /// Whether it describes the robot itself, in which torque sensors and instruments have no place.
    pub fn is_robot(self) -> bool {
        matches!(self, ExportFormat::Urdf | ExportFormat::Mujoco)
    }
}

impl fmt::Display for ExportFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No format has this name.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown format `{name}`; there is: {}", ExportFormat::ALL.map(ExportFormat::as_str).join(", "))]
pub struct UnknownFormat {
    name: String,
}

impl FromStr for ExportFormat {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        let found = ExportFormat::ALL.into_iter().find(|format| format.as_str() == name);
        found.ok_or_else(|| UnknownFormat { name: name.to_owned() })
    }
}

/// What is exported.
#[derive(Clone, Copy, Debug)]
pub struct Export<'a> {
    /// The calibration.
    pub estimate: &'a EarlierEstimate,
    /// Where it comes from, in words: file, estimator, hash.
    pub source: &'a str,
    /// Whether nominal values stand for what is not determined.
    pub nominal: bool,
    /// The robot's URDF, which only [`ExportFormat::Urdf`] needs.
    pub robot: Option<RobotDescription<'a>>,
    /// The robot as the session knows it, which only [`ExportFormat::Mujoco`] needs.
    pub model: Option<RobotModel<'a>>,
}

/// A file's contents.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// The file.
    pub text: String,
    /// What whoever takes it should know; the file says it, too.
    pub remarks: Vec<String>,
}

/// Why a calibration cannot be exported.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ExportError {
    /// Parameters without a value.
    #[error("the calibration does not determine {}", names.join(", "))]
    Undetermined {
        /// Their names.
        names: Vec<String>,
    },
    /// Sensors that are more than gain and bias.
    #[error(
        "{format} holds gain and bias only, and the calibration's sensors have {} besides; csv, markdown and latex hold them",
        names.join(", ")
    )]
    BeyondAffine {
        /// The format.
        format: ExportFormat,
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// A reading that depends on something sensed along an axis that is not read.
    #[error(
        "the gains of {name} are a matrix, and its axis {axis} is not read: no reading can be turned back; csv, markdown and \
         latex hold them"
    )]
    UnreadAxis {
        /// The instrument.
        name: String,
        /// The axis.
        axis: String,
    },
    /// A gain through which no reading can be turned back.
    #[error("{name} is zero: no reading tells what it is a reading of")]
    ZeroGain {
        /// The gain.
        name: String,
    },
    /// A joint of which the file does not say everything that [`SensorParameter::ALL`](gravcal_robot_model::parameter::SensorParameter::ALL) names.
    #[error("the calibration says nothing of {}: it is damaged, or not as gravcal wrote it", names.join(", "))]
    Missing {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// A joint whose name is a key of the format.
    #[error(
        "{format} has a key `{name}` of its own, which is a joint's name here: rename the joint, or take another format"
    )]
    NameTaken {
        /// The format.
        format: ExportFormat,
        /// The joint.
        name: String,
    },
    /// A table cannot be written.
    #[error("the table cannot be written: {why}")]
    Unwritable {
        /// What the writer says.
        why: String,
    },
    /// There is no URDF to correct.
    #[error("a URDF is made from the robot's own, and the session's robot is no URDF")]
    NoUrdf,
    /// There is no robot to describe.
    #[error("a model is made from the session's robot, which was not given")]
    NoModel,
    /// The calibration has no inertias that a simulator takes.
    #[error("the calibration has no inertias of rigid bodies, and a simulator takes no others")]
    NoInertias,
    /// No payload was asked for.
    #[error("the calibration has neither a load of unknown mass nor gravity")]
    NoPayload,
    /// Loads of which the mass is open: no nominal value stands for what is unknown.
    #[error("the calibration does not determine the mass of load {}", loads.join(", "))]
    OpenPayloads {
        /// Their names.
        loads: Vec<String>,
    },
    /// Joints that follow others.
    #[error("some joints mimic others, which this format does not hold: export to urdf")]
    Mimics,
    /// The URDF cannot be corrected.
    #[error(transparent)]
    Urdf(#[from] UrdfError),
}

impl Export<'_> {
    /// The calibration in a format.
    ///
    /// # Errors
    /// See [`ExportError`]; `markdown` and `latex` have none.
    pub fn to(&self, format: ExportFormat) -> Result<Exported, ExportError> {
        let corrections = || Corrections::new(self.estimate, self.nominal, format);
        match format {
            ExportFormat::Csv => csv::export(self),
            ExportFormat::Markdown => Ok(markdown::export(self)),
            ExportFormat::Latex => Ok(latex::export(self)),
            ExportFormat::Ros2 => ros2::export(self, &corrections()?),
            ExportFormat::C => Ok(c_header::export(self, &corrections()?)),
            ExportFormat::Python => Ok(python::export(self, &corrections()?)),
            ExportFormat::Urdf => urdf::export(self, &corrections()?),
            ExportFormat::Mujoco => self.mujoco(&corrections()?),
            ExportFormat::Payload => self.payload(),
        }
    }
}

/// The robot as gravcal computes with it.
#[derive(Clone, Copy, Debug)]
pub struct RobotModel<'a> {
    /// Name of the robot.
    pub name: &'a str,
    /// Its joints and links.
    pub chain: &'a Chain,
}

impl Export<'_> {
    fn mujoco(&self, corrections: &Corrections) -> Result<Exported, ExportError> {
        let RobotModel { name, chain } = self.model.ok_or(ExportError::NoModel)?;
        let inertias = self.estimate.inertias.as_deref().ok_or(ExportError::NoInertias)?;
        let gravity =
            corrections.gravity.ok_or_else(|| ExportError::Undetermined { names: vec!["gravity".to_owned()] })?;
        if chain.joint_count() < chain.link_count() {
            return Err(ExportError::Mimics);
        }
        let offsets = corrections.joints.iter().map(|joint| (joint.name.clone(), joint.position.offset));
        let arm = mujoco::Arm { name, chain, inertias, offsets: &offsets.collect::<Vec<_>>(), gravity };
        let text = arm.text(&head(self, &mujoco::CONVENTION, &corrections.remarks));
        let text = text.map_err(|missing| ExportError::Missing { names: vec![format!("{}.inertia", missing.link)] })?;
        Ok(Exported { text, remarks: corrections.remarks.clone() })
    }

    fn payload(&self) -> Result<Exported, ExportError> {
        let (payloads, gravity) = (&self.estimate.payloads, self.estimate.gravity);
        if payloads.is_empty() && gravity.is_none() {
            return Err(ExportError::NoPayload);
        }
        let open = payloads.iter().filter(|load| load.mass_kg.is_none()).map(|load| load.load.clone());
        let loads: Vec<String> = open.collect();
        if !loads.is_empty() {
            return Err(ExportError::OpenPayloads { loads });
        }
        let text = payload::text(payloads, gravity, &head(self, &payload::CONVENTION, &[]));
        Ok(Exported { text, remarks: Vec::new() })
    }
}

/// Lines for a file's head: where it comes from, the convention, remarks.
fn head(export: &Export<'_>, convention: &[impl AsRef<str>], remarks: &[String]) -> Vec<String> {
    let source = format!("gravcal {}: {}", env!("CARGO_PKG_VERSION"), export.source);
    let convention = convention.iter().map(|line| line.as_ref().to_owned());
    let remarks = remarks.iter().map(|remark| format!("Note: {remark}."));
    std::iter::once(source).chain(convention).chain(remarks).map(|line| one_line(&line)).collect()
}
