//! The damped linear model of the cost as a quadratic function of pure numbers.
//!
//! ```text
//!     ½ ‖J δ + r‖² + ½ λ ‖D δ‖² + ½ δᵀ C δ − ½ ‖r‖²  =  ‖r‖²/(1 + λ) (½ wᵀ K w + qᵀ w)
//!     δ_j = ‖r‖ / ((1 + λ) D_j) w_j,     K = (D⁻¹ (JᵀJ + C) D⁻¹ + λ I) / (1 + λ),     q_j = (Jᵀ r)_j / (D_j ‖r‖)
//! ```
//!
//! `q` holds cosines, and at no damping `w = 1` is a step that changes the residuals by as much as they are.
//!
//! `C` is diagonal. A vector x of known length that steps by δ along its tangent plane and is scaled back ends
//! `‖δ‖² x / (2 ‖x‖²)` short of the plane. Where the readings pull it outwards that costs `½ ‖δ‖² (−xᵀ Jᵀ r) / ‖x‖²`, without
//! which every step would be too long.

use faer::Mat;
use gravcal_estimation::{ConstraintKind, Linearization};

use super::programme::Quadratic;
use super::rows::Rows;
use crate::Point;

/// Damping at least: JᵀJ carries rounding errors of this size, and could otherwise fall for directions without
/// information.
const LEAST_DAMPING: f64 = 1e-13;

/// The model at one point and one damping.
pub(super) struct Model {
    /// K and q.
    pub quadratic: Quadratic,
    /// Cost for a value 1 of the quadratic function.
    pub energy: f64,
    /// `‖r‖ / ((1 + λ) D_j)`.
    units: Vec<f64>,
    /// The diagonal of C.
    bend: Vec<f64>,
}

impl Model {
    pub fn new(point: &Point<'_>, lambda: f64, scaling: &[f64]) -> Model {
        let lambda = lambda.max(LEAST_DAMPING);
        let linearization = point.linearization.as_ref();
        let (columns, hessian) = (scaling.len(), linearization.hessian());
        let residual = (2.0 * linearization.cost()).sqrt();
        let bend = bend(point);
        let curvature = Mat::from_fn(columns, columns, |i, j| {
            let (bent, damped) = if i == j { (bend[i], lambda) } else { (0.0, 0.0) };
            ((hessian[i * columns + j] + bent) / (scaling[i] * scaling[j]) + damped) / (1.0 + lambda)
        });
        let slope = linearization.gradient().iter().zip(scaling).map(|(g, d)| g / (d * residual)).collect();
        Model {
            quadratic: Quadratic { curvature, slope },
            energy: residual * residual / (1.0 + lambda),
            units: scaling.iter().map(|d| residual / ((1.0 + lambda) * d)).collect(),
            bend,
        }
    }

    /// Rows over columns as rows over w, brought to length one.
    pub fn rows(&self, over_columns: &[Rows]) -> Vec<Rows> {
        over_columns.iter().map(|rows| rows.in_units(&self.units)).collect()
    }

    /// The step of the columns for a step w.
    pub fn step(&self, w: &[f64]) -> Vec<f64> {
        self.units.iter().zip(w).map(|(unit, w)| unit * w).collect()
    }

    /// Reduction of the cost that the linear model predicts for a step, the damping not counted.
    pub fn predicted_reduction(&self, linearization: &dyn Linearization, step: &[f64]) -> f64 {
        let along: f64 = linearization.gradient().iter().zip(step).map(|(g, d)| g * d).sum();
        let bent: f64 = self.bend.iter().zip(step).map(|(c, d)| c * d * d).sum();
        -along - 0.5 * (linearization.image_norm_squared(step) + bent)
    }
}

/// The diagonal of C.
fn bend(point: &Point<'_>) -> Vec<f64> {
    let problem = point.problem;
    let gradient = point.linearization.gradient();
    let mut bend = vec![0.0; gradient.len()];
    for constraint in problem.constraints() {
        if let ConstraintKind::Length { block, length } = &constraint.kind {
            let columns = problem.columns_of(*block);
            let pull: f64 = gradient[columns.clone()].iter().zip(point.values.get(*block)).map(|(g, x)| -g * x).sum();
            bend[columns].fill(pull.max(0.0) / (length * length));
        }
    }
    bend
}
