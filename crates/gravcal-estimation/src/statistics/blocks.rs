//! Blocks of neighbouring samples: errors within a block may depend on each other, those of different blocks must not.

use std::ops::Range;

use super::{StatisticsError, TooFewBlocks};

/// Fewer blocks do not tell how much blocks scatter.
pub const MIN_BLOCKS: usize = 30;
/// The same where each is left out in its turn, which errs to the safe side with few blocks.
pub const MIN_BLOCKS_LEFT_OUT: usize = 12;

/// A cut of consecutive factors into blocks. Factors outside of them are no samples but knowledge (priors, known
/// lengths), whose noise is taken as stated.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleBlocks {
    blocks: Vec<Range<usize>>,
}

impl SampleBlocks {
    /// Cuts the factors `samples` into as many blocks of at least `length` as there can be, as equal as can be.
    ///
    /// # Errors
    /// Below [`MIN_BLOCKS`] blocks.
    pub fn new(samples: Range<usize>, length: usize) -> Result<Self, TooFewBlocks> {
        let all = samples.len();
        let count = all.checked_div(length).unwrap_or(0);
        if count < MIN_BLOCKS {
            return Err(TooFewBlocks { samples: all, length, needed: MIN_BLOCKS });
        }
        Ok(SampleBlocks { blocks: cut(samples, count).collect() })
    }

    /// Cuts each of some stretches of samples (one behind the other, without gaps) by itself: samples of different stretches share
    /// no block, and a stretch shorter than `length` is one. For the [jackknife](super::Uncertainty::jackknife).
    ///
    /// # Errors
    /// Below [`MIN_BLOCKS_LEFT_OUT`] blocks.
    pub fn within(stretches: &[Range<usize>], length: usize) -> Result<Self, TooFewBlocks> {
        Self::of_stretches(stretches, length, |samples| samples / length)
    }

    /// The same with blocks of about `length`: of a stretch of three halves of it and more, from two thirds to three halves. For lengths that are estimated
    /// themselves.
    ///
    /// # Errors
    /// Below [`MIN_BLOCKS_LEFT_OUT`] blocks.
    pub fn within_about(stretches: &[Range<usize>], length: usize) -> Result<Self, TooFewBlocks> {
        Self::of_stretches(stretches, length, |samples| (2 * samples + length) / (2 * length))
    }

    /// `count`: into how many blocks so many samples are cut, one at least.
    fn of_stretches(
        stretches: &[Range<usize>],
        length: usize,
        count: impl Fn(usize) -> usize,
    ) -> Result<Self, TooFewBlocks> {
        let parts = |samples: usize| if length == 0 { 1 } else { count(samples).max(1) };
        let stretches = stretches.iter().filter(|stretch| !stretch.is_empty());
        let blocks: Vec<Range<usize>> =
            stretches.clone().flat_map(|stretch| cut(stretch.clone(), parts(stretch.len()))).collect();
        if length == 0 || blocks.len() < MIN_BLOCKS_LEFT_OUT {
            let samples = stretches.map(ExactSizeIterator::len).sum();
            return Err(TooFewBlocks { samples, length, needed: MIN_BLOCKS_LEFT_OUT });
        }
        Ok(SampleBlocks { blocks })
    }

    /// Blocks that are cut already, one behind the other without gaps; empty ones are left out. For the
    /// [jackknife](super::Uncertainty::jackknife).
    ///
    /// # Errors
    /// Below [`MIN_BLOCKS_LEFT_OUT`] blocks.
    pub fn given(blocks: &[Range<usize>]) -> Result<Self, TooFewBlocks> {
        let blocks: Vec<Range<usize>> = blocks.iter().filter(|block| !block.is_empty()).cloned().collect();
        if blocks.len() < MIN_BLOCKS_LEFT_OUT {
            let samples: usize = blocks.iter().map(ExactSizeIterator::len).sum();
            let length = samples.div_ceil(blocks.len().max(1));
            return Err(TooFewBlocks { samples, length, needed: MIN_BLOCKS_LEFT_OUT });
        }
        Ok(SampleBlocks { blocks })
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.blocks.len()
    }

