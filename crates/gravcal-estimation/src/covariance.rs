//! Uncertainty of an estimate.

use crate::{BlockId, Problem, Values};

/// Covariance of the free blocks in tangent coordinates, from the whitened Jacobian at the solution.
///
/// Along directions that the data do not determine it holds nothing (zero): ask [`Spectrum`](crate::Spectrum)
/// which those are before a number is shown.
#[derive(Clone, Debug)]
pub struct Covariance {
    /// Square, row-major, in the order of the problem's columns.
    pub(crate) tangent: Vec<f64>,
    pub(crate) size: usize,
}

impl Covariance {
    /// Covariance between two columns.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.tangent[row * self.size + column]
    }

    /// Standard deviation of one column.
    pub fn std(&self, column: usize) -> f64 {
        self.at(column, column).max(0.0).sqrt()
    }

    /// Covariance of the stored coordinates of a list of blocks, row-major; zero where a block is held.
    ///
    /// It is `B Σ Bᵀ` with `B` the tangent basis of each block, so that a vector on a sphere has a singular one.
    pub fn stored(&self, problem: &Problem, values: &Values, blocks: &[BlockId]) -> Vec<f64> {
        let map = StoredMap::new(problem, values, blocks);
        let mut covariance = vec![0.0; map.rows.len() * map.rows.len()];
        for (i, a) in map.rows.iter().enumerate() {
            for (j, b) in map.rows.iter().enumerate() {
                covariance[i * map.rows.len() + j] =
                    a.iter().map(|(ca, va)| b.iter().map(|(cb, vb)| va * vb * self.at(*ca, *cb)).sum::<f64>()).sum();
            }
        }
        covariance
    }

    /// The same with every variance and covariance multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Covariance {
        Covariance { tangent: self.tangent.iter().map(|v| factor * v).collect(), size: self.size }
    }

    /// Standard deviation of the linear function `Σ coefficient · column`.
    pub fn std_of(&self, terms: &[(usize, f64)]) -> f64 {
        let variance: f64 =
            terms.iter().map(|(i, a)| terms.iter().map(|(j, b)| a * b * self.at(*i, *j)).sum::<f64>()).sum();
        variance.max(0.0).sqrt()
    }
}

/// Each stored coordinate of some blocks as a combination of columns.
struct StoredMap {
    rows: Vec<Vec<(usize, f64)>>,
}

impl StoredMap {
    fn new(problem: &Problem, values: &Values, blocks: &[BlockId]) -> Self {
        let rows = blocks
            .iter()
            .flat_map(|id| {
                let columns = problem.columns_of(*id);
                let basis = problem.tangent_basis(values, *id);
                let tangent = columns.len();
                (0..problem.block(*id).len()).map(move |stored| {
                    columns.clone().enumerate().map(|(t, column)| (column, basis[stored * tangent + t])).collect()
                })
            })
            .collect();
        StoredMap { rows }
    }
}
