//! From the stored columns of a block on a manifold to its tangent ones.

use crate::{Block, LANES};

/// `∂x/∂step` of a block at a point.
#[derive(Debug, Default)]
pub(crate) struct Basis {
    /// Number of rows, one a stored number.
    stored: usize,
    /// One column after the other.
    columns: Vec<f64>,
}

impl Basis {
    pub fn of(block: &Block, x: &[f64]) -> Basis {
        let mut basis = Basis::default();
        basis.load(block, x, &mut Vec::new());
        basis
    }

    /// Replaces it by that of a block at `x`; `rows` is overwritten.
    pub fn load(&mut self, block: &Block, x: &[f64], rows: &mut Vec<f64>) {
        let (stored, tangent) = (x.len(), block.manifold().tangent_dimension(x.len()));
        rows.clear();
        rows.resize(stored * tangent, 0.0);
        block.manifold().basis(x, rows);
        self.stored = stored;
        self.columns.clear();
        self.columns
            .extend((0..tangent).flat_map(|t| (0..stored).map(move |s| (s, t))).map(|(s, t)| rows[s * tangent + t]));
    }

    fn column(&self, index: usize) -> &[f64] {
        &self.columns[index * self.stored..][..self.stored]
    }

    /// What numbers over the stored columns are over tangent column `index`.
    #[inline]
    pub fn along(&self, index: usize, stored: &[f64]) -> f64 {
        stored.iter().zip(self.column(index)).map(|(v, basis)| v * basis).sum()
    }

    /// The same of batched factors.
    #[inline]
    pub fn along_lanes(&self, index: usize, stored: &[[f64; LANES]]) -> [f64; LANES] {
        // What sums begin with, so that lanes come to the same bits as numbers one by one.
        let mut sum = [-0.0; LANES];
        for (lanes, basis) in stored.iter().zip(self.column(index)) {
            sum.iter_mut().zip(lanes).for_each(|(sum, v)| *sum += v * basis);
        }
        sum
    }
}
