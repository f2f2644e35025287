//! Batches: residuals of one type and shape, some samples of which vector instructions evaluate at once.
//!
//! A [`Residual`] knows of itself alone. A type whose samples can be evaluated together is [`Batched`] besides, and says so by
//! [`Residual::as_sample`]:
//!
//! ```text
//! fn as_sample(&self) -> Option<Sample<'_>> {
//!     Some(Sample::of(self))
//! }
//! ```

use std::any::Any;
use std::fmt::{self, Debug, Formatter};

use crate::{LocalValues, Residual};

/// Samples of a batch that are evaluated at once.
pub const LANES: usize = 4;

/// A residual some samples of which are evaluated at once.
pub trait Batched: Residual + Sized + 'static {
    /// Evaluates some samples, as [`Residual::evaluate`] does one.
    ///
    /// They read the same blocks, but for those marked as eliminated, have as many rows with the same
    /// [patterns](Residual::row_pattern), and independent noise. `x`: what each of them reads. `residual`: one entry a row; `jacobian`,
    /// where asked: rows as long as `x`, which has the local columns first, row-major, in which every entry of the patterns must be
    /// written, and all others are zero; each entry has a number for each sample.
    ///
    /// `true` promises the bits of [`Residual::evaluate`]. With `false`, what was written counts nothing, and they are evaluated one by
    /// one: so it is where that may fail, and where they have less in common than they should.
    fn evaluate_batch(
        samples: [&Self; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool;
}

/// A residual as a sample of a batch, whatever its type.
#[derive(Clone, Copy)]
pub struct Sample<'a>(&'a dyn AnySample);

impl<'a> Sample<'a> {
    /// A residual whose type is batched.
    pub fn of<R: Batched>(residual: &'a R) -> Self {
        Sample(residual)
    }
}

impl Debug for Sample<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Sample").field(&self.0).finish()
    }
}

/// As [`Batched::evaluate_batch`], of any residuals: `false` too where they are not samples of one type.
pub fn evaluate_batch(
    residuals: [&dyn Residual; LANES],
    x: [LocalValues<'_>; LANES],
    residual: &mut [[f64; LANES]],
    jacobian: Option<&mut [[f64; LANES]]>,
) -> bool {
    let [Some(a), Some(b), Some(c), Some(d)] = residuals.map(Residual::as_sample) else { return false };
    a.0.evaluate_with([a.0, b.0, c.0, d.0], x, residual, jacobian)
}

/// The one place where a type is found again that a problem, which holds residuals of any type, has forgotten.
trait AnySample: Any + Debug {
    /// `samples`: itself first.
    fn evaluate_with(
        &self,
        samples: [&dyn AnySample; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool;
}

impl<R: Batched> AnySample for R {
    fn evaluate_with(
        &self,
        samples: [&dyn AnySample; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool {
        let own = samples.map(|sample| (sample as &dyn Any).downcast_ref::<R>());
        let [Some(a), Some(b), Some(c), Some(d)] = own else { return false };
        R::evaluate_batch([a, b, c, d], x, residual, jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Line;
    use crate::{Block, BlockId, EvaluateError, Factor, Noise, Problem, ProblemBuilder, RowsMut, Values};

    /// `x − reading`, alone and with others of its type.
    #[derive(Debug)]
    struct Read {
        block: BlockId,
        reading: f64,
        /// What it adds where it is evaluated with others, so that it shows.
        mark: f64,
    }

    impl Residual for Read {
        fn blocks(&self) -> &[BlockId] {
            std::slice::from_ref(&self.block)
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
            residual[0] = x.scalar(0) - self.reading;
            jacobian.into_iter().for_each(|mut rows| rows.row(0)[0] = 1.0);
            Ok(())
        }

        fn as_sample(&self) -> Option<Sample<'_>> {
            Some(Sample::of(self))
        }
    }

    impl Batched for Read {
        fn evaluate_batch(
            samples: [&Read; LANES],
            x: [LocalValues<'_>; LANES],
            residual: &mut [[f64; LANES]],
            jacobian: Option<&mut [[f64; LANES]]>,
        ) -> bool {
            residual[0] = std::array::from_fn(|lane| x[lane].scalar(0) - samples[lane].reading + samples[lane].mark);
            jacobian.into_iter().for_each(|entries| entries[0] = [1.0; LANES]);
            samples.iter().all(|sample| sample.mark >= 0.0)
        }
    }

    /// Readings 0, 1, … of 10; `alone`: which is of a type that has no batches.
    fn problem(count: usize, mark: f64, alone: Option<usize>) -> (Problem, Values) {
        let mut builder = ProblemBuilder::new();
        let block = builder.add_block(Block::scalar("x", "m"), &[10.0]);
        for index in 0..count {
            let (reading, noise) = (index as f64, Noise::independent(&[1.0]).unwrap());
            builder.add_factor(match alone == Some(index) {
                true => Factor::new(Line::new(&[block], &[1.0], reading), noise),
                false => Factor::new(Read { block, reading, mark }, noise),
            });
        }
        builder.build().unwrap()
    }

    fn residuals((problem, values): (Problem, Values)) -> Vec<f64> {
        problem.residuals(&values).unwrap()
    }

    #[test]
    fn samples_of_one_type_are_evaluated_at_once_and_what_is_left_one_by_one() {
        assert_eq!(residuals(problem(6, 0.5, None)), [10.5, 9.5, 8.5, 7.5, 6.0, 5.0]);
    }

    #[test]
    fn a_residual_of_another_type_is_evaluated_alone_and_so_are_those_that_it_parts() {
        assert_eq!(residuals(problem(7, 0.5, Some(2))), [10.0, 9.0, 8.0, 7.5, 6.5, 5.5, 4.5]);
    }

    #[test]
    fn samples_that_refuse_are_evaluated_one_by_one() {
        assert_eq!(residuals(problem(4, -0.5, None)), [10.0, 9.0, 8.0, 7.0]);
    }
}
