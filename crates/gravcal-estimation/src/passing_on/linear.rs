//! `R T (x − x₀) + z`: a residual that is affine in the stored numbers of some blocks.
//!
//! `T` takes a difference of stored numbers to the tangent coordinates at `x₀`: on a sphere the projection on the plane that
//! touches it there, which differs from the arc in third order.

use faer::MatRef;

use crate::{BlockId, EvaluateError, LocalValues, Problem, Residual, RowsMut, Values};

/// One row for each of the triangle.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    blocks: Vec<BlockId>,
    /// `x₀`, block after block.
    around: Vec<f64>,
    /// `R T`, row-major.
    slopes: Vec<f64>,
    /// `z`.
    offsets: Vec<f64>,
}

impl Linear {
    /// `augmented`: the triangle `[R z]` of all columns of the problem.
    pub fn new(problem: &Problem, values: &Values, augmented: MatRef<'_, f64>) -> Self {
        let columns = augmented.ncols() - 1;
        let rows = augmented.nrows().min(columns); // what is left of the residual depends on nothing
        let blocks: Vec<BlockId> = problem.block_ids().filter(|id| !problem.columns_of(*id).is_empty()).collect();
        let bases: Vec<Vec<f64>> = blocks.iter().map(|id| problem.tangent_basis(values, *id)).collect();
        let slope = |row: usize, id: &BlockId, basis: &[f64], stored: usize| {
            let own = problem.columns_of(*id);
            let basis = &basis[stored * own.len()..];
            own.zip(basis).map(|(column, along)| augmented[(row, column)] * along).sum::<f64>()
        };
        let of_row = |row: usize| {
            let blocks = blocks.iter().zip(&bases);
            blocks.flat_map(move |(id, basis)| {
                (0..problem.block(*id).len()).map(move |stored| slope(row, id, basis, stored))
            })
        };
        Linear {
            slopes: (0..rows).flat_map(of_row).collect(),
            offsets: (0..rows).map(|row| augmented[(row, columns)]).collect(),
            around: blocks.iter().flat_map(|id| values.get(*id).iter().copied()).collect(),
            blocks,
        }
    }
}

impl Residual for Linear {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.offsets.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let moved: Vec<f64> = x.as_slice().iter().zip(&self.around).map(|(x, around)| x - around).collect();
        for (row, slopes) in self.slopes.chunks_exact(moved.len()).enumerate() {
            residual[row] = self.offsets[row] + slopes.iter().zip(&moved).map(|(slope, by)| slope * by).sum::<f64>();
            if let Some(rows) = jacobian.as_mut() {
                rows.row(row).copy_from_slice(slopes);
            }
        }
        Ok(())
    }
}
