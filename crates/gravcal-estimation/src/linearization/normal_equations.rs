//! Normal equations that outlive the problem's linearization.

use std::sync::Arc;

use faer::Mat;

use crate::Problem;

/// `JᵀJ` of a problem at one point, with every factor's loss and after elimination: what a solver has where it ends, and what tells
/// how well the unknowns are known there.
#[derive(Clone, Debug)]
pub struct NormalEquations {
    /// They tell which blocks are free.
    column_offsets: Arc<[usize]>,
    shared: Vec<usize>,
    /// The lower triangle over the shared columns.
    hessian: Mat<f64>,
    /// Norm of each column of J.
    norms: Vec<f64>,
}

impl NormalEquations {
    pub(crate) fn new(problem: &Problem, hessian: Mat<f64>, norms: Vec<f64>) -> Self {
        let column_offsets = Arc::clone(problem.column_offsets());
        NormalEquations { column_offsets, shared: problem.structure().shared.clone(), hessian, norms }
    }

    /// The columns that are left.
    pub(crate) fn shared(&self) -> &[usize] {
        &self.shared
    }

    /// Norm of each column of J, eliminated ones included.
    pub(crate) fn column_norms(&self) -> &[f64] {
        &self.norms
    }

    /// Whether they are over the columns of this problem: with more or other blocks fixed they are not.
    pub(crate) fn are_of(&self, problem: &Problem) -> bool {
        self.column_offsets == *problem.column_offsets() && self.shared == problem.structure().shared
    }

    /// `D⁻¹ JᵀJ D⁻¹` over some of the shared columns, with D the norms of these: the lower triangle.
    pub(crate) fn scaled(&self, columns: &[usize]) -> Mat<f64> {
        Mat::from_fn(columns.len(), columns.len(), |i, j| {
            let (a, b) = (columns[i.max(j)], columns[i.min(j)]);
            self.hessian[(a, b)] / (self.norms[self.shared[a]] * self.norms[self.shared[b]])
        })
    }
}