    /// The factors of each block.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Range<usize>> + '_ {
        self.blocks.iter().cloned()
    }

    /// # Errors
    /// Where a problem of so many factors does not have them all.
    pub(super) fn check(&self, factors: usize) -> Result<(), StatisticsError> {
        let last = self.blocks.last().map_or(0, |block| block.end);
        if last > factors { Err(StatisticsError::NoSuchSamples { last, factors }) } else { Ok(()) }
    }

    /// Those of `factors` factors that belong to no block.
    pub(super) fn outside(&self, factors: usize) -> impl Iterator<Item = usize> + use<> {
        let first = self.blocks.first().map_or(0, |block| block.start);
        let last = self.blocks.last().map_or(0, |block| block.end);
        (0..first).chain(last..factors)
    }
}

/// Samples in so many blocks, as equal as can be.
fn cut(samples: Range<usize>, count: usize) -> impl Iterator<Item = Range<usize>> {
    let start = move |block: usize| samples.start + block * samples.len() / count;
    (0..count).map(move |block| start(block)..start(block + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_in_one_block_and_no_block_is_short() {
        let blocks = SampleBlocks::new(3..320, 10).unwrap();
        assert_eq!(blocks.count(), 31);
        let all: Vec<usize> = blocks.iter().flatten().collect();
        assert_eq!(all, (3..320).collect::<Vec<_>>());
        assert!(blocks.iter().all(|block| (10..=11).contains(&block.len())));
        assert_eq!(blocks.outside(322).collect::<Vec<_>>(), [0, 1, 2, 320, 321]);
    }

    #[test]
    fn stretches_share_no_block() {
        let blocks = SampleBlocks::within(&[2..12, 12..14, 14..14, 14..45], 3).unwrap();
        let all: Vec<std::ops::Range<usize>> = blocks.iter().collect();
        assert_eq!(all[..5], [2..5, 5..8, 8..12, 12..14, 14..17]);
        assert_eq!((all.len(), blocks.outside(46).collect::<Vec<_>>()), (14, vec![0, 1, 45]));
        let refused = SampleBlocks::within(&[0..20, 20..25], 3).unwrap_err().to_string();
        assert!(refused.contains("and 12 are needed") && refused.ends_with("blocks of 1 to 2 samples"), "{refused}");
        assert!(SampleBlocks::within(std::slice::from_ref(&(0..100)), 0).is_err());
    }

    /// 49 samples in blocks of about 29 are two of 24.5, 40 are one, 14 one, and 290 ten; of none there are none.
    #[test]
    fn blocks_of_about_a_length_are_as_near_to_it_as_can_be() {
        let count = |samples: usize, length: usize| {
            let stretches: Vec<std::ops::Range<usize>> = (0..12).map(|k| k * samples..(k + 1) * samples).collect();
            SampleBlocks::within_about(&stretches, length).unwrap().count() / 12
        };
        assert_eq!([49, 43, 40, 14, 290].map(|samples| count(samples, 29)), [2, 1, 1, 1, 10]);
        assert_eq!(count(44, 29), 2, "three halves of 29 are 43.5");
        assert!(SampleBlocks::within_about(&[0..100, 100..200], 0).is_err());
    }

    #[test]
    fn samples_that_a_problem_does_not_have_are_refused() {
        let blocks = SampleBlocks::new(0..60, 2).unwrap();
        assert_eq!(blocks.check(60), Ok(()));
        let reported = blocks.check(59).unwrap_err().to_string();
        assert_eq!(reported, "the blocks of samples end with factor 60, but the problem has only 59");
    }

    #[test]
    fn too_few_blocks_are_refused_with_a_cure() {
        let reported = |samples, length| SampleBlocks::new(0..samples, length).unwrap_err().to_string();
        assert!(reported(299, 10).starts_with("299 samples in blocks of 10 are 29 blocks, and 30 are needed"));
        assert!(reported(299, 10).ends_with("blocks of 1 to 9 samples"));
        assert!(reported(20, 1).ends_with("30 samples at least"));
        assert!(SampleBlocks::new(0..100, 0).is_err());
    }
}
