//! The torque readings of a pose whose joints are not where their sensors say: errors in variables.
//!
//! ```text
//!     y_i = k_i τ_i(θ; …) + b_i,     θ_j = s_j q_j + o_j + δ_j
//! ```
//!
//! as [`PoseTorque`], with one more block `δ` of this pose alone, rad (m for a prismatic joint): the deflection of joints
//! that stand still, or the noise of their position readings. It needs a prior, whose width says how large such errors
//! are. Because `δ_j` enters like `o_j`, values and derivatives are those of [`PoseTorque`] at offsets `o + δ`.

use std::ops::Range;

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

use super::PoseTorque;

/// The torque readings of one pose with an error of each joint's position.
#[derive(Clone, Debug)]
pub struct DeflectedPoseTorque {
    pose: PoseTorque,
    blocks: Vec<BlockId>,
    /// Starts of the blocks of `pose`, and their total length.
    starts: Vec<usize>,
    /// Column of each joint's offset.
    offsets: Vec<usize>,
    /// What each row can touch.
    patterns: Vec<Vec<Range<usize>>>,
}

impl DeflectedPoseTorque {
    /// `deflection`: a block of one number a joint.
    pub fn new(pose: PoseTorque, deflection: BlockId) -> Self {
        let starts = pose.block_starts();
        let end = starts[starts.len() - 1];
        let offsets = pose.offset_columns();
        let all = end..end + offsets.len();
        let patterns = (0..pose.len()).map(|row| joined(pose.row_pattern(row), end, all.clone())).collect();
        let blocks = pose.blocks().iter().copied().chain([deflection]).collect();
        DeflectedPoseTorque { pose, blocks, starts, offsets, patterns }
    }
}

/// The pattern of a row with the columns of the deflection behind it.
fn joined(pattern: Option<&[Range<usize>]>, end: usize, deflection: Range<usize>) -> Vec<Range<usize>> {
    let mut ranges = pattern.map_or_else(|| vec![0..end], <[_]>::to_vec);
    ranges.push(deflection);
    ranges
}

impl Residual for DeflectedPoseTorque {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.pose.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.patterns[row])
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let width = self.starts[self.starts.len() - 1];
        let (shared, deflection) = x.as_slice().split_at(width);
        let mut shifted = shared.to_vec();
        self.offsets.iter().zip(deflection).for_each(|(column, error)| shifted[*column] += error);
        let shifted = LocalValues::new(&shifted, &self.starts);
        let Some(mut rows) = jacobian else {
            return self.pose.evaluate(shifted, residual, None);
        };
        let mut inner = vec![0.0; self.len() * width];
        self.pose.evaluate(shifted, residual, Some(RowsMut::new(&mut inner, width)))?;
        for (index, inner) in inner.chunks_exact(width).enumerate() {
            let (by_shared, by_deflection) = rows.row(index).split_at_mut(width);
            by_shared.copy_from_slice(inner);
            by_deflection.iter_mut().zip(&self.offsets).for_each(|(entry, column)| *entry = inner[*column]);
        }
        Ok(())
    }
}
