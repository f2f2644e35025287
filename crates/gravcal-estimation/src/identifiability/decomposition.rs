//! Singular values and right singular vectors of the whitened Jacobian, columns scaled to unit length.
//!
//! They are had from an orthogonal factorization, which loses no digit. A problem without local blocks that is not small is looked at
//! through its normal equations first, which cost a third of that:
//!
//! ```text
//!     D⁻¹ JᵀJ D⁻¹ = V Σ² Vᵀ
//! ```
//!
//! They serve where every eigenvalue is either well above rounding, so that the singular value and its vector keep ten digits, or
//! as good as zero with a vector that J itself maps to zero.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side};

use super::{RANK_TOLERANCE, SHADOW_TOLERANCE};
use crate::linearization::{Normal, Orthogonal, column_scales};
use crate::local_columns::LocalColumns;
use crate::problem::Rows;
use crate::{EvaluateError, Linearization, NormalEquations, Problem, Values};

/// Eigenvalues of the scaled `JᵀJ` above this keep ten digits.
const PLAIN: f64 = 1e-6;
/// Those below this are zero but for rounding, or too small to be told from it.
const ROUNDING: f64 = 1e-12;

/// What is decomposed are the shared columns, local ones eliminated.
pub(super) struct Decomposition {
    /// Scale of every column of J, see [`Linearization::column_scales`].
    pub column_scales: Vec<f64>,
    pub local: LocalColumns,
    /// Columns of zeros, as indices among the shared ones. They are directions without information by themselves: decomposed along
    /// with the others they would mix with theirs.
    pub idle: Vec<usize>,
    /// Largest first.
    pub singular_values: Vec<f64>,
    /// Right singular vectors over all shared columns, one a row.
    pub directions: Vec<Vec<f64>>,
}

impl Decomposition {
    /// `known`: the normal equations there, if they were summed before.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn new(problem: &Problem, values: &Values, known: Option<&NormalEquations>) -> Result<Self, EvaluateError> {
        match Self::by_normal_equations(problem, values, known)? {
            Some(plain) => Ok(plain),
            None => Self::orthogonally(problem, values),
        }
    }

    fn by_normal_equations(
        problem: &Problem,
        values: &Values,
        known: Option<&NormalEquations>,
    ) -> Result<Option<Self>, EvaluateError> {
        let summed = match known.filter(|known| known.are_of(problem)) {
            Some(known) => Some(known.clone()),
            None if !problem.is_small() && problem.structure().islands.is_empty() => {
                Normal::new(problem, values)?.normal_equations()
            }
            None => None,
        };
        let Some(normal) = summed else { return Ok(None) };
        let (active, idle) = active_and_idle(problem, normal.column_norms());
        let Some((eigen, plain)) = clear_cut(&normal, &active) else { return Ok(None) };
        let value = |k: usize| eigen.S()[active.len() - 1 - k];
        let vector = |k: usize| spread(&active, problem, |j| eigen.U()[(j, active.len() - 1 - k)]);
        let decomposition = Decomposition {
            column_scales: column_scales(normal.column_norms()),
            local: LocalColumns::new(problem, std::iter::empty())?,
            idle,
            singular_values: (0..active.len()).map(|k| if k < plain { value(k).sqrt() } else { 0.0 }).collect(),
            directions: (0..active.len()).map(vector).collect(),
        };
        let none = decomposition.maps_to_zero(problem, values, plain)?;
        Ok(none.then_some(decomposition))
    }

    /// Whether J itself maps the directions from `first` on to zero.
    fn maps_to_zero(&self, problem: &Problem, values: &Values, first: usize) -> Result<bool, EvaluateError> {
        let null = &self.directions[first..];
        if null.is_empty() {
            return Ok(true);
        }
        let scaled = |direction: &Vec<f64>| direction.iter().zip(&self.column_scales).map(|(v, d)| v / d).collect();
        let steps: Vec<Vec<f64>> = null.iter().map(scaled).collect();
        let mut squares = vec![0.0; steps.len()];
        let mut rows = Rows::new(problem, values);
        let mut entries = Vec::new();
        for factor in 0..problem.factors().len() {
            rows.linearize(factor, true)?;
            for (row, plan) in problem.plans(factor).iter().enumerate() {
                entries.resize(plan.columns.len() + 1, 0.0);
                rows.gather(plan, row, &mut entries);
                for (sum, step) in squares.iter_mut().zip(&steps) {
                    let along = plan.columns.iter().zip(&entries).map(|(column, entry)| entry * step[*column]);
                    *sum += along.sum::<f64>().powi(2);
                }
            }
        }
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        Ok(squares.iter().all(|sum| sum.sqrt() <= RANK_TOLERANCE * largest))
    }

    fn orthogonally(problem: &Problem, values: &Values) -> Result<Self, EvaluateError> {
        let linearization = Orthogonal::new(problem, values)?;
        let (active, idle) = active_and_idle(problem, linearization.column_norms());
        let (triangle, norms) = (linearization.triangle(), linearization.column_norms());
        let shared = &problem.structure().shared;
        // At least as many rows as columns, so that the whole null space comes out.
        let scaled = Mat::from_fn(triangle.nrows().max(active.len()), active.len(), |i, j| {
            if i < triangle.nrows() { triangle[(i, active[j])] / norms[shared[active[j]]] } else { 0.0 }
        });
        let svd =
            scaled.thin_svd().map_err(|_| EvaluateError("the Jacobian has no singular value decomposition".into()))?;
        Ok(Decomposition {
            column_scales: linearization.column_scales(),
            local: linearization.local_columns(problem)?,
            idle,
            singular_values: (0..active.len()).map(|k| svd.S()[k]).collect(),
            directions: (0..active.len()).map(|k| spread(&active, problem, |j| svd.V()[(j, k)])).collect(),
        })
    }
}

/// Eigenvectors of the scaled normal equations over the active columns, smallest first, and how many are well above rounding, where all
/// others may be zero.
fn clear_cut(normal: &NormalEquations, active: &[usize]) -> Option<(SelfAdjointEigen<f64>, usize)> {
    let eigen = normal.scaled(active).self_adjoint_eigen(Side::Lower).ok()?;
    let null = (0..active.len()).take_while(|k| eigen.S()[*k] <= ROUNDING).count();
    (null == active.len() || eigen.S()[null] > PLAIN).then(|| (eigen, active.len() - null))
}

impl NormalEquations {
    /// Whether they show that each of these columns is determined: none takes part in a direction that may be without information.
    /// `false` shows nothing: ask a [`Spectrum`](crate::Spectrum).
    pub fn determine(&self, columns: &[usize]) -> bool {
        let active: Vec<usize> = (0..self.column_norms().len()).filter(|j| self.column_norms()[*j] > 0.0).collect();
        let Some((eigen, plain)) = clear_cut(self, &active) else { return false };
        let takes_part = |at: usize| (0..active.len() - plain).any(|k| eigen.U()[(at, k)].abs() > SHADOW_TOLERANCE);
        columns.iter().all(|column| active.binary_search(column).is_ok_and(|at| !takes_part(at)))
    }
}

/// Shared columns with some effect, and without any.
fn active_and_idle(problem: &Problem, norms: &[f64]) -> (Vec<usize>, Vec<usize>) {
    let shared = &problem.structure().shared;
    (0..shared.len()).partition(|index| norms[shared[*index]] > 0.0)
}

/// A vector over the active columns as one over all shared ones.
fn spread(active: &[usize], problem: &Problem, entry: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut vector = vec![0.0; problem.structure().shared.len()];
    active.iter().enumerate().for_each(|(j, column)| vector[*column] = entry(j));
    vector
}
