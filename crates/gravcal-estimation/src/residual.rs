//! What an author of a measurement model writes.

use std::fmt::Debug;
use std::ops::Range;

use thiserror::Error;

use crate::BlockId;
use crate::batch::Sample;

/// `r(x)` in the unit of the reading: prediction minus measurement.
///
/// Whitening is the [`Noise`](crate::Noise)'s, steps on manifolds are the linearization's: an author meets neither.
pub trait Residual: Debug + Send + Sync {
    /// The blocks it reads, in column order.
    fn blocks(&self) -> &[BlockId];

    /// Number of rows; never zero.
    fn len(&self) -> usize;

    /// Whether there is nothing to evaluate.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Local columns that one row can touch, as ascending ranges that do not meet; `None`: all. Constant, and an
    /// entry outside of it is not read. Saves work where rows touch few of the columns; who gives patterns for all rows writes
    /// every entry in them, zeros too.
    fn row_pattern(&self, _row: usize) -> Option<&[Range<usize>]> {
        None
    }

    /// How many times a model is evaluated for it: a mean over many moments takes many. Constant; threads share work by it.
    fn work(&self) -> usize {
        1
    }

    /// Writes `r(x)` and, where asked, `∂r/∂x` by the stored coordinates. The Jacobian comes in zeroed, but for
    /// the entries in the rows' [patterns](Residual::row_pattern).
    ///
    /// # Errors
    /// Where the model is not defined at `x`; a solver shortens its step then.
    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError>;

    /// Itself as a sample of a batch, if its type is [`Batched`](crate::Batched): for speed alone, the results are the same. What is
    /// around another residual is no sample of the other's batch: it has one of its own, or none.
    fn as_sample(&self) -> Option<Sample<'_>> {
        None
    }
}

/// The model has no value at the point where it was asked.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{0}")]
pub struct EvaluateError(pub String);

/// The values of the blocks of one residual, in its own order.
#[derive(Clone, Copy, Debug)]
pub struct LocalValues<'a> {
    data: &'a [f64],
    offsets: &'a [usize],
}

impl<'a> LocalValues<'a> {
    /// `data` holds the blocks one after the other, `offsets` their starts and the total length.
    #[inline]
    pub fn new(data: &'a [f64], offsets: &'a [usize]) -> Self {
        LocalValues { data, offsets }
    }

    /// Block `index` in the order of [`Residual::blocks`].
    #[inline]
    pub fn block(&self, index: usize) -> &'a [f64] {
        &self.data[self.offsets[index]..self.offsets[index + 1]]
    }

    /// The number of block `index`, which stores one.
    #[inline]
    pub fn scalar(&self, index: usize) -> f64 {
        self.data[self.offsets[index]]
    }

    /// First local column of block `index`.
    pub fn column(&self, index: usize) -> usize {
        self.offsets[index]
    }

    /// All local columns, block after block.
    #[inline]
    pub fn as_slice(&self) -> &'a [f64] {
        self.data
    }
}

/// The Jacobian of one residual: rows of the residual by its local columns, row-major.
#[derive(Debug)]
pub struct RowsMut<'a> {
    data: &'a mut [f64],
    columns: usize,
}

impl<'a> RowsMut<'a> {
    /// `data` holds rows of `columns` numbers.
    #[inline]
    pub fn new(data: &'a mut [f64], columns: usize) -> Self {
        RowsMut { data, columns }
    }

    /// One row over all local columns.
    #[inline]
    pub fn row(&mut self, row: usize) -> &mut [f64] {
        &mut self.data[row * self.columns..(row + 1) * self.columns]
    }
}
