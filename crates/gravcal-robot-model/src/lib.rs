//! What a robot's sensors read: the model of a robot with its sensors, and a session as data.
//!
//! ```text
//!     reading of torque    y_i = k_i τ_i(θ; g, moments, load) + b_i        (paper, eqs. (5)–(8))
//!     joint coordinate     θ_i = s_i q_i + o_i                             (paper, eq. (3))
//! ```
//!
//! after Ma, Hollerbach and Xu, *Gravity Based Autonomous Calibration for Robot Manipulators*, 1994. [`residuals`] says what readings
//! should be, [`sensors`] what sensors do beyond gain and bias, and a [`Session`] is what a user says of one calibration.
//!
//! Inside: SI units and radians; torque readings in the unit of their sensor. No file is read here, and nothing is estimated: that is
//! `gravcal-session` and `gravcal-calibration`.

mod central_difference;
mod estimator_name;
mod registry;
mod solver_factory;
mod state;

pub mod axis_frames;
pub mod number;
pub mod parameter;
pub mod residual_models;
pub mod residuals;
pub mod robot;
pub mod sensors;
pub mod session;
pub mod sweeps;

pub use estimator_name::{EstimatorName, UnknownEstimator};
pub use registry::{Registry, UnknownName};
pub use robot::Robot;
pub use session::Session;
pub use solver_factory::SolverFactory;
pub use state::State;
