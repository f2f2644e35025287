//! A session: everything that a user says of one calibration, resolved and checked. Inside: SI and radians.

mod arrays;
mod channels;
mod choices;
pub mod compliance;
mod contents;
mod doubts;
mod earlier;
mod instrument;
mod known;
pub mod load_masses;
mod moving;
mod parameter_prior;
pub mod parameters;
mod pose;
mod reading_id;
mod repeated;
pub mod rotors;
mod searched;
mod solver;
mod stuck;
pub mod travel;
mod unexplained;
pub mod units;

pub use arrays::{PoseArrays, PoseArraysError};
pub use choices::{Ask, Constraints, Deflection, PoseBlocks, UncertaintyChoice, UnexplainedError};
pub use contents::Session;
pub use doubts::{Joined, MistakenUnit};
pub use earlier::{EarlierCalibration, KnownCombination};
pub use instrument::{AuxiliarySensor, AuxiliarySensorKind, Drift};
pub use known::{GravityPrior, InertiaPrior, JointPriors, Load, LoadDistance};
pub use parameter_prior::{ParameterPrior, PriorKind};
pub use parameters::{BASE_FRAME_CHOICE, LAST_FRAME_CHOICE, NO_TORQUE_SENSOR};
pub use pose::{Pose, PoseTable};
pub use reading_id::ReadingId;
pub use searched::Searched;
pub use solver::SolverChoice;
