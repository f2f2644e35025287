//! Readings of an arm whose joints are not quite where the robot's description, or their sensors, have them.
//!
//! ```text
//!     r(x, δ) = r_0(x) + C δ
//! ```
//!
//! `r_0` is the residual of the arm as it is described; `δ` says how far joints are displaced, aside (m) or tilted (rad), or, in motion, how far they bend (rad/(N·m)), and a column of `C` what one
//! of its numbers does. `C` is a constant: who builds a problem takes it at the values from which that starts, and builds it anew at the solution until
//! that stays where it is. Torques are linear in each displacement but for its square, a thousandth of what a millimetre or a milliradian does.

use std::array;
use std::ops::Range;
use std::sync::Arc;

use gravcal_estimation::{
    Batched, BlockId, EvaluateError, LANES, LocalValues, Residual, RowsMut, Sample, evaluate_batch,
};

/// A residual with further blocks in which it is linear.
#[derive(Clone, Debug)]
pub struct Displaced {
    described: Arc<dyn Residual>,
    /// `C`, one row after another.
    columns: Vec<f64>,
    /// How many numbers `δ` has.
    numbers: usize,
    blocks: Vec<BlockId>,
    /// First stored column of each block of `described`, and their number.
    starts: Vec<usize>,
    /// What each row can touch.
    patterns: Vec<Vec<Range<usize>>>,
}

impl Displaced {
    /// `columns`: of each number of the blocks `displacements`, one after the other, what a unit of it does to each row; `length`: how many numbers
    /// store a block.
    pub fn new(
        described: Arc<dyn Residual>,
        columns: &[Vec<f64>],
        length: impl Fn(BlockId) -> usize,
        displacements: &[BlockId],
    ) -> Self {
        let mut starts = vec![0];
        described.blocks().iter().for_each(|id| starts.push(starts[starts.len() - 1] + length(*id)));
        let (width, numbers) = (starts[starts.len() - 1], columns.len());
        let pattern = |row: usize| {
            let own = described.row_pattern(row).map_or_else(|| vec![Range { start: 0, end: width }], <[_]>::to_vec);
            own.into_iter().chain(std::iter::once(width..width + numbers)).collect()
        };
        let patterns = (0..described.len()).map(pattern).collect();
        let columns = (0..described.len()).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
        let blocks = described.blocks().iter().chain(displacements).copied().collect();
        Displaced { described, columns, numbers, blocks, starts, patterns }
    }

    fn width(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// What each number does to a row.
    fn row(&self, row: usize) -> &[f64] {
        &self.columns[row * self.numbers..(row + 1) * self.numbers]
    }
}

impl Residual for Displaced {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.described.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.patterns[row])
    }

    fn work(&self) -> usize {
        self.described.work()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let (given, displacements) = x.as_slice().split_at(self.width());
        let given = LocalValues::new(given, &self.starts);
        match jacobian {
            None => self.described.evaluate(given, residual, None)?,
            Some(mut rows) => {
                let mut inner = vec![0.0; self.len() * self.width()];
                self.described.evaluate(given, residual, Some(RowsMut::new(&mut inner, self.width())))?;
                for (index, inner) in inner.chunks_exact(self.width()).enumerate() {
                    let (by_given, by_displacements) = rows.row(index).split_at_mut(inner.len());
                    by_given.copy_from_slice(inner);
                    by_displacements.copy_from_slice(self.row(index));
                }
            }
        }
        for (row, residual) in residual.iter_mut().enumerate() {
            self.row(row).iter().zip(displacements).for_each(|(by, displacement)| *residual += by * displacement);
        }
        Ok(())
    }

    fn as_sample(&self) -> Option<Sample<'_>> {
        Some(Sample::of(self))
    }
}

impl Batched for Displaced {
    fn evaluate_batch(
        all: [&Displaced; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool {
        let first = all[0];
        let alike = |other: &&Displaced| {
            other.starts == first.starts && other.numbers == first.numbers && other.len() == first.len()
        };
        if !all[1..].iter().all(alike) {
            return false;
        }
        let width = first.width();
        // What is around this one has rows as wide as all that it reads, and so has the inner one.
        let given = x.map(|x| LocalValues::new(x.as_slice(), &first.starts));
        let mut jacobian = jacobian;
        if !evaluate_batch(all.map(|own| &*own.described), given, residual, jacobian.as_deref_mut()) {
            return false;
        }
        let by = |row: usize, number: usize| array::from_fn(|lane| all[lane].columns[row * first.numbers + number]);
        for (row, residual) in residual.iter_mut().enumerate().take(first.len()) {
            for number in 0..first.numbers {
                let by: [f64; LANES] = by(row, number);
                (0..LANES).for_each(|lane| residual[lane] += by[lane] * x[lane].as_slice()[width + number]);
            }
        }
        let rows = jacobian.into_iter().flat_map(|jacobian| jacobian.chunks_exact_mut(x[0].as_slice().len()));
        for (row, slopes) in rows.enumerate().take(first.len()) {
            let slopes = slopes[width..width + first.numbers].iter_mut().enumerate();
            slopes.for_each(|(number, slope)| *slope = by(row, number));
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose_torque::tests::loaded;
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    /// Two blocks, of one and of two numbers, in which three rows are linear, by each `scale` as much; lengths of all blocks.
    fn displaced<const N: usize>(scales: [f64; N]) -> ([Displaced; N], Vec<usize>) {
        let (pose, mut lengths) = loaded(&[0, 1, 2]);
        let (pose, described): (Arc<dyn Residual>, usize) = (Arc::new(pose), lengths.len());
        lengths.extend([1, 2]);
        let ids = ids(&lengths);
        let of = |scale: f64| {
            let columns = [[1.0, 0.0, -2.0], [0.5, 0.3, 0.1], [0.0, 4.0, 3.0]];
            let columns = columns.map(|column| column.map(|by| scale * by).to_vec());
            Displaced::new(Arc::clone(&pose), &columns, |id| lengths[id.index()], &ids[described..])
        };
        let all = scales.map(of);
        (all, lengths)
    }

    #[test]
    fn derivatives() {
        let ([residual], lengths) = displaced([1.0]);
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    #[test]
    fn poses_are_evaluated_in_batch_to_the_bits_that_each_has_alone() {
        let (all, lengths) = displaced([1.0, -2.0, 0.5, 3.0]);
        let starts: Vec<usize> = (0..=lengths.len()).map(|count| lengths[..count].iter().sum()).collect();
        let width = starts[lengths.len()];
        let x: Vec<f64> = (0..width).map(|place| 1.0 + (place as f64).sin()).collect();
        let x = LocalValues::new(&x, &starts);
        let (mut residual, mut jacobian) = ([[0.0; LANES]; 3], vec![[0.0; LANES]; 3 * width]);
        let [a, b, c, d] = &all;
        assert!(Displaced::evaluate_batch([a, b, c, d], [x; LANES], &mut residual, Some(&mut jacobian)));
        for (lane, own) in all.iter().enumerate() {
            let (mut alone, mut slopes) = ([0.0; 3], vec![0.0; 3 * width]);
            own.evaluate(x, &mut alone, Some(RowsMut::new(&mut slopes, width))).unwrap();
            assert_eq!(residual.map(|row| row[lane]), alone);
            for row in 0..3 {
                for column in own.row_pattern(row).unwrap().iter().cloned().flatten() {
                    assert_eq!(jacobian[row * width + column][lane], slopes[row * width + column], "{row} {column}");
                }
            }
        }
    }
}
