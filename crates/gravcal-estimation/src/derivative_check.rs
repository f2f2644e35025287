//! Holds a residual's analytic Jacobian against differences of its values.

use thiserror::Error;

use crate::{EvaluateError, LocalValues, Residual, RowsMut};

/// An entry of a Jacobian that disagrees with the residual's own values.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DerivativeMismatch {
    /// The residual has no value where it was asked.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
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
/// The first entry that disagrees.
pub fn check_derivatives(
    residual: &dyn Residual,
    lengths: &[usize],
    x: &[f64],
    tolerance: f64,
) -> Result<(), DerivativeMismatch> {
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
