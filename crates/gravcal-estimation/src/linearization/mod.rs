//! What a method needs of the Jacobian, without seeing how it is stored.
//!
//! Two forms: [`normal`] (normal equations, fast) and [`orthogonal`] (orthogonal factorization, no digit lost). Both
//! eliminate local blocks island by island, so that cost and memory grow linearly with their number. Damping comes
//! before elimination, and another damping reuses what was summed over the factors.

mod normal;
mod normal_equations;
mod orthogonal;
mod triangle;
mod vector_registers;

use crate::problem::Rows;
use crate::{Column, EvaluateError, Problem, Values};

pub(crate) use normal::Normal;
pub use normal_equations::NormalEquations;
pub(crate) use orthogonal::Orthogonal;

/// Columns smaller than this share of the largest are rounding errors: see [`dust`]. Units differ by far less (1e6 between a count
/// and a metre), rounding by more (1e-16).
const DUST: f64 = 1e-12;

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

    /// `‖J v‖²`.
    fn image_norm_squared(&self, v: &[f64]) -> f64;

    /// `JᵀJ`, row-major, of all columns: memory grows with their square.
    fn hessian(&self) -> Vec<f64>;

    /// The same to be handed on, where there are no local blocks.
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

/// Columns that are zero but for rounding errors, so that nothing walks along them or takes them for information: the gain
/// of a joint whose axis is vertical to the last digit.
///
/// A column is dust if it is small beside the largest both as it stands and times the size of its block: next to a factor
/// of 1e-20 any other parameter's column looks like dust, though both do the same to the residuals. A block at zero has no
/// size that could tell, and is held only against columns of its own unit, where it states one.
fn dust(problem: &Problem, values: &Values, norms: &[f64]) -> Vec<usize> {
    let length = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let sizes: Vec<f64> = problem.columns().iter().map(|column| length(values.get(column.block))).collect();
    let limit = |norms: &mut dyn Iterator<Item = f64>| DUST * norms.fold(0.0, f64::max);
    let plain = limit(&mut norms.iter().copied());
    let sized = limit(&mut norms.iter().zip(&sizes).map(|(norm, size)| norm * size));
    let unit = |column: usize| {
        let Column { block, index } = problem.columns()[column];
        problem.block(block).units[index].as_str()
    };
    let of_its_unit = |column: usize| {
        let alike = |other: &usize| !unit(column).is_empty() && unit(*other) == unit(column);
        limit(&mut (0..norms.len()).filter(alike).map(|other| norms[other]))
    };
    let is_dust = |column: &usize| {
        let (norm, size) = (norms[*column], sizes[*column]);
        norm <= plain && if size > 0.0 { norm * size <= sized } else { norm <= of_its_unit(*column) }
    };
    (0..norms.len()).filter(is_dust).collect()
}

/// # Errors
/// Names the factor, where sums over all of them are not finite.
fn check_finite(problem: &Problem, values: &Values, sums: [&[f64]; 2]) -> Result<(), EvaluateError> {
    if sums.into_iter().flatten().all(|v| v.is_finite()) {
        return Ok(());
    }
    let mut rows = Rows::new(problem, values);
    for factor in 0..problem.factors().len() {
        rows.linearize(factor, true)?;
        rows.check_jacobian(factor)?;
    }
    Err(EvaluateError("the squares of the residuals' derivatives overflow: are the units right?".into()))
}

#[cfg(test)]
pub(crate) mod tests;
