//! What joint sensors do beyond gain and bias, gain and offset.
//!
//! ```text
//!     reading of torque    y_i = k_i τ_i + b_i + Σ f(x; τ, θ, q, conditions)
//!     joint coordinate     θ_i = s_i q_i + o_i + Σ f(x; q, conditions)
//! ```
//!
//! A *model* ([`SensorModel`]) has a name in files and declares *terms* ([`SensorTerm`]) for the sensor of a joint: functions `f` of what
//! is in a pose ([`Moment`]), each with named parameters `x` in which it may be nonlinear. Affine sensors have none, and cost nothing.
//!
//! # Adding a sensor model
//!
//! A session without Rust writes a formula: `kind = "formula"` (the table below). A model in Rust, in any crate, is
//!
//! 1. a term: a [`SensorFormula`], whose derivatives are found by dual numbers, or a [`SensorTerm`] with its own, which
//!    [`check_term_derivatives`] holds against differences;
//! 2. a [`SensorModel`] that declares the term's parameters for a joint: name, unit, where they start, and how uncertain they may be before
//!    a number misleads;
//! 3. a [`Registry`](crate::Registry) that knows it, handed to whoever reads a session: `read_session_with`,
//!    `Simulation::read_with`, or the whole program, `gravcal_cli::main`.
//!
//! Torque that ripples over the joint's angle, `a sin(n q + φ)`:
//!
//! ```
//! use gravcal_robot_model::Registry;
//! use gravcal_robot_model::parameter::Limit;
//! use gravcal_robot_model::sensors::{
//!     Declared, Differentiated, Moment, Options, ParameterSpec, Reads, RefusedOption, SensorFormula, SensorModel, Site,
//! };
//! use gravcal_estimation::Number;
//!
//! #[derive(Debug)]
//! struct Wave {
//!     joint: usize,
//! }
//!
//! impl SensorFormula for Wave {
//!     fn reads(&self) -> Reads {
//!         Reads::positions()
//!     }
//!
//!     fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N {
//!         x[0] * (x[1] * at.position(self.joint) + x[2]).sin()
//!     }
//! }
//!
//! #[derive(Debug)]
//! struct Ripple;
//!
//! impl SensorModel for Ripple {
//!     fn name(&self) -> &str {
//!         "torque-ripple"
//!     }
//!
//!     fn help(&self) -> &str {
//!         "the torque reading ripples with the joint's angle"
//!     }
//!
//!     fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
//!         let parameter = |name: &str, unit: &str, limit| {
//!             ParameterSpec::new(name, unit, limit)
//!                 .in_equation("reading = ... + amplitude * sin(order * position + phase)")
//!                 .cured_by("add poses that move the joint through several periods")
//!         };
//!         let parameters = [
//!             parameter("amplitude", site.torque_unit(), site.half_spread()).starting_at(0.1),
//!             parameter("order", "1/rad", Limit::Absolute(0.1)).starting_at(6.0),
//!             parameter("phase", "rad", Limit::Absolute(0.2)),
//!         ];
//!         Ok(vec![Declared::new(parameters, Differentiated::new(Wave { joint: site.joint() }))])
//!     }
//! }
//!
//! let registry = Registry::standard().with_sensor_model(Ripple);
//! assert_eq!(registry.sensor_model("torque-ripple").unwrap().name(), "torque-ripple");
//! // read_session_with(path, &registry) now knows: sensor_models = [{ kind = "torque-ripple" }]
//! ```
//!
//! A parameter must matter where it starts: at an amplitude of zero, order and phase change nothing, and the solver cannot tell which way
//! they go. So such models start near what is expected. A model that vanishes where all of its parameters are zero is tested against its
//! absence; where it is nonlinear, with as many degrees of freedom as parameters, which is an approximation.
//!
//! # Formulas in sessions
//!
//! | key | what it says |
//! |---|---|
//! | `kind` | `formula` adds to the torque reading, `position-formula` to the coordinate |
//! | `adds` | the formula: `+ - * / ^`, `sin cos tan asin acos atan sinh cosh tanh exp ln sqrt abs sign`, `pi`; `torque coordinate position velocity direction temperature` of the joint or, as `torque[elbow]`, of another; `time`; `further[oil]` of a column that `readings.further = { oil = "p_oil" }` names; its unknowns |
//! | `unknowns` | by name, `unit` (as the formula counts it), `limit` (standard deviation beyond which a number would mislead), `nominal` (where it starts; 0 without it), `shared` (what has it, where formulas of several joints share it: `shared = "compensator"`) |
//! | `parameters` | what is known of its unknowns, as for any model |

mod automatic;
mod crosstalk;
mod declare;
mod derivative_check;
mod drift;
mod formula;
pub mod friction;
mod harmonics;
mod model;
mod options;
mod polynomial;
mod readings;
mod standard;
mod term;
mod terms;
#[cfg(test)]
pub(crate) mod testing;

pub use automatic::{Differentiated, SensorFormula};
pub use declare::{Term, declare_terms};
pub(crate) use declare::{check_parameters, declared_parameter};
pub(crate) use derivative_check::TOLERANCE;
pub use derivative_check::{WrongDerivative, check_term_derivatives};
pub use model::{Declared, ParameterSpec, SensorModel, Side, Site};
pub use options::{Options, RefusedOption};
pub(crate) use standard::standard_sensor_models;
pub use term::{Moment, Need, Partials, Reads, SensorTerm};
pub use terms::{ModelInUse, SensorTerms};
