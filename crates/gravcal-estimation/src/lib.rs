//! Nonlinear least squares over named parameter blocks.
//!
//! Given measurements `y_f` with noise covariances `Σ_f` and models `h_f(x)`, this crate holds the problem
//!
//! ```text
//!     minimise over x   ½ Σ_f  r_f(x)ᵀ Σ_f⁻¹ r_f(x),     r_f(x) = h_f(x) − y_f
//! ```
//!
//! and judges its solution. `x` is a list of *blocks* (named groups of numbers with units, all of ℝⁿ or on
//! a [`Manifold`]); every term of the sum is a *factor*: a [`Residual`] in the unit of the reading, and its
//! [`Noise`].
//!
//! **Assumptions.** The noise is zero-mean with the stated covariance, factors are independent of each other, and
//! the residuals are smooth near the solution. Then twice the cost is χ²-distributed with (rows − rank) degrees of
//! freedom and `(JᵀJ)⁻¹` of the whitened Jacobian is the covariance of the estimate. Where the model is wrong,
//! the χ² says so, and that covariance is too small: [`statistics`] has others. Where a direction of `x` leaves every residual unchanged, no
//! value for it exists in the data: [`RankAnalysis`] finds those directions and names them; nothing here invents one.
//!
//! Three nouns, three places: the [`Problem`] only holds; a [`Solver`] only minimises (the methods are in
//! `gravcal-solvers`); [`RankAnalysis`] and [`statistics`] only judge. The crate knows no robot, and no file but those that
//! [`published`] problems come in.
//!
//! A residual is written as [`adding_a_residual`] shows: with derivatives by hand, or once as a [`Formula`] whose
//! derivatives are [`Automatic`].

mod automatic;
mod batch;
mod block;
mod by_column;
mod combination;
mod constraint;
mod derivative_check;
mod eliminated_columns;
mod estimate;
mod factor;
mod identifiability;
mod linearization;
mod loss;
mod loss_name;
mod manifold;
mod noise;
mod parallel;
pub mod passing_on;
mod problem;
pub mod published;
mod reference;
mod residual;
mod solver;
mod sparse_basis;
pub mod statistics;
#[cfg(test)]
mod testing;

#[doc = include_str!("../ADDING_A_RESIDUAL.md")]
pub mod adding_a_residual {}

pub use automatic::{Automatic, DIRECTIONS, Formula, LocalNumbers, Number};
pub use batch::{Batched, LANES, Sample, evaluate_batch};
pub use block::{Block, BlockId, Values};
pub use combination::{NamedCombination, NamedTerm, fixed_blocks, named_combinations};
pub use constraint::{ActiveConstraint, Affine, Constraint, ConstraintError, ConstraintKind};
pub use derivative_check::{DerivativeMismatch, check_derivatives};
pub use estimate::{Estimate, IterationRecord, Termination};
pub use factor::Factor;
pub use identifiability::{Elimination, RankAnalysis, WeakDirection};
pub use linearization::{Linearization, NormalEquations, StepInfo};
pub use loss::{Loss, LossWidth};
pub use loss_name::{LossName, UnknownLoss};
pub use manifold::{Manifold, ManifoldMismatch, Rotation, Sphere, check_manifold};
pub use noise::{Noise, NoiseError, Weights, Whitener};
pub use parallel::in_parallel;
pub use problem::{Column, Problem, ProblemBuilder, ProblemError};
pub use reference::Reference;
pub use residual::{EvaluateError, LocalValues, Residual, RowsMut};
pub use solver::{Observer, SolveContext, SolveError, Solver, Unsupported};
pub use sparse_basis::sparse_basis;
pub use statistics::{Covariance, Uncertainty};
