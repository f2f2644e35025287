//! Knowledge from an earlier calibration in the joint problem: one factor with its whole covariance.

use gravcal_estimation::{BlockId, Factor, Problem};
use gravcal_robot_model::residuals::{KnownCombination, LinearPrior};
use gravcal_robot_model::session::EarlierCalibration;

use crate::joint::error::BuildError;
use crate::joint::problem::JointProblem;

/// The problem with what the earlier calibration knows of its unknowns, behind all other factors.
pub(in crate::joint) fn with_earlier(
    earlier: &EarlierCalibration,
    built: JointProblem,
) -> Result<JointProblem, BuildError> {
    let known: Vec<Option<KnownCombination>> = earlier
        .quantities()
        .iter()
        .map(|quantity| {
            let term = |(name, coefficient): &(String, f64)| {
                component(&built.problem, name).map(|(id, component)| (id, component, *coefficient))
            };
            let terms: Option<Vec<_>> = quantity.terms.iter().map(term).collect();
            let times = quantity.times.as_ref().map(|gain| component(&built.problem, gain));
            // A gain that is none here leaves nothing of the product.
            let times = times.map_or(Some(None), |found| found.map(Some))?;
            terms.map(|terms| KnownCombination { terms, times, value: quantity.value })
        })
        .collect();
    // A load that no pose carries has no block: knowing the rest is knowing less.
    let kept: Vec<usize> = (0..known.len()).filter(|i| known[*i].is_some()).collect();
    if kept.is_empty() {
        return Ok(built);
    }
    let residual = LinearPrior::new(known.into_iter().flatten().collect());
    let mut factors = built.problem.factors().to_vec();
    factors.push(Factor::new(residual, earlier.noise(&kept)?));
    let problem = built.problem.with_factors(factors)?;
    Ok(built.with_problem(problem))
}

/// The block and the place in it of a component, such as `gravity.x` or `joint1.torque_gain`.
pub(in crate::joint) fn component(problem: &Problem, component: &str) -> Option<(BlockId, usize)> {
    let places = problem.block_ids().flat_map(|id| (0..problem.block(id).len()).map(move |i| (id, i)));
    places.into_iter().find(|(id, i)| problem.block(*id).component_name(*i) == component)
}
