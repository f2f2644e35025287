//! Why a calibration cannot be exported.

use gravcal_dynamics::UrdfError;
use thiserror::Error;

use super::format::ExportFormat;

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
