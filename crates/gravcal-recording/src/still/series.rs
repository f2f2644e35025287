//! One channel in a run of blocks: which of them count, and how far a part departs from the rest.

use super::mean_noise::Curve;
use crate::motion::block::Sum;
use crate::motion::median;

/// Standard deviations by which a beginning or an end departs.
pub(super) const UNSETTLED: f64 = 4.0;
/// Standard deviations by which a part in the middle departs. There are many of them, so it takes more.
const DISTURBED: f64 = 6.0;

/// The blocks of one channel in a run.
pub(super) struct Series<'a> {
    pub windows: Vec<Sum>,
    /// Samples before each block, and the sum of them less the first mean.
    total: Vec<(f64, f64)>,
    /// The same without blocks that are far from where the later half is.
    core: Vec<(f64, f64)>,
    pub outlier: Vec<bool>,
    pub measure: Measure<'a>,
}

/// What differences of means are measured by.
pub(super) struct Measure<'a> {
    pub curve: &'a Curve,
    /// How many times the variance is that of other runs; 1 at least.
    pub noisier: f64,
    /// Blocks of the recording in one block of the run.
    pub blocks: f64,
    /// Differences up to this one do not matter.
    pub tolerance: f64,
}

impl<'a> Series<'a> {
    /// `first..last`: the blocks that may be a standstill.
    pub fn new(windows: Vec<Sum>, (first, last): (usize, usize), measure: Measure<'a>) -> Self {
        let outlier = vec![false; windows.len()];
        let mut series = Series { windows, total: Vec::new(), core: Vec::new(), outlier, measure };
        series.leave_out_outliers(first, last);
        series.sum_up(first, last);
        series
    }

    /// Standard deviation of the mean of so many samples in so many blocks.
    pub fn std(&self, count: f64, blocks: f64) -> f64 {
        let Measure { curve, noisier, blocks: of_recording, .. } = self.measure;
        (noisier * curve.of(blocks * of_recording) / count).sqrt()
    }

    /// Single blocks far from the others count no more.
    fn leave_out_outliers(&mut self, first: usize, last: usize) {
        let means: Vec<f64> =
            self.windows[first..last].iter().filter(|sum| sum.count > 0.0).map(|sum| sum.mean).collect();
        if means.len() < 3 {
            return;
        }
        let middle = median(means);
        let departs = |sum: &Sum, by: f64| {
            sum.count > 0.0 && (sum.mean - middle).abs() - self.measure.tolerance > by * self.std(sum.count, 1.0)
        };
        let alone = |index: usize| {
            let beside =
                [index.checked_sub(1), Some(index + 1)].into_iter().flatten().filter(|at| (first..last).contains(at));
            beside.into_iter().all(|at| !departs(&self.windows[at], UNSETTLED))
        };
        let found: Vec<usize> =
            (first..last).filter(|index| departs(&self.windows[*index], UNSETTLED + 1.0) && alone(*index)).collect();
        found.into_iter().for_each(|index| self.outlier[index] = true);
    }

    fn sum_up(&mut self, first: usize, last: usize) {
        let says = |index: &usize| !self.outlier[*index] && self.windows[*index].count > 0.0;
        let later: Vec<f64> =
            (first + (last - first) / 2..last).filter(says).map(|index| self.windows[index].mean).collect();
        let middle = if later.is_empty() { 0.0 } else { median(later) };
        let sums = |counts: &dyn Fn(&usize) -> bool| {
            let mut total = (0.0, 0.0);
            let sum = |index: usize| {
                if counts(&index) {
                    let Sum { count, mean, .. } = self.windows[index];
                    total = (total.0 + count, total.1 + count * (mean - middle));
                }
                total
            };
            std::iter::once((0.0, 0.0)).chain((0..self.windows.len()).map(sum)).collect()
        };
        let near = |index: &usize| {
            let Sum { count, mean, .. } = self.windows[*index];
            says(index) && (mean - middle).abs() - self.measure.tolerance <= UNSETTLED * self.std(count, 1.0)
        };
        (self.total, self.core) = (sums(&says), sums(&near));
    }

    /// Samples that count in a part.
    pub fn count(&self, begin: usize, end: usize) -> f64 {
        self.total[end].0 - self.total[begin].0
    }

    /// By how many standard deviations the mean of a part differs from that of the rest, as far as that is near where the later
    /// half is; 0 where one of them says nothing.
    pub fn departure(&self, part: (usize, usize), rest: (usize, usize)) -> f64 {
        self.distance(self.sum(&self.total, &[part]), self.sum(&self.core, &[rest]))
    }

    /// Samples, their sum, and blocks of some parts.
    fn sum(&self, of: &[(f64, f64)], parts: &[(usize, usize)]) -> (f64, f64, f64) {
        parts.iter().fold((0.0, 0.0, 0.0), |(count, sum, blocks), (begin, end)| {
            (count + of[*end].0 - of[*begin].0, sum + of[*end].1 - of[*begin].1, blocks + (end - begin) as f64)
        })
    }

    fn distance(&self, here: (f64, f64, f64), there: (f64, f64, f64)) -> f64 {
        if here.0 == 0.0 || there.0 == 0.0 {
            return 0.0;
        }
        let variance = self.std(here.0, here.2).powi(2) + self.std(there.0, there.2).powi(2);
        let difference = (here.1 / here.0 - there.1 / there.0).abs() - self.measure.tolerance;
        if difference <= 0.0 { 0.0 } else { difference / variance.sqrt() }
    }

    /// The block at which the channel leaves the place where its later half is, having been there before.
    pub fn comes_back(&self, first: usize, last: usize) -> Option<usize> {
        let is_near = |index: usize| self.core[index + 1].0 > self.core[index].0;
        let all = |from: usize, count: usize, near: bool| {
            (from..from + count).all(|index| index < last && !self.outlier[index] && is_near(index) == near)
        };
        let there = (first..last).find(|index| all(*index, 3, true))?;
        let leaves = (there + 3..last).find(|index| all(*index, 2, false))?;
        (leaves + 2..last).any(|index| all(index, 2, true)).then_some(leaves)
    }

    /// A window that departs from the rest by more than [`DISTURBED`].
    pub fn disturbed(&self, begin: usize, end: usize) -> Option<(usize, usize)> {
        let lengths = powers_of_two(((end - begin) / 4).max(2)).filter(|length| *length >= 2);
        let mut windows = lengths.flat_map(|length| {
            (begin..=end - length).step_by((length / 2).max(1)).map(move |from| (from, from + length))
        });
        let all = &self.total;
        windows.find(|(from, to)| {
            let (window, rest) = (self.sum(all, &[(*from, *to)]), self.sum(all, &[(begin, *from), (*to, end)]));
            self.distance(window, rest) > DISTURBED
        })
    }

    /// The block that is farthest from all others of a part: where something disturbs it. Windows beside that depart from a mean that it moves.
    pub fn farthest(&self, begin: usize, end: usize) -> usize {
        let distance = |block: &usize| {
            let others = self.sum(&self.total, &[(begin, *block), (block + 1, end)]);
            self.distance(self.sum(&self.total, &[(*block, block + 1)]), others)
        };
        (begin..end).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(begin)
    }
}

/// 1, 2, 4, … up to the given number.
pub(super) fn powers_of_two(most: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(1), |length| Some(2 * length)).take_while(move |length| *length <= most)
}
