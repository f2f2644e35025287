//! Readings of a pose whose joints are not where their sensors say: errors in variables.
//!
//! ```text
//!     y = h(θ; …),     θ_j = s_j q_j + o_j + δ_j
//! ```
//!
//! Around any residual that reads position offsets `o_j`, with one more block `δ` of this pose alone, rad (m for a
//! prismatic joint): the deflection of joints that stand still, or the noise of their position readings. `δ` needs a prior,
//! whose width says how large such errors are. Because `δ_j` enters like `o_j`, values and derivatives are those of the inner
//! residual at offsets `o + δ`. Of joints whose offset the inner residual does not read, `δ` has no effect.

use std::ops::Range;
use std::sync::Arc;

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// A residual with an error of some joints' positions.
#[derive(Clone, Debug)]
pub struct PositionError {
    inner: Arc<dyn Residual>,
    blocks: Vec<BlockId>,
    /// First stored column of each block of `inner`, and their number.
    starts: Vec<usize>,
    /// Column of each offset that has an error, if it is read.
    offsets: Vec<Option<usize>>,
    /// What each row can touch.
    patterns: Vec<Vec<Range<usize>>>,
}

impl PositionError {
    /// `length`: how many numbers store a block; `offsets`: the blocks of one number to which the components of `error` are
    /// added.
    pub fn new(
        inner: Arc<dyn Residual>,
        length: impl Fn(BlockId) -> usize,
        offsets: &[BlockId],
        error: BlockId,
    ) -> Self {
        let mut starts = vec![0];
        inner.blocks().iter().for_each(|id| starts.push(starts[starts.len() - 1] + length(*id)));
        let width = starts[starts.len() - 1];
        let place = |offset: &BlockId| inner.blocks().iter().position(|id| id == offset);
        let offsets: Vec<Option<usize>> = offsets.iter().map(|offset| Some(starts[place(offset)?])).collect();
        let errors = width..width + offsets.len();
        let patterns = (0..inner.len()).map(|row| extended(inner.row_pattern(row), width, errors.clone())).collect();
        let blocks = inner.blocks().iter().copied().chain([error]).collect();
        PositionError { inner, blocks, starts, offsets, patterns }
    }

    fn width(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }
}

/// The pattern of a row with the columns of the errors behind it.
fn extended(pattern: Option<&[Range<usize>]>, width: usize, errors: Range<usize>) -> Vec<Range<usize>> {
    let mut ranges = pattern.map_or_else(|| vec![Range { start: 0, end: width }], <[_]>::to_vec);
    ranges.push(errors);
    ranges
}

impl Residual for PositionError {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.inner.len()
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
        let (given, errors) = x.as_slice().split_at(self.width());
        let mut shifted = given.to_vec();
        for (column, error) in self.offsets.iter().zip(errors) {
            column.iter().for_each(|column| shifted[*column] += error);
        }
        let shifted = LocalValues::new(&shifted, &self.starts);
        let Some(mut rows) = jacobian else {
            return self.inner.evaluate(shifted, residual, None);
        };
        let mut inner = vec![0.0; self.len() * self.width()];
        self.inner.evaluate(shifted, residual, Some(RowsMut::new(&mut inner, self.width())))?;
        for (index, inner) in inner.chunks_exact(self.width()).enumerate() {
            let (by_given, by_errors) = rows.row(index).split_at_mut(inner.len());
            by_given.copy_from_slice(inner);
            by_errors.iter_mut().zip(&self.offsets).for_each(|(entry, column)| {
                *entry = column.map_or(0.0, |column| inner[column]);
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose_torque::tests::loaded;
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    /// The offsets of the first and the last joint have an error.
    fn with_errors() -> (PositionError, Vec<usize>) {
        let (pose, mut lengths) = loaded(&[0, 1, 2]);
        lengths.push(2);
        let ids = ids(&lengths);
        let offsets = [ids[4], ids[12]];
        let error = ids[lengths.len() - 1];
        (PositionError::new(Arc::new(pose), |id| lengths[id.index()], &offsets, error), lengths)
    }

    #[test]
    fn derivatives() {
        let (residual, lengths) = with_errors();
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    #[test]
    fn an_error_acts_like_an_offset() {
        let (residual, _) = with_errors();
        let width = residual.width();
        let mut x: Vec<f64> = (0..width + 2).map(|k| 1.0 + (k as f64).sin()).collect();
        let starts: Vec<usize> = residual.starts.iter().copied().chain([width + 2]).collect();
        let (mut with, mut without) = ([0.0; 3], [0.0; 3]);
        residual.evaluate(LocalValues::new(&x, &starts), &mut with, None).unwrap();
        (x[12], x[14]) = (x[12] + x[width], x[14] + x[width + 1]); // 3 of gravity, then all k, b, s, o
        let inner = LocalValues::new(&x[..width], &residual.starts);
        residual.inner.evaluate(inner, &mut without, None).unwrap();
        assert_eq!(with, without);
    }
}
