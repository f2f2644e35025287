//! One joint sweeps, the rest stand: its own torque reading is a sinusoid of its position reading.
//!
//! ```text
//!     y = K sin(s q + φ) + b = a sin(s q) + c cos(s q) + b        (paper, eqs. (7), (8))
//! ```
//!
//! with `K = k A = hypot(a, c)` in the reading's unit and `φ = o + Φ = atan2(c, a)`. The pair `(a, c)` stands for
//! `(K, φ)` because it is linear and has no symmetric solution `(−K, φ + π)`.

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Blocks of a [`Sinusoid`].
#[derive(Clone, Copy, Debug)]
pub struct SinusoidBlocks {
    /// `s`.
    pub position_gain: BlockId,
    /// `b`.
    pub torque_bias: BlockId,
    /// `(a, c)` of this sweep, in the unit of the torque reading.
    pub coefficients: BlockId,
}

/// The readings of one sweep, `(q, y)` each.
#[derive(Clone, Debug)]
pub struct Sinusoid {
    blocks: [BlockId; 3],
    readings: Vec<(f64, f64)>,
}

impl Sinusoid {
    /// `readings`: position and torque reading of the swept joint, one pair a pose.
    pub fn new(blocks: SinusoidBlocks, readings: Vec<(f64, f64)>) -> Self {
        Sinusoid { blocks: [blocks.position_gain, blocks.torque_bias, blocks.coefficients], readings }
    }
}

impl Residual for Sinusoid {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.readings.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let (s, b) = (x.scalar(0), x.scalar(1));
        let &[a, c] = x.block(2) else { unreachable!("a sweep has two coefficients") };
        for (row, (q, y)) in self.readings.iter().enumerate() {
            let (sin, cos) = (s * q).sin_cos();
            residual[row] = a * sin + c * cos + b - y;
            if let Some(rows) = jacobian.as_mut() {
                rows.row(row).copy_from_slice(&[(a * cos - c * sin) * q, 1.0, sin, cos]);
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
        let lengths = [1, 1, 2];
        let ids = ids(&lengths);
        let blocks = SinusoidBlocks { position_gain: ids[0], torque_bias: ids[1], coefficients: ids[2] };
        let residual = Sinusoid::new(blocks, vec![(-1.2, 3.0), (0.0, 2.0), (0.7, -1.0)]);
        check_at_random_points(&residual, &lengths, &[1.0, 5.0, 3.0, -2.0]);
    }
}
