//! The damped linear model of the cost as a quadratic function of pure numbers.
//!
//! ```text
//!     ½ ‖J δ + r‖² + ½ λ ‖D δ‖² − ½ ‖r‖²  =  ‖r‖²/(1 + λ) (½ wᵀ K w + qᵀ w),     δ_j = ‖r‖ / ((1 + λ) D_j) w_j
//!     K = (D⁻¹ JᵀJ D⁻¹ + λ I) / (1 + λ),     q_j = (Jᵀ r)_j / (D_j ‖r‖)
//! ```
//!
//! `q` holds cosines, K has a diagonal of at most one, and `w = 1` is a step that changes the residuals by as much as
//! they are.

use faer::Mat;
use gravcal_estimation::Linearization;

use super::programme::Quadratic;

/// Damping at least: JᵀJ carries rounding errors of this size, and could otherwise fall for directions without
/// information.
const LEAST_DAMPING: f64 = 1e-13;

/// The model at one point and one damping.
pub(super) struct Model {
    pub quadratic: Quadratic,
    /// Step of each column for w = 1.
    pub units: Vec<f64>,
    /// Cost for a value 1 of the quadratic function.
    pub energy: f64,
}

impl Model {
    pub fn new(linearization: &dyn Linearization, scaling: &[f64], damping: f64) -> Model {
        let damping = damping.max(LEAST_DAMPING);
        let (columns, hessian) = (scaling.len(), linearization.hessian());
        let residual = (2.0 * linearization.cost()).sqrt();
        let scaled = |i: usize, j: usize| hessian[i * columns + j] / (scaling[i] * scaling[j]);
        let curvature = |i, j| (scaled(i, j) + if i == j { damping } else { 0.0 }) / (1.0 + damping);
        let slope = linearization.gradient().iter().zip(scaling).map(|(g, d)| g / (d * residual)).collect();
        Model {
            quadratic: Quadratic { curvature: Mat::from_fn(columns, columns, curvature), slope },
            units: scaling.iter().map(|d| residual / ((1.0 + damping) * d)).collect(),
            energy: residual * residual / (1.0 + damping),
        }
    }
}
