//! Knowledge from elsewhere: a drawing, a maker's rating, an earlier calibration.
//!
//! ```text
//!     x = x₀ ± σ
//! ```

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

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
