//! Sessions with known truth: what the sensors of a known robot would read.
//!
//! ```text
//!     θ_i = s_i q_i + o_i + δ_i,     y_i = convert(k_i τ_i(θ) + b_i + noise)
//! ```
//!
//! and whatever else its sensors do ([`gravcal_robot_model::sensors`]).
//!
//! `δ` is the deflection of a joint that stands still, which its position sensor does not see (unless it is told to). Everything random
//! comes from one generator with a stream a trial, so that a trial depends on the seed and its number only.

mod conditions;
mod disturbance;
mod draw;
mod earlier_load;
mod experiment;
mod file;
mod friction;
mod harmonic;
mod instruments;
mod motion;
mod normal;
mod recording;
mod statics;
mod stroke;
mod unmodelled;
mod write;
mod write_conditions;
mod write_recording;

pub use conditions::SimulatedConditions;
pub use disturbance::{Converter, Deflection, Disturbance, Outliers};
pub use earlier_load::{Creep, Hysteresis};
pub use experiment::{Run, Simulation};
pub use friction::FrictionAtRest;
pub use motion::{Approach, Dirt, HarmonicMotion, Motion};
pub use recording::{Recorded, Sink, TrueStandstill, record};
pub use unmodelled::Unmodelled;
pub use write::{SimulateError, session_files, write_session};
