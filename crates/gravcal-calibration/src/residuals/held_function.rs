//! A function that an active constraint holds where it is.
//!
//! ```text
//!     f(x) = f(x₀),     f affine
//! ```
//!
//! Judged beside the readings, with next to no uncertainty, it takes the direction across the constraint from what they
//! leave open.

use gravcal_estimation::{Affine, BlockId, EvaluateError, LocalValues, Residual, RowsMut, Values};

/// The deviation of the function from its value, in its unit.
#[derive(Clone, Debug)]
pub struct HeldFunction {
    blocks: Vec<BlockId>,
    /// Position among `blocks`, component, coefficient.
    terms: Vec<(usize, usize, f64)>,
    /// The value less the constant part.
    value: f64,
}

impl HeldFunction {
    /// Held where it is at `values`.
    pub fn new(function: &Affine, values: &Values) -> Self {
        let mut blocks: Vec<BlockId> = function.terms.iter().map(|(id, ..)| *id).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let place = |id: &BlockId| blocks.partition_point(|other| other < id);
        let terms = function.terms.iter().map(|(id, component, c)| (place(id), *component, *c)).collect();
        HeldFunction { terms, value: function.at(values) - function.constant, blocks }
    }
}

impl Residual for HeldFunction {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        residual[0] = self.terms.iter().map(|(block, i, c)| c * x.block(*block)[*i]).sum::<f64>() - self.value;
        if let Some(mut rows) = jacobian {
            self.terms.iter().for_each(|(block, i, c)| rows.row(0)[x.column(*block) + i] += c);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{Block, ProblemBuilder};

    use super::*;
    use crate::residuals::testing::check_at_random_points;

    #[test]
    fn derivatives() {
        let mut builder = ProblemBuilder::new();
        let a = builder.add_block(Block::vector("a", "", &["x", "y"]), &[1.0, 2.0]);
        let b = builder.add_block(Block::vector("b", "", &["x", "y", "z"]), &[3.0, 4.0, 5.0]);
        let function = Affine::constant(7.0).plus(b, 2, 0.5).plus(a, 1, -2.0).plus(b, 2, 1.0);
        let residual = HeldFunction::new(&function, &builder.initial());
        check_at_random_points(&residual, &[2, 3], &[0.0; 5]);
        let mut r = [1.0];
        let values = builder.initial();
        residual.evaluate(LocalValues::new(values.as_slice(), &[0, 2, 5]), &mut r, None).unwrap();
        assert_eq!(r, [0.0]);
    }
}
