//! Gravity of known norm where the norm is not exact.
//!
//! ```text
//!     (‖g‖² − G²) / (2 G) = 0 ± σ        (paper, eq. (9))
//! ```
//!
//! Near the solution it is `‖g‖ − G` in m/s², and it is smooth at `g = 0`. Where the norm is taken as exact, gravity
//! lives on the sphere and this residual is not used.

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Gravity's norm in m/s².
#[derive(Clone, Debug)]
pub struct GravityNorm {
    gravity: BlockId,
    magnitude: f64,
}

impl GravityNorm {
    /// `magnitude`: G, m/s².
    pub fn new(gravity: BlockId, magnitude: f64) -> Self {
        GravityNorm { gravity, magnitude }
    }
}

impl Residual for GravityNorm {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.gravity)
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
        let g = x.block(0);
        let squared: f64 = g.iter().map(|c| c * c).sum();
        residual[0] = (squared - self.magnitude.powi(2)) / (2.0 * self.magnitude);
        if let Some(mut rows) = jacobian {
            rows.row(0).iter_mut().zip(g).for_each(|(entry, c)| *entry = c / self.magnitude);
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
        let residual = GravityNorm::new(ids(&[3])[0], 9.8);
        check_at_random_points(&residual, &[3], &[-3.4, -5.9, -7.0]);
    }
}
