//! Small problems for the tests of this crate.

use gravcal_estimation::{
    Block, BlockId, EvaluateError, Factor, LocalValues, Noise, Problem, ProblemBuilder, Residual, RowsMut, Values,
};

use crate::SolverName;

/// Residual and Jacobian (row-major over all local columns) at the numbers of all blocks.
pub type Model = fn(&[f64], &mut [f64], &mut [f64]) -> Result<(), EvaluateError>;

#[derive(Debug)]
struct Written {
    blocks: Vec<BlockId>,
    rows: usize,
    model: Model,
}

impl Residual for Written {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let columns = x.as_slice().len();
        let mut full = vec![0.0; self.rows * columns];
        (self.model)(x.as_slice(), residual, &mut full)?;
        if let Some(mut rows) = jacobian {
            full.chunks_exact(columns).enumerate().for_each(|(row, entries)| rows.row(row).copy_from_slice(entries));
        }
        Ok(())
    }
}

/// The methods that are a [`Descent`](crate::Descent).
pub const DESCENTS: [SolverName; 4] =
    [SolverName::LevenbergMarquardt, SolverName::GaussNewton, SolverName::Dogleg, SolverName::VariableProjection];

/// A problem of one factor over the given blocks, to be added to.
pub fn builder(blocks: Vec<(Block, Vec<f64>)>, rows: usize, model: Model) -> (ProblemBuilder, Vec<BlockId>) {
    let mut builder = ProblemBuilder::new();
    let blocks: Vec<BlockId> = blocks.into_iter().map(|(block, start)| builder.add_block(block, &start)).collect();
    let written = Written { blocks: blocks.clone(), rows, model };
    builder.add_factor(Factor::new(written, Noise::independent(&vec![1.0; rows]).unwrap()));
    (builder, blocks)
}

/// The same, ready.
pub fn built(blocks: Vec<(Block, Vec<f64>)>, rows: usize, model: Model) -> (Problem, Values) {
    builder(blocks, rows, model).0.build().unwrap()
}

/// A block of one number with its start.
pub fn scalar(name: &str, start: f64) -> (Block, Vec<f64>) {
    (Block::scalar(name, ""), vec![start])
}

/// The same, marked as linear.
pub fn linear(name: &str, start: f64) -> (Block, Vec<f64>) {
    (Block::scalar(name, "").linear(), vec![start])
}

/// A decay of amplitude a and rate k over a level c, and readings that it does not explain to the last digit:
/// `r_i = a exp(−k t_i) + c − y_i`. Blocks in the order k, a, c.
pub fn decay(x: &[f64], r: &mut [f64], j: &mut [f64]) -> Result<(), EvaluateError> {
    for i in 0..DECAY_ROWS {
        let t = 0.3 * i as f64;
        let shape = (-x[0] * t).exp();
        r[i] = x[1] * shape + x[2] - (3.0 * (-0.7 * t).exp() + 1.0 + 0.05 * (9.0 * t).cos());
        j[3 * i..3 * i + 3].copy_from_slice(&[-x[1] * t * shape, shape, 1.0]);
    }
    Ok(())
}

/// Rows of [`decay`].
pub const DECAY_ROWS: usize = 15;

/// [`decay`] from a start that is far, its linear blocks marked.
pub fn far_decay() -> (Problem, Values) {
    built(vec![scalar("rate", 2.0), linear("amplitude", 9.0), linear("level", -4.0)], DECAY_ROWS, decay)
}
