//! Holds a residual's analytic Jacobian against differences of its values.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use thiserror::Error;

use crate::{EvaluateError, LocalValues, Residual, RowsMut};

/// An entry of a Jacobian that disagrees with the residual's own values.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DerivativeMismatch {
    /// The residual has no value where it was asked.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// Blocks of other lengths than `x` has numbers, or of another count than the residual reads.
    #[error(
        "{blocks} blocks of {numbers} numbers in all were given, but x has {given}, and the residual reads {read} blocks"
    )]
    Lengths {
        /// How many lengths.
        blocks: usize,
        /// Their sum.
        numbers: usize,
        /// Numbers of x.
        given: usize,
        /// Blocks that the residual reads.
        read: usize,
    },
    /// The residual read or wrote what it does not have.
    #[error("the residual panicked: {0}. Does it read or write a row, a column or a block that it does not have?")]
    Panicked(String),
    /// The analytic entry is not the slope.
    #[error("∂r[{row}]/∂x[{column}] is {analytic:e}, differences give {numeric:e}")]
    Entry {
        /// Row of the residual.
        row: usize,
        /// Local column.
        column: usize,
        /// What the residual says.
        analytic: f64,
        /// What extrapolated central differences say.
        numeric: f64,
    },
    /// A slope outside of the row's pattern, where it would not be read.
    #[error("∂r[{row}]/∂x[{column}] is {numeric:e}, but the row's pattern leaves that column out")]
    Pattern {
        /// Row of the residual.
        row: usize,
        /// Local column.
        column: usize,
        /// What extrapolated central differences say.
        numeric: f64,
    },
}

/// Checks `∂r/∂x` of `residual` at `x` (blocks one after the other, of the given lengths).
///
/// The reference is Richardson's extrapolation of central differences at two steps (error of fourth order).
/// An entry passes when it agrees within `tolerance` times the largest entry of its row, or 1 where that is smaller.
///
/// Slopes outside of a row's [pattern](Residual::row_pattern) are found, too.
///
/// # Errors
/// The first entry that disagrees; lengths that do not fit `x` and the residual; a residual that panics.
pub fn check_derivatives(
    residual: &dyn Residual,
    lengths: &[usize],
    x: &[f64],
    tolerance: f64,
) -> Result<(), DerivativeMismatch> {
    let (blocks, numbers, read) = (lengths.len(), lengths.iter().sum(), residual.blocks().len());
    if numbers != x.len() || blocks != read {
        return Err(DerivativeMismatch::Lengths { blocks, numbers, given: x.len(), read });
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| compare(residual, lengths, x, tolerance)));
    outcome.unwrap_or_else(|panic| Err(DerivativeMismatch::Panicked(panic_message(&*panic))))
}

fn compare(residual: &dyn Residual, lengths: &[usize], x: &[f64], tolerance: f64) -> Result<(), DerivativeMismatch> {
    let mut offsets = vec![0];
    for length in lengths {
        offsets.push(offsets[offsets.len() - 1] + length);
    }
    let (rows, columns) = (residual.len(), x.len());
    let value = |x: &[f64]| -> Result<Vec<f64>, EvaluateError> {
        let mut r = vec![0.0; rows];
        residual.evaluate(LocalValues::new(x, &offsets), &mut r, None)?;
        Ok(r)
    };
    let mut jacobian = vec![0.0; rows * columns];
    // What an author forgets to write in a pattern holds anything.
    for (row, entries) in jacobian.chunks_exact_mut(columns.max(1)).enumerate() {
        residual
            .row_pattern(row)
            .iter()
            .flat_map(|ranges| ranges.iter())
            .for_each(|range| entries[range.clone()].fill(f64::NAN));
    }
    let mut r = vec![0.0; rows];
    residual.evaluate(LocalValues::new(x, &offsets), &mut r, Some(RowsMut::new(&mut jacobian, columns)))?;

    let mut numeric = vec![0.0; rows * columns];
    for column in 0..columns {
        let step = 1e-3 * x[column].abs().max(1.0);
        let slope = |h: f64| -> Result<Vec<f64>, EvaluateError> {
            let moved = |sign: f64| {
                let mut moved = x.to_vec();
                moved[column] += sign * h;
                value(&moved)
            };
            Ok(moved(1.0)?.iter().zip(moved(-1.0)?).map(|(p, m)| (p - m) / (2.0 * h)).collect())
        };
        for (row, (wide, narrow)) in slope(step)?.into_iter().zip(slope(0.5 * step)?).enumerate() {
            numeric[row * columns + column] = (4.0 * narrow - wide) / 3.0;
        }
    }
    for row in 0..rows {
        let entries = row * columns..(row + 1) * columns;
        let scale = numeric[entries.clone()].iter().fold(1.0_f64, |m, v| m.max(v.abs()));
        for column in 0..columns {
            let (analytic, numeric) = (jacobian[entries.start + column], numeric[entries.start + column]);
            let read =
                residual.row_pattern(row).is_none_or(|ranges| ranges.iter().any(|range| range.contains(&column)));
            if !read && numeric.abs() > tolerance * scale {
                return Err(DerivativeMismatch::Pattern { row, column, numeric });
            }
            let difference = (analytic - numeric).abs();
            if difference.is_nan() || difference > tolerance * scale {
                return Err(DerivativeMismatch::Entry { row, column, analytic, numeric });
            }
        }
    }
    Ok(())
}

