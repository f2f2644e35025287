//! Sums that overflow.

use crate::problem::Rows;
use crate::{EvaluateError, Problem, Values};

/// # Errors
/// Names the factor, where sums over all of them are not finite.
pub(super) fn check_finite(problem: &Problem, values: &Values, sums: [&[f64]; 2]) -> Result<(), EvaluateError> {
    if sums.into_iter().flatten().all(|v| v.is_finite()) {
        return Ok(());
    }
    let mut rows = Rows::new(problem, values);
    for factor in 0..problem.factors().len() {
        rows.linearize(factor, true)?;
        rows.check_jacobian(factor)?;
    }
    Err(EvaluateError(
        "the squares of the residuals' derivatives overflow; check the units, and the sizes of what is given as known"
            .into(),
    ))
}
