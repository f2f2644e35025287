//! What a step of some values does to the residuals, by differences: what is fixed has no column in the Jacobian.

use gravcal_estimation::{EvaluateError, Values};

use crate::joint::solved::Solved;

impl Solved {
    /// What a unit of what `moves` moves does to the whitened residuals of the readings, by central differences over a step to either side. Zeros follow, up to so
    /// many rows.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub(crate) fn slope(
        &self,
        rows: usize,
        step: f64,
        moves: impl Fn(&mut Values, f64),
    ) -> Result<Vec<f64>, EvaluateError> {
        let at = |by: f64| {
            let mut values = self.estimate.values.clone();
            moves(&mut values, by);
            self.built.problem.residuals(&values)
        };
        let (ahead, behind) = (at(step)?, at(-step)?);
        let slopes = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step));
        let mut slopes: Vec<f64> = slopes.take(self.built.rows.len()).collect();
        slopes.resize(rows, 0.0);
        Ok(slopes)
    }
}
