//! The difference that moving a known load makes to the torque of the joint before the swept one.
//!
//! While joint i+1 sweeps, joint i reads a sinusoid of `ψ = s_{i+1} q_{i+1}`. Between two placements of the load the
//! links' part cancels, and what remains is
//!
//! ```text
//!     Δy_i = a sin ψ + c cos ψ + e                                     (paper, eqs. (18)–(22))
//!     a = k m (n_y D_x − n_x D_y),  c = k m (n_x D_x + n_y D_y),  e = k m n_z D_z
//!     n = C_iᵀ Rot_z(−θ_i) (z × g_i)
//! ```
//!
//! `a`, `c` and `e` come from sinusoids that were fitted with some gain `s_{i+1}` and move with it, to first order.
//!
//! `D = r² − r¹` has known length and lies in the axis frame of joint i+1 at coordinate zero (its offset goes into the
//! direction of D); `g_i` is gravity in the axis frame of joint i. For standard DH, `a_1 … a_3` of (21) are these with
//! `C_i = Rot_x(α_i)` and `a_3 = −e`.

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use nalgebra::Vector3;

use crate::axis_frames::{AxisFrames, Moved};

/// Blocks of a [`LoadDifference`].
#[derive(Clone, Debug)]
pub struct LoadDifferenceBlocks {
    /// g in base coordinates, m/s².
    pub gravity: BlockId,
    /// `[s, o]` of the joints up to and including the observed one.
    pub positions: Vec<[BlockId; 2]>,
    /// `s` of the swept joint.
    pub swept_gain: BlockId,
    /// `k` of the observed joint.
    pub torque_gain: BlockId,
    /// D, m.
    pub displacement: BlockId,
}

/// The differences `(a, c, e)` between the second placement's coefficients and the first's, unit of the torque reading.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredDifference {
    /// With the swept joint's gain at `gain`.
    pub coefficients: [f64; 3],
    /// Rad a reading unit.
    pub gain: f64,
    /// How the coefficients move with the gain.
    pub by_gain: [f64; 3],
}

/// Difference of the fitted sinusoids of two placements at one position of the observed joint.
#[derive(Clone, Debug)]
pub struct LoadDifference {
    frames: AxisFrames,
    blocks: Vec<BlockId>,
    mass: f64,
    /// Position readings up to the observed joint.
    position: Vec<f64>,
    measured: MeasuredDifference,
}

impl LoadDifference {
    /// `mass` in kg; `position`: readings of the joints up to and including the observed one.
    pub fn new(
        axis_rotations: &[[[f64; 3]; 3]],
        blocks: &LoadDifferenceBlocks,
        mass: f64,
        position: Vec<f64>,
        measured: MeasuredDifference,
    ) -> Self {
        let mut order = vec![blocks.gravity];
        order.extend(blocks.positions.iter().flatten());
        order.extend([blocks.swept_gain, blocks.torque_gain, blocks.displacement]);
        LoadDifference { frames: AxisFrames::new(axis_rotations), blocks: order, mass, position, measured }
    }

    /// `n`, with derivatives by gravity and by the coordinates up to the observed joint's.
    fn lever(&self, x: LocalValues<'_>) -> Moved {
        let observed = self.position.len() - 1;
        let coordinate = |l: usize| x.scalar(1 + 2 * l) * self.position[l] + x.scalar(2 + 2 * l);
        let before: Vec<f64> = (0..observed).map(coordinate).collect();
        let mut lever = self.frames.gravity(x.block(0), &before);
        lever.cross_z();
        lever.step(coordinate(observed), self.frames.to_next(observed));
        lever
    }
}

/// `(a, c, e) / (k m)`, bilinear in the lever n and the displacement D.
fn pattern(n: &Vector3<f64>, d: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(n.y * d.x - n.x * d.y, n.x * d.x + n.y * d.y, n.z * d.z)
}

impl Residual for LoadDifference {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        3
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let joints = self.position.len();
        let MeasuredDifference { coefficients, gain: fitted_with, by_gain } = self.measured;
        let off = x.scalar(1 + 2 * joints) - fitted_with;
        let gain = x.scalar(2 + 2 * joints);
        let displacement = Vector3::from_column_slice(x.block(3 + 2 * joints));
        let lever = self.lever(x);
        let unit = pattern(&lever.value, &displacement);
        for row in 0..3 {
            residual[row] = gain * self.mass * unit[row] - coefficients[row] - by_gain[row] * off;
        }
        let Some(mut rows) = jacobian else { return Ok(()) };
        let by_lever = |d: &Vector3<f64>| gain * self.mass * pattern(d, &displacement);
        let mut columns: Vec<Vector3<f64>> = lever.derivatives[..3].iter().map(by_lever).collect();
        for (derivative, q) in lever.derivatives[3..].iter().zip(&self.position) {
            let by_coordinate = by_lever(derivative);
            columns.extend([by_coordinate * *q, by_coordinate]);
        }
        columns.extend([-Vector3::from(by_gain), self.mass * unit]);
        columns
            .extend([Vector3::x(), Vector3::y(), Vector3::z()].map(|e| gain * self.mass * pattern(&lever.value, &e)));
        for row in 0..3 {
            rows.row(row).iter_mut().zip(&columns).for_each(|(entry, column)| *entry = column[row]);
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
        let (s, c) = 0.9_f64.sin_cos();
        let twist = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]];
        let lengths = [3, 1, 1, 1, 1, 1, 1, 3];
        let ids = ids(&lengths);
        let blocks = LoadDifferenceBlocks {
            gravity: ids[0],
            positions: vec![[ids[1], ids[2]], [ids[3], ids[4]]],
            swept_gain: ids[5],
            torque_gain: ids[6],
            displacement: ids[7],
        };
        let measured = MeasuredDifference { coefficients: [1.0, 2.0, 3.0], gain: 0.9, by_gain: [0.3, -0.5, 0.7] };
        let residual = LoadDifference::new(&[twist; 4], &blocks, 1.7, vec![0.3, -0.8], measured);
        check_at_random_points(&residual, &lengths, &[0.5; 12]);
    }
}
