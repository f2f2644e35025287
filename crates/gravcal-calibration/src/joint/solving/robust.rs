//! Robust losses in the joint problem.

use gravcal_estimation::{Estimate, Loss};
use gravcal_identification::{SolveEnvironment, solve_in_stages};

use crate::joint::error::EstimateError;
use crate::joint::problem::JointProblem;

/// Solves a problem built without a loss under `loss`.
pub(in crate::joint) fn solve_with_loss(
    built: &JointProblem,
    loss: Loss,
    environment: &SolveEnvironment<'_>,
) -> Result<(JointProblem, Estimate), EstimateError> {
    let under = |loss: Loss| -> Result<_, EstimateError> { Ok(built.with_loss(loss)?.problem) };
    let (problem, estimate) = solve_in_stages(loss, &built.initial, under, environment)?;
    let mut robust = built.clone().with_problem(problem);
    robust.loss = loss;
    Ok((robust, estimate))
}
