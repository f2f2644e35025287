//! Knowledge from elsewhere: a drawing, a maker's rating, an earlier calibration.
//!
//! ```text
//!     x = x₀ ± σ
//! ```

use gravcal_estimation::{Batched, BlockId, EvaluateError, LANES, LocalValues, Residual, RowsMut, Sample};

/// The expected value of a whole block, in its unit.
#[derive(Clone, Debug)]
pub struct Prior {
    block: BlockId,
    expected: Vec<f64>,
}

impl Prior {
    /// `expected`: one number for each component of the block.
    pub fn new(block: BlockId, expected: Vec<f64>) -> Self {
        Prior { block, expected }
    }
}

impl Residual for Prior {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.block)
    }

    fn len(&self) -> usize {
        self.expected.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        for (row, (value, expected)) in x.block(0).iter().zip(&self.expected).enumerate() {
            residual[row] = value - expected;
            if let Some(rows) = jacobian.as_mut() {
                rows.row(row)[row] = 1.0;
            }
        }
        Ok(())
    }

    fn as_sample(&self) -> Option<Sample<'_>> {
        Some(Sample::of(self))
    }
}

impl Batched for Prior {
    fn evaluate_batch(
        priors: [&Prior; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool {
        for (lane, (prior, x)) in priors.into_iter().zip(x).enumerate() {
            for (row, (value, expected)) in residual.iter_mut().zip(x.block(0).iter().zip(&prior.expected)) {
                row[lane] = value - expected;
            }
        }
        let rows = jacobian.into_iter().flat_map(|jacobian| jacobian.chunks_exact_mut(x[0].as_slice().len()));
        for (index, row) in rows.enumerate() {
            row[..priors[0].expected.len()].fill([0.0; LANES]);
            row[index] = [1.0; LANES];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    #[test]
    fn derivatives() {
        let residual = Prior::new(ids(&[4])[0], vec![1.0, 2.0, 3.0, 4.0]);
        check_at_random_points(&residual, &[4], &[0.0; 4]);
    }
}
