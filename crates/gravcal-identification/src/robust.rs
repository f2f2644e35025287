//! Robust losses in stages.
//!
//! A loss knows an outlier by its residual, so good readings must look good from the start, and a cost that is not convex
//! has several minima. The problem is therefore solved by least squares first, then with Huber's convex loss, and with a
//! loss that forgets outliers last, each from where the one before ended.
//!
//! ```text
//!     none → Huber → Cauchy, Tukey or Geman-McClure
//! ```
//!
//! Why it is so, and what was tried: `docs/decisions/loss-in-stages.md`.

use gravcal_estimation::{Estimate, Loss, LossName, Problem, SolveError, Values};

use crate::environment::SolveEnvironment;

/// Solves a problem under `loss`, and hands back the problem with it. `under`: the problem with its readings under a loss.
///
/// # Errors
/// Where a problem under a loss cannot be built, or has no answer at all.
pub fn solve_in_stages<E: From<SolveError>>(
    loss: Loss,
    start: &Values,
    under: impl Fn(Loss) -> Result<Problem, E>,
    environment: &SolveEnvironment<'_>,
) -> Result<(Problem, Estimate), E> {
    let mut values = start.clone();
    for stage in stages_before(loss) {
        values = environment.solve(&under(stage)?, &values)?.values;
    }
    let last = under(loss)?;
    let estimate = environment.solve(&last, &values)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{sensor, with_environment};

    /// Readings of one number, of which some are far off.
    const READINGS: [f64; 9] = [0.3, -0.5, 0.1, 0.8, -0.2, -0.7, 9.0, 9.3, 8.8];

    /// Where a fit of the number under a loss ends, from beside the outliers.
    fn found(loss: Loss) -> f64 {
        let readings = READINGS.map(|y| (0.0, y, 1.0));
        let problem = |loss| sensor(&readings, [1.0, 0.0, 9.0], &[0, 1], loss);
        let (_, start, [.., bias]) = problem(Loss::None);
        let under = |loss: Loss| -> Result<Problem, SolveError> { Ok(problem(loss).0) };
        let (_, estimate) = with_environment(|w| solve_in_stages(loss, &start, under, w)).unwrap();
        estimate.values.scalar(bias)
    }

    #[test]
    fn hubers_loss_ends_where_the_bounded_residuals_balance() {
        let width = LossName::Huber.efficient().width().unwrap();
        let balance = |at: f64| READINGS.iter().map(|y| (y - at).clamp(-width, width)).sum::<f64>();
        let (mut low, mut high) = (-10.0, 10.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if balance(middle) > 0.0 { low = middle } else { high = middle }
        }
        assert!((found(LossName::Huber.efficient()) - low).abs() < 1e-4, "{low}");
    }

    #[test]
    fn a_loss_that_forgets_outliers_is_led_to_the_lowest_of_its_minima() {
        let loss = LossName::Cauchy.efficient();
        let width = loss.width().unwrap();
        let cost = |at: f64| READINGS.iter().map(|y| (1.0 + ((y - at) / width).powi(2)).ln()).sum::<f64>();
        let lowest = (-200..1000).map(|k| 0.01 * f64::from(k)).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap();
        assert!((found(loss) - lowest).abs() < 0.02, "{} {lowest}", found(loss));
    }
}
