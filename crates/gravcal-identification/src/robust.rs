//! Robust losses in stages.
//!
//! A loss knows an outlier by its residual, so good readings must look good from the start, and a cost that is not convex
//! has several minima. The problem is therefore solved by least squares first, then with Huber's convex loss, and with a
//! loss that forgets outliers last, each from where the one before ended.
//!
//! ```text
//!     none → Huber → Cauchy, Tukey or Geman-McClure
//! ```

use gravcal_estimation::{Estimate, Loss, LossName, Problem, SolveError, Values};

use crate::workbench::Workbench;

/// Solves a problem under `loss`, and hands back the problem with it. `under`: the problem with its readings under a loss.
///
/// # Errors
/// Where a problem under a loss cannot be built, or has no answer at all.
pub fn solve_in_stages<E: From<SolveError>>(
    loss: Loss,
    start: &Values,
    under: impl Fn(Loss) -> Result<Problem, E>,
    workbench: &Workbench<'_>,
) -> Result<(Problem, Estimate), E> {
    let mut values = start.clone();
    for stage in stages_before(loss) {
        values = workbench.solve(&under(stage)?, &values)?.values;
    }
    let last = under(loss)?;
    let estimate = workbench.solve(&last, &values)?;
    Ok((last, estimate))
}

/// Losses that lead to one.
fn stages_before(loss: Loss) -> Vec<Loss> {
    match loss.name() {
        LossName::None => Vec::new(),
        LossName::Huber => vec![Loss::None],
        LossName::Cauchy | LossName::Tukey | LossName::GemanMcClure => vec![Loss::None, LossName::Huber.efficient()],
    }
}
