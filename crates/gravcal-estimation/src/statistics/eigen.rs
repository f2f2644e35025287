//! Eigenvalues of what a block of samples adds to the whole.

use faer::Mat;

use crate::EvaluateError;

/// A block whose share of the information on a direction exceeds one by less than this is all that tells it.
pub(super) const ALONE: f64 = 1e-6;

/// Eigenvalues of a symmetric matrix with their directions.
pub(super) struct Eigen {
    values: Vec<f64>,
    directions: Vec<Vec<f64>>,
}

impl Eigen {
    pub fn of(matrix: &Mat<f64>) -> Result<Eigen, EvaluateError> {
        let eigen = matrix
            .self_adjoint_eigen(faer::Side::Lower)
            .map_err(|_| EvaluateError("the curvature of a block has no eigenvalues".into()))?;
        let (vectors, values) = (eigen.U(), eigen.S());
        Ok(Eigen {
            values: values.column_vector().iter().copied().collect(),
            directions: vectors.col_iter().map(|column| column.iter().copied().collect()).collect(),
        })
    }

    pub fn pairs(&self) -> impl Iterator<Item = (f64, &Vec<f64>)> {
        self.values.iter().copied().zip(&self.directions)
    }

    /// A direction of which the block holds all the information.
    pub fn whole(&self) -> Option<&Vec<f64>> {
        self.pairs().find(|(value, _)| 1.0 - value < ALONE).map(|(_, direction)| direction)
    }
}
