//! Two placements of a load a known distance apart.
//!
//! ```text
//!     ‖r¹ − r²‖ = d        (d = 2 l in the paper, section 2.3)
//! ```

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Distance in m between two placements in the frame of one link.
#[derive(Clone, Debug)]
pub struct LoadDistance {
    /// Blocks of the first placement, then of the second: the sum of its blocks is a placement's position.
    blocks: Vec<BlockId>,
    /// How many of them are the first placement's.
    first: usize,
    distance: f64,
}

impl LoadDistance {
    /// `placements`: the blocks whose sum is each position; `distance`: d, m.
    pub fn new(placements: [Vec<BlockId>; 2], distance: f64) -> Self {
        let first = placements[0].len();
        LoadDistance { blocks: placements.concat(), first, distance }
    }

    /// +1 for a block of the first placement, −1 for one of the second.
    fn sign(&self, block: usize) -> f64 {
        if block < self.first { 1.0 } else { -1.0 }
    }
}

impl Residual for LoadDistance {
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
        let blocks = 0..self.blocks.len();
        let difference: [f64; 3] =
            std::array::from_fn(|i| blocks.clone().map(|block| self.sign(block) * x.block(block)[i]).sum());
        let length = difference.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length == 0.0 {
            return Err(EvaluateError("two placements of known distance coincide".into()));
        }
        residual[0] = length - self.distance;
        if let Some(mut rows) = jacobian {
            for block in blocks {
                let column = x.column(block);
                for (i, component) in difference.iter().enumerate() {
                    rows.row(0)[column + i] = self.sign(block) * component / length;
                }
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
        let ids = ids(&[3, 3, 3]);
        let residual = LoadDistance::new([vec![ids[0]], vec![ids[1], ids[2]]], 0.402);
        check_at_random_points(&residual, &[3, 3, 3], &[9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
