//! Values nearer to the nominal ones that explain the readings as well: what is told must not depend on where the readings happened to leave what
//! they do not determine.

use gravcal_estimation::Values;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::ParameterId;

use crate::joint::ends::surroundings::{AS_LIKELY, Place, Surroundings};
use crate::joint::error::EstimateError;

/// Iterations at most to where parameters are at their nominal values.
const ITERATIONS: usize = 100;

/// Where what is open is nearer to its nominal values, and where all parameters are.
pub(super) fn nearer_to_nominal(
    around: &Surroundings<'_>,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<Place>, EstimateError> {
    let (open, all) = (|id: &ParameterId| !around.judgement.determines(*id), |_: &ParameterId| true);
    let nearer = [drawn_to_nominal(around, open, environment)?, drawn_to_nominal(around, all, environment)?];
    Ok(nearer.into_iter().flatten().map(|values| Place { values, share: 1.0 }).collect())
}

/// Where the readings are explained as well with some parameters drawn to their nominal values; nothing where they are not.
fn drawn_to_nominal(
    around: &Surroundings<'_>,
    drawn: impl Fn(&ParameterId) -> bool,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Values>, EstimateError> {
    let (problem, estimate) = (around.solved.judged_problem(), &around.solved.estimate.values);
    let mut center = estimate.clone();
    for id in around.session.parameters().into_iter().filter(drawn) {
        center.set(around.solved.built.variables.block(id), &[around.session.nominal(id)]);
    }
    let drawn = problem.with_reference(around.plausible.centered_at(&center));
    // What cannot be solved there says nothing.
    let Ok(there) = environment.within(ITERATIONS).solve(&drawn, estimate) else { return Ok(None) };
    let alone = problem.without_reference();
    let growth = alone.cost(&there.values)? - alone.cost(estimate)?;
    Ok((growth < AS_LIKELY).then_some(there.values))
}
