//! The fit of a built problem, with its readings in the order in which they enter.

use gravcal_estimation::Estimate;
use gravcal_identification::{FIRST_ITERATIONS, Fit, ROUNDS, SolveEnvironment};

use crate::joint::error::EstimateError;
use crate::joint::order::Order;
use crate::joint::problem::JointProblem;
use crate::joint::solving::in_order::estimate_in_order;

/// Minimises what readings and knowledge cost: the problem with its reference where the fit ended, and its end. The cost is
/// that of readings and knowledge alone.
pub(in crate::joint) fn fit(
    built: &JointProblem,
    environment: &SolveEnvironment<'_>,
) -> Result<(JointProblem, Estimate), EstimateError> {
    fit_in_rounds(built, ROUNDS, environment)
}

/// The same in so many rounds at most. Readings that enter group by group have no rounds: the last group's reference ends with it.
pub(in crate::joint) fn fit_in_rounds(
    built: &JointProblem,
    rounds: usize,
    environment: &SolveEnvironment<'_>,
) -> Result<(JointProblem, Estimate), EstimateError> {
    // Far from nominal values the way is long as long as these pull: it goes on without them.
    let (built, first) = estimate_in_order(built, &environment.within(FIRST_ITERATIONS))?;
    let fit = Fit::ended(built.problem.clone(), first);
    let Fit { problem, estimate } = match built.readings().order {
        Order::Together => fit.followed(built.rows.len(), rounds, environment),
        _ => fit,
    };
    Ok((built.with_problem(problem), estimate))
}
