//! Normal equations that outlive the problem's linearization.

use faer::Mat;

use crate::{Column, Problem};

/// `JᵀJ` of a problem without local blocks at one point, with every factor's loss: what a solver has where it ends, and what tells how
/// well the unknowns are known there.
#[derive(Clone, Debug)]
pub struct NormalEquations {
    columns: Vec<Column>,
    /// The lower triangle.
    hessian: Mat<f64>,
    /// Norm of each column of J.
    norms: Vec<f64>,
}

impl NormalEquations {
    pub(crate) fn new(problem: &Problem, hessian: Mat<f64>, norms: Vec<f64>) -> Self {
        NormalEquations { columns: problem.columns().to_vec(), hessian, norms }
    }

    /// Norm of each column of J.
    pub(crate) fn column_norms(&self) -> &[f64] {
        &self.norms
    }

    /// Whether they are over the columns of this problem: with more or other blocks held they are not.
    pub(crate) fn are_of(&self, problem: &Problem) -> bool {
        self.columns == problem.columns()
    }

    /// `D⁻¹ JᵀJ D⁻¹` over some columns, with D the norms of these: the lower triangle.
    pub(crate) fn scaled(&self, columns: &[usize]) -> Mat<f64> {
        Mat::from_fn(columns.len(), columns.len(), |i, j| {
            let (a, b) = (columns[i.max(j)], columns[i.min(j)]);
            self.hessian[(a, b)] / (self.norms[a] * self.norms[b])
        })
    }
}
