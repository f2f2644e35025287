//! What both forms of a linearized problem offer.

use super::normal_equations::NormalEquations;

/// Damping that an orthogonal factorization bears: above the rounding errors of `JᵀJ` (1e-16), so that there is a factorization, and below
/// what readings determine.
const FAINT_DAMPING: f64 = 1e-14;

/// A problem linearized at one point.
pub trait Linearization {
    /// Cost there: ½ ‖r‖², or ½ Σ ρ with losses.
    fn cost(&self) -> f64;
    /// `Jᵀ r`, one entry a column.
    fn gradient(&self) -> &[f64];
    /// Euclidean norm of each column of J.
    fn column_norms(&self) -> &[f64];
    /// Scale of each column: its norm, or 1 for a column of zeros.
    fn column_scales(&self) -> Vec<f64> {
        column_scales(self.column_norms())
    }
    /// Minimises `½ ‖J δ + r‖² + ½ λ ‖diag(scaling) δ‖²` and writes `δ`.
    fn damped_step(&mut self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> StepInfo;

    /// The least damping, relative to the column norms, at which steps keep their digits with the effort that was spent so far.
    fn least_damping(&self) -> f64 {
        FAINT_DAMPING
    }

    /// `‖J v‖²`.
    fn image_norm_squared(&self, v: &[f64]) -> f64;

    /// `JᵀJ`, row-major, of all columns: memory grows with their square.
    fn hessian(&self) -> Vec<f64>;

    /// The same to be handed on, after elimination; nothing where that would lose digits.
    fn normal_equations(&self) -> Option<NormalEquations> {
        None
    }

    /// Largest |cosine| between the residual and a column of J: 0 at a stationary point, whatever the scales.
    fn largest_cosine(&self) -> f64 {
        let residual = (2.0 * self.cost()).sqrt();
        self.gradient()
            .iter()
            .zip(self.column_norms())
            .filter(|(_, norm)| **norm > 0.0 && residual > 0.0)
            .map(|(g, norm)| g.abs() / (norm * residual))
            .fold(0.0, f64::max)
    }
}

/// The norms of columns, or 1 for a column of zeros.
pub(crate) fn column_scales(norms: &[f64]) -> Vec<f64> {
    norms.iter().map(|norm| if *norm > 0.0 { *norm } else { 1.0 }).collect()
}

/// What a step promises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInfo {
    /// Reduction of the cost that the linear model predicts for the step, not counting the damping.
    pub predicted_reduction: f64,
}
