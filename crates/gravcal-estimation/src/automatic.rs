//! Residuals without derivatives by hand: forward-mode automatic differentiation.
//!
//! A dual number `a + Σ_k b_k ε_k` with `ε_i ε_j = 0` carries a value and its derivatives in some directions through
//! any formula: `f(x + ε_k) = f(x) + ∂f/∂x_k ε_k`, exact to rounding (Griewank and Walther, *Evaluating Derivatives*,
//! 2nd edition, 2008, section 3.1; the numbers are num-dual's). So a residual written once as a [`Formula`] over
//! generic numbers is a [`Residual`]: [`Automatic`] evaluates it with `f64` for `r` and with dual numbers for `∂r/∂x`,
//! [`DIRECTIONS`] columns at a time.
//!
//! ```
//! use gravcal_estimation::{
//!     Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, ProblemBuilder,
//!     check_derivatives,
//! };
//!
//! /// Amplitude and rate of a decay: r = a exp(−k t) − y.
//! #[derive(Debug)]
//! struct Decay {
//!     blocks: [BlockId; 2],
//!     time: f64,
//!     reading: f64,
//! }
//!
//! impl Formula for Decay {
//!     fn blocks(&self) -> &[BlockId] {
//!         &self.blocks
//!     }
//!
//!     fn len(&self) -> usize {
//!         1
//!     }
//!
//!     fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
//!         let (amplitude, rate) = (x.scalar(0), x.scalar(1));
//!         residual[0] = amplitude * (-rate * self.time).exp() - self.reading;
//!         Ok(())
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut builder = ProblemBuilder::new();
//! let amplitude = builder.add_block(Block::scalar("amplitude", "V"), &[1.0]);
//! let rate = builder.add_block(Block::scalar("rate", "1/s"), &[0.1]);
//! for (time, reading) in [(0.0, 2.0), (1.0, 1.2), (2.0, 0.7)] {
//!     let decay = Automatic(Decay { blocks: [amplitude, rate], time, reading });
//!     check_derivatives(&decay, &[1, 1], &[1.5, 0.4], 1e-8)?;
//!     builder.add_factor(Factor::new(decay, Noise::independent(&[0.1])?));
//! }
//! let (problem, values) = builder.build()?;
//! assert!(problem.cost(&values)? > 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! A number of a formula stands left of a constant (`x * 2.0`, not `2.0 * x`): Rust lets no crate teach `f64` to
//! multiply a number it does not know.

use std::fmt::Debug;
use std::ops::Range;

use num_dual::{DualNum, DualSVec64};

use crate::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};

/// Columns of the Jacobian that one evaluation of a formula gives.
pub const DIRECTIONS: usize = 8;

type Dual = DualSVec64<DIRECTIONS>;

/// What a [`Formula`] computes with: `f64`, or a dual number made of them. Has the operators, also with an `f64` on the
/// right (`x * 2.0`, not `2.0 * x`), and the functions of `DualNum` of the crate num-dual: `exp`, `ln`, `sqrt`, `powi`, `powf`, `sin`, `cos`, `tan`,
/// `asin`, `acos`, `atan`, `atan2`, `sinh`, `cosh`, `tanh` and so on.
pub trait Number: DualNum<Primitive = f64> + Copy {}

impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

/// `r(x)` in the unit of the reading, as a function of generic numbers: prediction minus measurement.
///
/// [`Automatic`] makes it a [`Residual`]. It must be differentiable where it is evaluated; a branch on values is
/// differentiated as the branch taken.
pub trait Formula: Debug + Send + Sync + 'static {
    /// The blocks it reads, in column order.
    fn blocks(&self) -> &[BlockId];

    /// Number of rows; never zero.
    fn len(&self) -> usize;

    /// Whether there is nothing to evaluate.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes every row of `r(x)`.
    ///
    /// # Errors
    /// Where the model is not defined at `x`; a solver shortens its step then.
    fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError>;
}

/// The numbers of the blocks of one formula, in its own order.
#[derive(Clone, Copy, Debug)]
pub struct LocalNumbers<'a, N> {
    data: &'a [N],
    layout: LocalValues<'a>,
}

impl<'a, N: Number> LocalNumbers<'a, N> {
    /// Block `index` in the order of [`Formula::blocks`].
    pub fn block(&self, index: usize) -> &'a [N] {
        let start = self.layout.column(index);
        &self.data[start..start + self.layout.block(index).len()]
    }

    /// The number of block `index`, which stores one.
    pub fn scalar(&self, index: usize) -> N {
        self.data[self.layout.column(index)]
    }

    /// All numbers, block after block.
    pub fn as_slice(&self) -> &'a [N] {
        self.data
    }
}

/// A [`Formula`] as a [`Residual`].
///
/// The residual itself is always evaluated with `f64`, so that it has the same bits with and without a Jacobian.
///
/// **Cost.** One evaluation with `f64` and one with dual numbers for every [`DIRECTIONS`] columns, however few of them
/// the last one has. Beside derivatives by hand, a row of 8 columns took 2.3 times as long where it is made of three
/// exponentials (80 ns), and 15 times where it is a mere polynomial (100 ns): what counts is how many numbers are
/// multiplied, not how hard the functions are. Measured on one thread of a shared machine by
/// `cargo run --release -p gravcal-benches --bin automatic`.
///
/// A residual whose time matters implements [`Residual`] itself with its analytic Jacobian instead; its formula, if it
/// keeps one, then serves its test.
#[derive(Clone, Copy, Debug)]
pub struct Automatic<F>(pub F);

