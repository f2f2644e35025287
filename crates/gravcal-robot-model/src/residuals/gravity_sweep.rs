//! One joint sweeps at several positions of the joints before it: amplitude and phase are tied by gravity.
//!
//! ```text
//!     y = C √(g_x² + g_y²) sin(θ + ξ − γ) + b,     γ = atan2(g_y, g_x)        (paper, eqs. (10)–(13), (16))
//!       = p (g_x sin θ − g_y cos θ) + q (g_x cos θ + g_y sin θ) + b
//! ```
//!
//! with `g` in the swept joint's axis frame, a function of the joints before it and of gravity in the base, and the
//! lumped moment `(p, q) = C (cos ξ, sin ξ)` in the reading's unit per m/s². `θ = s q` of the swept joint: its offset
//! goes into `ξ`. Every pose uses its own readings of the joints before, so a deflection that they see is no error.

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

use crate::axis_frames::{AxisFrames, Moved};

/// Blocks of a [`GravitySweep`].
#[derive(Clone, Debug)]
pub struct GravitySweepBlocks {
    /// g in base coordinates, m/s².
    pub gravity: BlockId,
    /// `[s, o]` of each joint before the swept one.
    pub before: Vec<[BlockId; 2]>,
    /// `s` of the swept joint.
    pub position_gain: BlockId,
    /// `b` of the swept joint.
    pub torque_bias: BlockId,
    /// `(p, q)`.
    pub moment: BlockId,
}

/// The readings of the swept joint in all sweeps that share what hangs beyond it.
#[derive(Clone, Debug)]
pub struct GravitySweep {
    frames: AxisFrames,
    blocks: Vec<BlockId>,
    swept: usize,
    /// Position readings up to the swept joint, and its torque reading.
    readings: Vec<(Vec<f64>, f64)>,
}

impl GravitySweep {
    /// `axis_rotations` as `Chain::axis_rotations` gives them; `readings`: one a pose, the positions of the joints
    /// up to and including the swept one, and its torque.
    pub fn new(axis_rotations: &[[[f64; 3]; 3]], blocks: &GravitySweepBlocks, readings: Vec<(Vec<f64>, f64)>) -> Self {
        let mut order = vec![blocks.gravity];
        order.extend(blocks.before.iter().flatten());
        order.extend([blocks.position_gain, blocks.torque_bias, blocks.moment]);
        GravitySweep { frames: AxisFrames::new(axis_rotations), blocks: order, swept: blocks.before.len(), readings }
    }

    /// Gravity in the axis frame of the swept joint, with the joints before it at these readings.
    fn gravity_beyond(&self, x: LocalValues<'_>, position: &[f64]) -> Moved {
        let coordinate = |(l, q): (usize, &f64)| x.scalar(1 + 2 * l) * q + x.scalar(2 + 2 * l);
        let coordinates: Vec<f64> = position.iter().enumerate().map(coordinate).collect();
        self.frames.gravity(x.block(0), &coordinates)
    }
}

impl Residual for GravitySweep {
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
        let own = 1 + 2 * self.swept;
        let (s, b) = (x.scalar(own), x.scalar(own + 1));
        let &[p, q] = x.block(own + 2) else { unreachable!("a lumped moment has two components") };
        let mut standing: Option<(&[f64], Moved)> = None;
        for (row, (position, y)) in self.readings.iter().enumerate() {
            // The joints before the swept one mostly stand where they stood in the pose before.
            let here = &position[..self.swept];
            let (_, gravity) = match standing.take().filter(|(there, _)| *there == here) {
                Some(same) => standing.insert(same),
                None => standing.insert((here, self.gravity_beyond(x, here))),
            };
            let (sin, cos) = (s * position[self.swept]).sin_cos();
            // Coefficients of g_x and g_y.
            let (by_x, by_y) = (p * sin + q * cos, q * sin - p * cos);
            let (g_x, g_y) = (gravity.value.x, gravity.value.y);
            residual[row] = by_x * g_x + by_y * g_y + b - y;
            let Some(rows) = jacobian.as_mut() else { continue };
            let out = rows.row(row);
            let along = |d: &nalgebra::Vector3<f64>| by_x * d.x + by_y * d.y;
            for (entry, derivative) in out.iter_mut().zip(&gravity.derivatives[..3]) {
                *entry = along(derivative);
            }
            for l in 0..self.swept {
                let by_coordinate = along(&gravity.derivatives[3 + l]);
                out[3 + 2 * l] = by_coordinate * position[l];
                out[4 + 2 * l] = by_coordinate;
            }
            let own = 3 + 2 * self.swept;
            out[own] = (g_x * (p * cos - q * sin) + g_y * (q * cos + p * sin)) * position[self.swept];
            out[own + 1] = 1.0;
            out[own + 2] = g_x * sin - g_y * cos;
            out[own + 3] = g_x * cos + g_y * sin;
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
        let rotations = [twist, twist, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
        let lengths = [3, 1, 1, 1, 1, 1, 1, 2];
        let ids = ids(&lengths);
        let blocks = GravitySweepBlocks {
            gravity: ids[0],
            before: vec![[ids[1], ids[2]], [ids[3], ids[4]]],
            position_gain: ids[5],
            torque_bias: ids[6],
            moment: ids[7],
        };
        let readings = vec![(vec![0.3, -0.5, 1.1], 2.0), (vec![-0.9, 0.2, 0.4], -1.0)];
        let residual = GravitySweep::new(&rotations, &blocks, readings);
        check_at_random_points(&residual, &lengths, &[0.5; 11]);
    }
}
