//! The answer of a solver.

use std::fmt;

use crate::{ActiveConstraint, Column, NormalEquations, Values};

/// Why a solver stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Termination {
    /// The residual is orthogonal to every column of the Jacobian: the largest cosine is at or below the tolerance. With
    /// constraints, what they hold back is taken off first: the point obeys the conditions of Karush, Kuhn and Tucker.
    Gradient {
        /// Largest |cosine| between the residual and a column of the Jacobian.
        cosine: f64,
    },
    /// The residual is orthogonal to whatever the Jacobian leads to.
    Offset {
        /// Length of what the full step would take off the residual, relative to that of the residual.
        offset: f64,
    },
    /// The step no longer changes the parameters.
    Step {
        /// Length of the step relative to that of the parameters, both scaled by the Jacobian's column norms.
        relative: f64,
    },
    /// Neither the predicted nor the actual reduction of the cost is worth another iteration.
    Cost {
        /// Predicted reduction relative to the cost.
        relative: f64,
    },
    /// The residuals are zero to the last digit.
    ZeroResidual,
    /// The iterations allowed were used up.
    IterationLimit {
        /// How many were allowed.
        limit: usize,
    },
    /// No step lowers the cost, however short; but the point is not stationary as far as the Jacobian tells.
    NoProgress,
    /// No unknown changes any residual: every derivative is zero, though the residuals are not.
    NoEffect,
    /// Stopped from outside.
    Stopped,
    /// Not minimised at all: values judged as they were given.
    AsGiven,
}

impl Termination {
    /// Whether the solver ended at a stationary point.
    pub fn converged(self) -> bool {
        matches!(
            self,
            Termination::Gradient { .. }
                | Termination::Offset { .. }
                | Termination::Step { .. }
                | Termination::Cost { .. }
                | Termination::ZeroResidual
        )
    }
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Termination::Gradient { cosine } => {
                write!(f, "converged: residual orthogonal to the Jacobian (largest cosine {cosine:.1e})")
            }
            Termination::Offset { offset } => {
                write!(f, "converged: residual orthogonal to the Jacobian (relative offset {offset:.1e})")
            }
            Termination::Step { relative } => write!(f, "converged: steps too small to matter ({relative:.1e})"),
            Termination::Cost { relative } => write!(f, "converged: cost no longer falls ({relative:.1e})"),
            Termination::ZeroResidual => write!(f, "converged: residuals are zero"),
            Termination::IterationLimit { limit: 1 } => write!(f, "not converged after 1 iteration"),
            Termination::IterationLimit { limit } => write!(f, "not converged after {limit} iterations"),
            Termination::NoProgress => write!(f, "not converged: no step lowers the cost"),
            Termination::NoEffect => {
                write!(
                    f,
                    "not converged: no unknown has an effect, as every derivative is zero (is the Jacobian written?)"
                )
            }
            Termination::Stopped => write!(f, "stopped from outside"),
            Termination::AsGiven => write!(f, "not minimised: judged as given"),
        }
    }
}

/// What happened in one iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterationRecord {
    /// Counted from 0, the start.
    pub iteration: usize,
    /// Cost ½ Σ r² of the whitened residuals after the iteration.
    pub cost: f64,
    /// Largest |cosine| between the residual and a column of the Jacobian, what constraints hold back taken off.
    pub cosine: f64,
    /// Relative length of the accepted step.
    pub step: f64,
    /// Damping λ of the accepted step; 0 for methods without.
    pub damping: f64,
}

/// A solver's answer. Weights of outliers are had from [`Problem::weights`](crate::Problem::weights), what is determined
/// from [`RankAnalysis`](crate::RankAnalysis), standard deviations from [`statistics`](crate::statistics).
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Values of all blocks, fixed ones included.
    pub values: Values,
    /// Cost ½ Σ r² of the whitened residuals; twice it is χ².
    pub cost: f64,
    /// Why it stopped.
    pub termination: Termination,
    /// The way it went, the start first.
    pub iterations: Vec<IterationRecord>,
    /// Values of all blocks at the end of each iteration, the start first; of a solve that goes on from a checkpoint only
    /// what came after it, and empty where several solves make one.
    pub iterates: Vec<Values>,
    /// Constraints on which the solution leans; empty without constraints.
    pub active: Vec<ActiveConstraint>,
    /// Unknowns without any effect where it ended: their columns of the Jacobian are zero, or nothing but rounding. They
    /// stand where they started.
    pub without_effect: Vec<Column>,
    /// The problem's normal equations at `values`, with its factors and their losses, if the method had them:
    /// [`RankAnalysis::of`](crate::RankAnalysis::of) need not sum them again.
    pub normal_equations: Option<NormalEquations>,
}