/// What a panic said.
pub(crate) fn panic_message(panic: &(dyn Any + Send)) -> String {
    let message = panic.downcast_ref::<String>().cloned();
    let message = message.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
    message.unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;
    use crate::testing::Line;
    use crate::{Block, BlockId, ProblemBuilder};

    /// Reads three numbers of its block, whatever that has.
    #[derive(Debug)]
    struct Third(BlockId);

    impl Residual for Third {
        fn blocks(&self) -> &[BlockId] {
            std::slice::from_ref(&self.0)
        }

        fn len(&self) -> usize {
            1
        }

        fn evaluate(
            &self,
            x: LocalValues<'_>,
            residual: &mut [f64],
            _: Option<RowsMut<'_>>,
        ) -> Result<(), EvaluateError> {
            residual[0] = x.block(0)[2];
            Ok(())
        }
    }

    #[test]
    fn lengths_that_do_not_fit_are_reported() {
        let id = ProblemBuilder::new().add_block(Block::vector("x", "", &["a", "b"]), &[1.0, 2.0]);
        let line = Line::new(&[id], &[2.0, 3.0], 1.0);
        assert_eq!(check_derivatives(&line, &[2], &[1.0, 2.0], 1e-9), Ok(()));
        for (lengths, x) in [(&[1][..], &[1.0, 2.0][..]), (&[1, 1], &[1.0, 2.0]), (&[2], &[1.0])] {
            let reported = check_derivatives(&line, lengths, x, 1e-9).unwrap_err();
            assert!(matches!(reported, DerivativeMismatch::Lengths { read: 1, .. }), "{reported}");
        }
        let reported = check_derivatives(&Third(id), &[2], &[1.0, 2.0], 1e-9).unwrap_err().to_string();
        assert!(reported.starts_with("the residual panicked: index out of bounds"), "{reported}");
    }

    /// `x₀ + x₁`, with a pattern of both, of which one entry is left as it was.
    #[derive(Debug)]
    struct Forgetful(BlockId, Range<usize>);

    impl Residual for Forgetful {
        fn blocks(&self) -> &[BlockId] {
            std::slice::from_ref(&self.0)
        }

        fn len(&self) -> usize {
            1
        }

        fn row_pattern(&self, _row: usize) -> Option<&[Range<usize>]> {
            Some(std::slice::from_ref(&self.1))
        }

        fn evaluate(
            &self,
            x: LocalValues<'_>,
            residual: &mut [f64],
            jacobian: Option<RowsMut<'_>>,
        ) -> Result<(), EvaluateError> {
            residual[0] = x.block(0)[0] + 0.0 * x.block(0)[1];
            if let Some(mut rows) = jacobian {
                rows.row(0)[0] = 1.0;
            }
            Ok(())
        }
    }

    #[test]
    fn an_entry_of_a_pattern_that_is_not_written_is_found() {
        let id = ProblemBuilder::new().add_block(Block::vector("x", "", &["a", "b"]), &[1.0, 2.0]);
        let check = |pattern| check_derivatives(&Forgetful(id, pattern), &[2], &[1.0, 2.0], 1e-9);
        assert_eq!(check(0..1), Ok(()));
        assert!(matches!(check(0..2), Err(DerivativeMismatch::Entry { row: 0, column: 1, .. })));
    }
}
