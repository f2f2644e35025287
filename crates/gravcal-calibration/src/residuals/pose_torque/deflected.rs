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

use super::{PoseTorque, sensor_column};

/// Of a joint's sensor columns, the position offset.
const OFFSET: usize = 3;

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
        let starts = pose.model.block_starts();
        let end = starts[starts.len() - 1];
        let offsets: Vec<usize> = (0..pose.position.len()).map(|joint| sensor_column(joint) + OFFSET).collect();
        let deflections = end..end + offsets.len();
        let patterns = (0..pose.len()).map(|row| extended(pose.row_pattern(row), end, deflections.clone())).collect();
        let blocks = pose.blocks().iter().copied().chain([deflection]).collect();
        DeflectedPoseTorque { pose, blocks, starts, offsets, patterns }
    }
}

/// The pattern of a row with the columns of the deflections behind it.
fn extended(pattern: Option<&[Range<usize>]>, end: usize, deflections: Range<usize>) -> Vec<Range<usize>> {
    let mut ranges = pattern.map_or_else(|| vec![0..end], <[_]>::to_vec);
    ranges.push(deflections);
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

#[cfg(test)]
mod tests {
    use super::super::tests::loaded;
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    #[test]
    fn derivatives() {
        let (pose, mut lengths) = loaded(&[0, 2]);
        lengths.push(3);
        let residual = DeflectedPoseTorque::new(pose, ids(&lengths)[lengths.len() - 1]);
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    #[test]
    fn a_deflection_acts_like_an_offset() {
        let (pose, lengths) = loaded(&[0, 1, 2]);
        let starts = pose.model.block_starts();
        assert_eq!(starts.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>(), lengths);
        let width = starts[starts.len() - 1];
        let mut x: Vec<f64> = (0..width + 3).map(|k| 1.0 + (k as f64).sin()).collect();
        let deflected = DeflectedPoseTorque::new(pose.clone(), ids(&[3])[0]);
        let (mut with, mut without) = ([0.0; 3], [0.0; 3]);
        let deflected_starts: Vec<usize> = starts.iter().copied().chain([width + 3]).collect();
        deflected.evaluate(LocalValues::new(&x, &deflected_starts), &mut with, None).unwrap();
        for joint in 0..3 {
            x[sensor_column(joint) + OFFSET] += x[width + joint];
        }
        pose.evaluate(LocalValues::new(&x[..width], &starts), &mut without, None).unwrap();
        assert_eq!(with, without);
    }
}
