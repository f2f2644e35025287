//! What some readings say, passed on to where others are read: as factors of the same blocks, of fewer rows.
//!
//! Readings that come in groups can be estimated from group by group, and every group enters once. What those before say is
//! passed on in one of two forms:
//!
//! - [`linearized`]: as a square root of the information, `‖R (x − x₀) + z‖²` (Bierman, *Factorization methods for discrete
//!   sequential estimation*, 1977). No more rows than unknowns however many readings there were, so that memory does not grow;
//!   but good near `x₀` only, along *every* direction: what was not determined yet must not be far from where it was linearized.
//! - [`condensed`]: as the numbers that the group determines. With `J = Q S` the whitened Jacobian of rank ρ, these are the ρ
//!   numbers `Qᵀ h(x)`, known as `Qᵀ y` with unit covariance. They stay functions of the unknowns. Where a direction of `x` has no
//!   effect on the group, `h` is the same all along it, and so is the span of `Q`: so nothing is lost to first order in
//!   the noise, however far that direction is moved later. What is kept to evaluate them is the model of the group.
//!
//! Both equal the problem of all readings to first order in the noise, `condensed` always, `linearized` if all that the
//! readings determine in the end is known when the first group is passed on.

mod combined;
mod linear;

use faer::{Mat, MatRef};

use crate::linearization::Orthogonal;
use crate::noise::Weights;
use crate::{EvaluateError, Factor, Loss, Noise, Problem, Values};
use combined::Combined;
use linear::Linear;

/// Singular values of a group's scaled Jacobian below this share of the largest are rounding errors. A direction taken for
/// one that is none adds a row, and is no harm.
const RANK_TOLERANCE: f64 = 1e-9;

/// All factors of a problem at one point as one factor of all its free blocks, to first order.
///
/// # Errors
/// Where they cannot be evaluated there, or where blocks are eliminated: what follows from others alone has no place in it.
pub fn linearized(problem: &Problem, values: &Values) -> Result<Factor, EvaluateError> {
    if !problem.structure().components.is_empty() {
        return Err(EvaluateError("blocks that are eliminated cannot be passed on in linear form".into()));
    }
    let linearization = Orthogonal::new(&problem.without_reference(), values)?;
    let residual = Linear::new(problem, values, linearization.augmented_triangle());
    Ok(unit_factor(residual))
}

/// Some rows of a problem, as they are.
pub fn selected(problem: &Problem, rows: &[usize]) -> Factor {
    unit_factor(Combined::selected(problem, rows))
}

/// What some rows of a problem determine, at values that are near their best; nothing where that is nothing.
///
/// # Errors
/// Where they cannot be evaluated there, or have no singular value decomposition.
pub fn condensed(problem: &Problem, rows: &[usize], values: &Values) -> Result<Option<Factor>, EvaluateError> {
    let width = problem.columns().len() + 1;
    let all = problem.augmented_jacobian(values)?;
    let own: Vec<f64> = rows.iter().flat_map(|row| all[row * width..(row + 1) * width].iter().copied()).collect();
    let range = range(MatRef::from_row_major_slice(&own, rows.len(), width).get(.., ..width - 1))?;
    Ok((range.ncols() > 0).then(|| unit_factor(Combined::new(problem, rows, range.as_ref()))))
}

/// Orthonormal basis of the span of the columns, with these scaled to one length.
fn range(jacobian: MatRef<'_, f64>) -> Result<Mat<f64>, EvaluateError> {
    let norms: Vec<f64> = jacobian.col_iter().map(|column| column.norm_l2()).collect();
    let read: Vec<usize> = (0..norms.len()).filter(|column| norms[*column] > 0.0).collect();
    let scaled = Mat::from_fn(jacobian.nrows(), read.len(), |i, j| jacobian[(i, read[j])] / norms[read[j]]);
    let svd =
        scaled.thin_svd().map_err(|_| EvaluateError("the readings have no singular value decomposition".into()))?;
    let singular_values = svd.S().column_vector();
    let count = singular_values.nrows();
    let rank = (0..count).filter(|k| singular_values[*k] > RANK_TOLERANCE * singular_values[0]).count();
    Ok(svd.U().get(.., ..rank).to_owned())
}

/// A factor of rows that are whitened already.
fn unit_factor(residual: impl crate::Residual + 'static) -> Factor {
    let noise = Noise::Independent(Weights(vec![1.0; residual.len()].into()));
    Factor { residual: std::sync::Arc::new(residual), noise, loss: Loss::None }
}

#[cfg(test)]
mod tests;
