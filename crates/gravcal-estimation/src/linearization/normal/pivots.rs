//! Pivots of a Cholesky factor, and how many digits they leave.

use faer::linalg::solvers::Llt;

/// Square of the smallest relative pivot with which a step keeps five digits in its weakest direction.
pub(super) const LEAST_PIVOT: f64 = 1e-11;

/// Damping, relative to the column norms, with which pivots of directions without information are large enough.
pub(super) const LEAST_DAMPING: f64 = 10.0 * LEAST_PIVOT;

/// Whether every pivot, relative to the diagonal it came from, is large enough.
pub(super) fn keeps_digits(factor: &Llt<f64>, diagonal: &[f64]) -> bool {
    let triangle = factor.L();
    diagonal.iter().enumerate().all(|(i, d)| {
        let pivot = triangle[(i, i)] * triangle[(i, i)];
        pivot.is_finite() && pivot > LEAST_PIVOT * d
    })
}