impl<F: Formula> Automatic<F> {
    /// Writes the given columns of `∂r/∂x`. `lifted` holds `x` without directions, and does so again afterwards.
    fn differentiate(
        &self,
        layout: LocalValues<'_>,
        columns: Range<usize>,
        lifted: &mut [Dual],
        jacobian: &mut RowsMut<'_>,
    ) -> Result<(), EvaluateError> {
        for (direction, number) in lifted[columns.clone()].iter_mut().enumerate() {
            *number = number.derivative(direction);
        }
        let mut residual = vec![Dual::from_re(0.0); self.0.len()];
        self.0.evaluate(LocalNumbers { data: lifted, layout }, &mut residual)?;
        for (row, number) in residual.iter().enumerate() {
            // A row without derivative part does not depend on these columns.
            if let Some(slope) = &number.eps.0 {
                jacobian.row(row)[columns.clone()].copy_from_slice(&slope.as_slice()[..columns.len()]);
            }
        }
        lifted[columns].iter_mut().for_each(|number| *number = Dual::from_re(number.re));
        Ok(())
    }
}

impl<F: Formula> Residual for Automatic<F> {
    fn blocks(&self) -> &[BlockId] {
        self.0.blocks()
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let values = x.as_slice();
        self.0.evaluate(LocalNumbers { data: values, layout: x }, residual)?;
        let Some(mut jacobian) = jacobian else { return Ok(()) };
        let mut lifted: Vec<Dual> = values.iter().map(|v| Dual::from_re(*v)).collect();
        for start in (0..values.len()).step_by(DIRECTIONS) {
            let columns = start..values.len().min(start + DIRECTIONS);
            self.differentiate(x, columns, &mut lifted, &mut jacobian)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_derivatives;

    /// Distances of a point from beacons, less what was measured: the point is one block, each beacon another.
    #[derive(Debug)]
    struct Distances(Vec<BlockId>);

    impl Formula for Distances {
        fn blocks(&self) -> &[BlockId] {
            &self.0
        }

        fn len(&self) -> usize {
            self.0.len() - 1
        }

        fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            let point = x.block(0);
            for (row, residual) in residual.iter_mut().enumerate() {
                let squares = point.iter().zip(x.block(row + 1)).map(|(p, b)| (*p - *b).powi(2));
                let square: N = squares.sum();
                if square <= 0.0 {
                    return Err(EvaluateError("on a beacon".into()));
                }
                *residual = square.sqrt() - 1.5;
            }
            Ok(())
        }
    }

    fn evaluate(
        residual: &dyn Residual,
        x: &[f64],
        with_jacobian: bool,
    ) -> Result<(Vec<f64>, Vec<f64>), EvaluateError> {
        let offsets: Vec<usize> = (0..=x.len() / 3).map(|k| 3 * k).collect();
        let (mut r, mut j) = (vec![0.0; residual.len()], vec![0.0; residual.len() * x.len()]);
        let jacobian = with_jacobian.then(|| RowsMut::new(&mut j, x.len()));
        residual.evaluate(LocalValues::new(x, &offsets), &mut r, jacobian)?;
        Ok((r, j))
    }

    /// A point and four beacons: 15 columns, so that the last of two evaluations is not full.
    fn case() -> (Automatic<Distances>, Vec<f64>) {
        (Automatic(Distances((0..5).map(BlockId).collect())), (0..15).map(|k| f64::from(k * k % 11) - 4.5).collect())
    }

    #[test]
    fn the_jacobian_is_the_analytic_one() {
        let (residual, x) = case();
        check_derivatives(&residual, &[3; 5], &x, 1e-9).unwrap();
        let (r, j) = evaluate(&residual, &x, true).unwrap();
        for row in 0..4 {
            for axis in 0..3 {
                let slope = (x[axis] - x[3 * row + 3 + axis]) / (r[row] + 1.5);
                let mut expected = [0.0; 15];
                (expected[axis], expected[3 * row + 3 + axis]) = (slope, -slope);
                for column in [axis, 3 * row + 3 + axis] {
                    assert!((j[15 * row + column] - expected[column]).abs() < 1e-15);
                }
            }
            let others = (3..15).filter(|column| column / 3 != row + 1);
            assert!(others.map(|column| j[15 * row + column]).all(|entry| entry == 0.0));
        }
    }

    #[test]
    fn the_residual_has_the_same_bits_with_and_without_a_jacobian() {
        let (residual, x) = case();
        assert_eq!(evaluate(&residual, &x, true).unwrap().0, evaluate(&residual, &x, false).unwrap().0);
    }

    #[test]
    fn a_formula_without_a_value_says_so() {
        let (residual, _) = case();
        assert_eq!(evaluate(&residual, &[0.0; 15], true), Err(EvaluateError("on a beacon".into())));
    }
}
