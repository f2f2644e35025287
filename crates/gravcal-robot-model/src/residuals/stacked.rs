//! All readings of one pose as one residual: the torques, then each instrument's.
//!
//! ```text
//!     r = (r_1, r_2, …)
//! ```
//!
//! One pose stays one factor, and so one sample, whatever reads it.

use std::ops::Range;
use std::sync::Arc;

use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Residuals one after the other.
#[derive(Clone, Debug)]
pub struct Stacked {
    parts: Vec<Part>,
    blocks: Vec<BlockId>,
    /// What each row can touch.
    patterns: Vec<Vec<Range<usize>>>,
}

#[derive(Clone, Debug)]
struct Part {
    residual: Arc<dyn Residual>,
    /// First column of each of its blocks among its own columns, and their number.
    starts: Vec<usize>,
    /// Column of the stack for each of its own.
    columns: Vec<usize>,
    /// Whether several of its own are one column: it names a block more than once, as sensors do that share a parameter.
    overlaps: bool,
}

impl Stacked {
    /// `length`: how many numbers store a block.
    pub fn new(residuals: Vec<Arc<dyn Residual>>, length: impl Fn(BlockId) -> usize) -> Self {
        let mut blocks: Vec<BlockId> = Vec::new();
        for id in residuals.iter().flat_map(|residual| residual.blocks()) {
            if !blocks.contains(id) {
                blocks.push(*id);
            }
        }
        let starts = starts(&blocks, &length);
        let part = |residual: Arc<dyn Residual>| {
            let first = |id: &BlockId| blocks.iter().position(|other| other == id).map_or(0, |place| starts[place]);
            let columns = residual.blocks().iter().flat_map(|id| first(id)..first(id) + length(*id)).collect();
            let overlaps = names_a_block_twice(residual.as_ref());
            Part { starts: self::starts(residual.blocks(), &length), columns, overlaps, residual }
        };
        let parts: Vec<Part> = residuals.into_iter().map(part).collect();
        let patterns = parts.iter().flat_map(|part| (0..part.residual.len()).map(|row| part.pattern(row))).collect();
        Stacked { parts, blocks, patterns }
    }
}

/// Whether a residual names one of its blocks more than once. Problems take it only in a stack, which makes one of them.
pub fn names_a_block_twice(residual: &dyn Residual) -> bool {
    let blocks = residual.blocks();
    (1..blocks.len()).any(|place| blocks[..place].contains(&blocks[place]))
}

/// First column of each block, and the number of columns.
fn starts(blocks: &[BlockId], length: impl Fn(BlockId) -> usize) -> Vec<usize> {
    let mut starts = vec![0];
    blocks.iter().for_each(|id| starts.push(starts[starts.len() - 1] + length(*id)));
    starts
}

impl Part {
    /// Columns of the stack that a row of the part can touch, as ascending ranges that do not meet.
    fn pattern(&self, row: usize) -> Vec<Range<usize>> {
        let mut columns: Vec<usize> = match self.residual.row_pattern(row) {
            None => self.columns.clone(),
            Some(own) => own.iter().flat_map(|range| self.columns[range.clone()].iter().copied()).collect(),
        };
        columns.sort_unstable();
        columns.dedup();
        let mut ranges: Vec<Range<usize>> = Vec::new();
        for column in columns {
            match ranges.last_mut() {
                Some(last) if last.end == column => last.end = column + 1,
                _ => ranges.push(column..column + 1),
            }
        }
        ranges
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut [f64],
        jacobian: Option<(&mut RowsMut<'_>, usize)>,
    ) -> Result<(), EvaluateError> {
        let own: Vec<f64> = self.columns.iter().map(|column| x[*column]).collect();
        let own = LocalValues::new(&own, &self.starts);
        let Some((rows, first)) = jacobian else {
            return self.residual.evaluate(own, residual, None);
        };
        let width = self.columns.len();
        let mut entries = vec![0.0; residual.len() * width];
        self.residual.evaluate(own, residual, Some(RowsMut::new(&mut entries, width)))?;
        for (index, entries) in entries.chunks_exact(width).enumerate() {
            let row = rows.row(first + index);
            if self.overlaps {
                self.columns.iter().for_each(|column| row[*column] = 0.0);
                self.columns.iter().zip(entries).for_each(|(column, entry)| row[*column] += *entry);
                continue;
            }
            self.columns.iter().zip(entries).for_each(|(column, entry)| row[*column] = *entry);
        }
        Ok(())
    }
}

impl Residual for Stacked {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.patterns.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.patterns[row])
    }

    fn work(&self) -> usize {
        self.parts.iter().map(|part| part.residual.work()).sum()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let mut first = 0;
        for part in &self.parts {
            let rows = part.residual.len();
            let into = jacobian.as_mut().map(|jacobian| (jacobian, first));
            part.evaluate(x.as_slice(), &mut residual[first..first + rows], into)?;
            first += rows;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose_torque::tests::loaded;
    use super::*;
    use crate::residuals::Prior;
    use crate::residuals::testing::{check_at_random_points, ids};

    #[test]
    fn a_block_that_is_named_twice_is_one() {
        /// `x² + 3 y` of two blocks.
        #[derive(Clone, Debug)]
        struct Parabola([BlockId; 2]);
        impl Residual for Parabola {
            fn blocks(&self) -> &[BlockId] {
                &self.0
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
                residual[0] = x.scalar(0) * x.scalar(0) + 3.0 * x.scalar(1);
                jacobian.into_iter().for_each(|mut rows| rows.row(0).copy_from_slice(&[2.0 * x.scalar(0), 3.0]));
                Ok(())
            }
        }
        let one = ids(&[1])[0];
        let twice = Parabola([one, one]);
        assert!(names_a_block_twice(&twice));
        let stacked = Stacked::new(vec![Arc::new(twice)], |_| 1);
        assert_eq!(stacked.blocks(), [one]);
        check_at_random_points(&stacked, &[1], &[0.5]);
    }

    #[test]
    fn parts_keep_their_rows_and_share_blocks() {
        let (pose, mut lengths) = loaded(&[0, 2]);
        lengths.push(2);
        let ids = ids(&lengths);
        let gravity = Prior::new(ids[0], vec![1.0, 2.0, 3.0]);
        let own = Prior::new(ids[lengths.len() - 1], vec![4.0, 5.0]);
        let parts: Vec<Arc<dyn Residual>> = vec![Arc::new(own), Arc::new(pose), Arc::new(gravity)];
        let stacked = Stacked::new(parts, |id| lengths[id.index()]);
        assert_eq!((stacked.len(), stacked.blocks().len()), (2 + 2 + 3, lengths.len()));
        assert_eq!(stacked.row_pattern(0), Some(std::slice::from_ref(&(0..2))));
        assert_eq!(stacked.row_pattern(6), Some(std::slice::from_ref(&(2..5))));
        let order: Vec<usize> = stacked.blocks().iter().map(|id| lengths[id.index()]).collect();
        check_at_random_points(&stacked, &order, &vec![0.5; lengths.iter().sum()]);
    }
}
