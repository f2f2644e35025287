//! Residuals of one's own: what else was observed of the arm, as further rows of the joint problem, with unknowns of their own.
//!
//! ```text
//!     r = f(x; g, θ, columns)          prediction less reading, one row for each tie of one pose or several
//! ```
//!
//! A *model* ([`ResidualModel`]) has a name in files and declares a *term* ([`ResidualTerm`]): which poses each of its rows ties together,
//! how uncertain the row is, and its value from the true coordinates of the joints, gravity, columns of the tables and parameters `x` of
//! its own. The joint estimate solves for all of these at once, and its parameters are judged, told and exported like any other. A row
//! of one pose is an instrument (a dial gauge, an inclinometer), one of several a contact (two poses that put a tool to one height).
//!
//! ```toml
//! [[residual]]
//! kind = "dial-gauge"                                # the model's name
//! name = "gauge"                                     # its parameters are told as gauge.zero
//! columns = { reading = "dial_m" }                   # its columns in the tables; a pose whose cell is empty has no row
//! std_m = 2e-5                                       # options of the model
//! parameters = { zero = { nominal = 0.3, std = 0.01, unit = "m" } }
//! ```
//!
//! # Adding one
//!
//! 1. A term: a [`ResidualFormula`], whose derivatives are found by dual numbers, or a [`ResidualTerm`] with its own, which
//!    [`check_residual_derivatives`] holds against differences.
//! 2. A [`ResidualModel`] that declares its parameters: name, unit, where they start, and how uncertain they may be before a number
//!    misleads. One that several residuals or sensors share is declared by each of them, as [shared](crate::sensors::ParameterSpec::shared).
//! 3. A [`Registry`](crate::Registry) that knows it, handed to whoever reads a session.
//!
//! A gauge that reads how high a point of a link is, above a table of unknown height:
//!
//! ```
//! use gravcal_estimation::Number;
//! use gravcal_robot_model::Registry;
//! use gravcal_robot_model::parameter::Limit;
//! use gravcal_robot_model::residual_models::{
//!     DeclaredResidual, DifferentiatedResidual, ResidualFormula, ResidualModel, Scene, Sees, Setting, Tie,
//! };
//! use gravcal_robot_model::sensors::{Options, ParameterSpec, RefusedOption};
//! use gravcal_robot_model::session::Pose;
//!
//! #[derive(Debug)]
//! struct Height {
//!     link: usize,
//!     joints: Vec<usize>,
//!     column: usize,
//! }
//!
//! impl ResidualFormula for Height {
//!     fn sees(&self) -> Sees {
//!         Sees::nothing().coordinates(&self.joints)
//!     }
//!
//!     fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
//!         Tie::in_each(poses, self.column, 2e-5)
//!     }
//!
//!     fn value<N: Number>(&self, _tie: &Tie, at: &[Scene<'_, N>], x: &[N]) -> N {
//!         let zero = N::from(0.0);
//!         let [_, _, height] = at[0].frame(self.link).point([zero, zero, N::from(0.1)]);
//!         height - x[0] - at[0].column(self.column)
//!     }
//! }
//!
//! #[derive(Debug)]
//! struct DialGauge;
//!
//! impl ResidualModel for DialGauge {
//!     fn name(&self) -> &str {
//!         "dial-gauge"
//!     }
//!
//!     fn help(&self) -> &str {
//!         "a gauge reads how high a point of a link is"
//!     }
//!
//!     fn options(&self) -> &[&str] {
//!         &["link"]
//!     }
//!
//!     fn columns(&self) -> Vec<&str> {
//!         vec!["reading"]
//!     }
//!
//!     fn declare(&self, setting: &Setting<'_>, options: &Options) -> Result<DeclaredResidual, RefusedOption> {
//!         let link = setting.link(options, "link")?;
//!         let zero = ParameterSpec::new("zero", "m", Limit::Absolute(0.001))
//!             .in_equation("reading = height of the point - zero")
//!             .cured_by("read the gauge in more poses");
//!         let height = Height { link, joints: setting.joints_moving(link), column: setting.column("reading") };
//!         Ok(DeclaredResidual::new([zero], DifferentiatedResidual(height)))
//!     }
//! }
//!
//! let registry = Registry::standard().with_residual_model(DialGauge);
//! assert_eq!(registry.residual_model("dial-gauge").unwrap().name(), "dial-gauge");
//! ```
//!
//! A row has a stated standard deviation: noise is not estimated from such rows, and no loss counts them less. What they see of the arm is
//! where it is and how gravity acts; torques are the business of [sensor models](crate::sensors). A session with compliant joints or
//! recordings of an arm in motion has none.

mod automatic;
mod declare;
mod derivative_check;
mod model;
mod scene;
mod term;

pub use automatic::{DifferentiatedResidual, ResidualFormula};
pub use declare::{ResidualInUse, declare_residual};
pub use derivative_check::check_residual_derivatives;
pub use model::{DeclaredResidual, ResidualModel, Setting};
pub use scene::{Place, Scene};
pub use term::{ResidualRow, ResidualTerm, Sees, Slopes, Tie};
