//! A session: everything that a user says of one calibration, resolved and checked. Inside: SI and radians.

mod arrays;
mod channels;
mod choices;
pub(crate) mod compliance;
mod contents;
mod doubts;
mod draft;
mod earlier;
mod file;
mod instrument;
mod knowledge;
mod known;
pub(crate) mod parameters;
mod pose;
mod repeated;
mod searched;
mod solver;
mod stuck;
pub(crate) mod travel;
mod unexplained;
pub(crate) mod units;

pub use arrays::{PoseArrays, PoseArraysError};
pub use choices::{Ask, Constraints, Deflection, PoseBlocks, UncertaintyChoice, UnexplainedError};
pub use contents::Session;
pub use doubts::MistakenUnit;
pub use draft::{Draft, DraftError, DraftPoses, DraftRobot, RecordedJoints};
pub use earlier::{EarlierCalibration, KnownCombination};
pub(crate) use file::{AccelerometerTable, ForceTorqueTable, Instruments, read_instruments};
pub use file::{
    SessionError, read_session, read_session_document, read_session_in_memory, read_session_watched, read_session_with,
    read_solver_options, solver_name_error,
};
pub use instrument::{Drift, Instrument, InstrumentKind};
pub use knowledge::{Knowledge, KnowledgeKind};
pub use known::{GravityKnowledge, InertiaKnowledge, JointKnowledge, Load, LoadDistance};
pub use parameters::{BASE_FRAME_CHOICE, LAST_FRAME_CHOICE, NO_TORQUE_SENSOR};
pub use pose::{Pose, PoseTable};
pub use searched::Searched;
pub use solver::SolverChoice;
