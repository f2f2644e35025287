//! A residual whose reading is another one: `r(x) + e`.

use std::ops::Range;
use std::sync::Arc;

use crate::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Another residual with an error added.
#[derive(Debug)]
pub(super) struct Redrawn {
    /// The other one.
    pub residual: Arc<dyn Residual>,
    /// In the unit of the reading, one a row.
    pub error: Vec<f64>,
}

impl Residual for Redrawn {
    fn blocks(&self) -> &[BlockId] {
        self.residual.blocks()
    }

    fn len(&self) -> usize {
        self.residual.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        self.residual.row_pattern(row)
    }

    fn work(&self) -> usize {
        self.residual.work()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        self.residual.evaluate(x, residual, jacobian)?;
        residual.iter_mut().zip(&self.error).for_each(|(r, error)| *r += error);
        Ok(())
    }
}
