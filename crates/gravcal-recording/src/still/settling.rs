//! What readings still settle while the arm is taken to stand, seen over all standstills together.
//!
//! Each standstill is cut off where its own noise hides what is left of settling. What is hidden there is no noise: it has the same sign after each stop,
//! or that of the last motion, and adds up in a bias, or passes for friction. So each reading's course, by share `x` of the time that was kept and of that
//! since the last motion, less its mean, is averaged over all standstills, as it is and with the sign of its joint's last motion, and
//!
//! ```text
//!     y(x) = A e^(−x/T) + c
//! ```
//!
//! is fitted to it from some `x` on. The means of standstills then hold `A` times the mean of `e^(−x/T)` over what was kept. What was kept tells `A`; the whole course
//! tells `T`, where what was kept shows settling with that `T`, too. How long it lasts beyond is not seen: `T` is ten times the whole course at most.
//! How well `A` is known tells its scatter from standstill to standstill, so that noise which is correlated within each is not taken for settling.

use super::run::Run;
use crate::motion::block::Block;

/// Parts of the course.
const PARTS: usize = 16;
/// Parts from which on the course is fitted: what settles fast at first may go on slowly.
const FROM: [usize; 4] = [0, 2, 4, 7];
/// Shortest and longest `T`, in the course, and how many between them. What was kept tells little of a long one.
const SHORTEST: f64 = 0.05;
const LONGEST: f64 = 10.0;
const LONGEST_KEPT: f64 = 2.0;
const TIMES: usize = 24;
/// A `T` that is a shorter part of the course that was kept has ended there but for a twentieth.
const ENDS: f64 = 1.0 / 3.0;
/// Fewer parts tell no course, and of fewer standstills noise alone looks like one more often than once in a thousand times.
const LEAST_PARTS: usize = 4;
const LEAST_STANDSTILLS: f64 = 15.0;
/// Square of what settles, in its standard deviations, where there is some: five of them, for so many that are tried.
const SEEN: f64 = 25.0;

/// What is left of settling in the means over standstills; nothing where none is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settling {
    /// The same after each stop.
    pub common: Option<RemainingSettling>,
    /// To be taken with the sign of the joint's last motion.
    pub by_direction: Option<RemainingSettling>,
}

/// Some of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemainingSettling {
    /// Unit of the reading.
    pub size: f64,
    /// Whether standstills last long enough to see its end.
    pub ends: bool,
}

/// Courses of one channel, averaged.
#[derive(Clone, Debug, Default)]
pub(super) struct Courses {
    common: BothCourses,
    by_direction: BothCourses,
}

/// Over what was kept of standstills, and since the last motion.
#[derive(Clone, Debug, Default)]
struct BothCourses {
    kept: Course,
    whole: Course,
}

/// The mean course over standstills.
#[derive(Clone, Debug, Default)]
struct Course {
    parts: [Scatter; PARTS],
    /// Of two parts, in how many standstills both say something, and the sum of their products over these.
    pairs: [[(f64, f64); PARTS]; PARTS],
    /// Share of the course from which on it counts as standing, mean over the standstills.
    kept_from: Scatter,
}

/// Mean and squares of some numbers.
#[derive(Clone, Copy, Debug, Default)]
struct Scatter {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Scatter {
    fn take(&mut self, value: f64) {
        self.count += 1.0;
        let step = value - self.mean;
        self.mean += step / self.count;
        self.squares += step * (value - self.mean);
    }

    /// Of the mean.
    fn variance(&self) -> f64 {
        self.squares / (self.count - 1.0).max(1.0) / self.count
    }
}

impl Courses {
    /// Takes a standstill: the blocks of a run that count, and the side from which the joint of the channel came.
    pub fn take(&mut self, channel: usize, run: &Run, kept: &std::ops::Range<usize>, side: Option<f64>) {
        if run.interrupted[0] {
            return;
        }
        let (begin, until) = (run.blocks[kept.start].from, run.blocks[kept.end - 1].until);
        let blocks = &run.blocks[..kept.end];
        for (is_whole, from) in [(false, begin), (true, run.moved_until)] {
            let Some(course) = relative(channel, blocks, [from, until]) else { continue };
            let kept_from = ((begin - from) / (until - from)).clamp(0.0, 1.0);
            let take = |courses: &mut BothCourses, sign: f64| {
                let own = if is_whole { &mut courses.whole } else { &mut courses.kept };
                own.take(&course, kept_from, sign);
            };
            take(&mut self.common, 1.0);
            if let Some(sign) = side.filter(|side| *side != 0.0) {
                take(&mut self.by_direction, sign);
            }
        }
    }

    pub fn settling(&self) -> Settling {
        Settling { common: self.common.left(), by_direction: self.by_direction.left() }
    }
}

/// A channel's means over parts of a time, less that over all of it; nothing where it says nothing there.
fn relative(channel: usize, blocks: &[Block], [from, until]: [f64; 2]) -> Option<[Option<f64>; PARTS]> {
    let mut sums = [(0.0, 0.0); PARTS];
    for block in blocks {
        let (x, sum) = ((0.5 * (block.from + block.until) - from) / (until - from), block.sums[channel]);
        if (0.0..1.0).contains(&x) && sum.count > 0.0 {
            let (count, total) = &mut sums[(PARTS as f64 * x) as usize];
            *count += sum.count;
            *total += sum.count * sum.mean;
        }
    }
    let (count, total) = sums.iter().fold((0.0, 0.0), |all, own| (all.0 + own.0, all.1 + own.1));
    let level = (count > 0.0).then(|| total / count)?;
    Some(sums.map(|(count, total)| (count > 0.0).then(|| total / count - level)))
}

impl BothCourses {
    /// What is left, as it is seen in what was kept. How long it lasts the whole course tells better; but what was kept must show it with that, too.
    fn left(&self) -> Option<RemainingSettling> {
        let of_kept = self.kept.best(times(LONGEST_KEPT))?;
        let in_kept = |whole: Fit| whole.time / (1.0 - self.whole.kept_from.mean).max(1.0 / PARTS as f64);
        let longer = self.whole.best(times(LONGEST)).and_then(|whole| self.kept.best(std::iter::once(in_kept(whole))));
        let longer = longer.filter(|longer| longer.left / of_kept.left > 1.0);
        let Fit { time, left, .. } = longer.unwrap_or(of_kept);
        Some(RemainingSettling { size: left, ends: time < ENDS })
    }
}

/// A course that settles in `T`, in the whole of it.
#[derive(Clone, Copy, Debug)]
struct Fit {
    time: f64,
    /// By how much χ² falls with it, were parts independent: which course fits best.
    explained: f64,
    /// The square of what settles, in standard deviations as it scatters: whether there is any.
    gain: f64,
    /// What is left of it in the mean over the course, unit of the reading.
    left: f64,
}

/// From [`SHORTEST`] on, by even ratios.
fn times(longest: f64) -> impl Iterator<Item = f64> + Clone {
    let step = (longest / SHORTEST).powf(1.0 / (TIMES - 1) as f64);
    (0..TIMES).map(move |place| SHORTEST * step.powi(place as i32))
}

impl Course {
    fn take(&mut self, course: &[Option<f64>; PARTS], kept_from: f64, sign: f64) {
        self.kept_from.take(kept_from);
        for (part, value) in self.parts.iter_mut().zip(course) {
            value.iter().for_each(|value| part.take(sign * value));
        }
        for (pairs, value) in self.pairs.iter_mut().zip(course) {
            for ((count, sum), other) in pairs.iter_mut().zip(course) {
                let Some(product) = value.zip(*other).map(|(value, other)| value * other) else { continue };
                *count += 1.0;
                *sum += product;
            }
        }
    }

    /// Of the means of two parts, as they vary from standstill to standstill.
    fn covariance(&self, a: usize, b: usize) -> f64 {
        let (own, other, (both, sum)) = (&self.parts[a], &self.parts[b], self.pairs[a][b]);
        let of_both = (sum - both * own.mean * other.mean) / (both - 1.0).max(1.0);
        of_both * both / (own.count * other.count)
    }

    /// What explains the course best, of these times, from any part on; nothing where none is seen.
    fn best(&self, times: impl Iterator<Item = f64> + Clone) -> Option<Fit> {
        let fits = FROM.into_iter().flat_map(|from| times.clone().filter_map(move |time| self.fit(from, time)));
        fits.max_by(|a, b| a.explained.total_cmp(&b.explained)).filter(|best| best.gain > SEEN)
    }

    /// What settles in this time to a level of its own, fitted from this part on; nothing where too little is known of the course.
    fn fit(&self, from: usize, time: f64) -> Option<Fit> {
        let decay = |x: f64| (-x / time).exp();
        let parts = self.parts.iter().enumerate().skip(from);
        // Of a slow recorder a sample falls into few parts only.
        let told = parts.filter(|(_, own)| own.count >= LEAST_STANDSTILLS && own.variance() > 0.0);
        let told: Vec<(usize, f64, f64)> =
            told.map(|(part, own)| (part, decay(middle(part)), 1.0 / own.variance())).collect();
        if told.len() < LEAST_PARTS {
            return None;
        }
        let all: f64 = told.iter().map(|(.., weight)| weight).sum();
        let level = told.iter().map(|(_, shape, weight)| weight * shape).sum::<f64>() / all;
        let square: f64 = told.iter().map(|(_, shape, weight)| weight * (shape - level).powi(2)).sum();
        if square <= 0.0 {
            return None;
        }
        // `A` is a sum over the means of parts.
        let shares: Vec<(usize, f64)> =
            told.iter().map(|(part, shape, weight)| (*part, weight * (shape - level) / square)).collect();
        let size: f64 = shares.iter().map(|(part, share)| share * self.parts[*part].mean).sum();
        let with = |(part, share): &(usize, f64)| -> f64 {
            shares.iter().map(|(other, of_other)| share * of_other * self.covariance(*part, *other)).sum()
        };
        let variance: f64 = shares.iter().map(with).sum();
        let mean = time * (1.0 - decay(1.0));
        (variance > 0.0).then(|| Fit {
            time,
            explained: size * size * square,
            gain: size * size / variance,
            left: size * mean,
        })
    }
}

/// Share of the course in the middle of a part.
fn middle(part: usize) -> f64 {
    (part as f64 + 0.5) / PARTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::block::Sum;

    /// A number between −1 and 1 that follows from another by no rule that means would show (Steele, Lea and Flood 2014, SplitMix).
    fn uniform(number: u64) -> f64 {
        let mut z = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Standstills of two seconds after a motion, of which the last so many seconds count, with a reading that settles by `size` in `time`, s, and has
    /// noise of a thousandth in each hundredth of a second, which keeps a share of itself from one to the next.
    fn settling(size: impl Fn(f64) -> f64, time: f64, (kept, keeps, seed): (f64, f64, u64)) -> Settling {
        let mut courses = Courses::default();
        for standstill in 0..60u64 {
            let side = if standstill % 3 == 0 { 1.0 } else { -1.0 };
            let mut noise = 0.0;
            let block = |number: usize| {
                let at = 0.01 * number as f64;
                let new = uniform((seed * 60 + standstill) * 400 + number as u64);
                noise =
                    if number == 0 { 1e-3 * new } else { keeps * noise + 1e-3 * (1.0 - keeps * keeps).sqrt() * new };
                let mean = 5.0 + size(side) * (-(at + 0.005) / time).exp() + noise;
                let sum = Sum { count: 10.0, mean, squares: 1e-6, ends: 0.0 };
                Block { from: at, until: at + 0.01, row: 0, sums: vec![sum] }
            };
            let blocks: Vec<Block> = (0..200).map(block).collect();
            let run = Run {
                blocks,
                doublings: 0,
                direction: vec![side],
                interrupted: [false; 2],
                moved_until: 0.0,
                left_by: None,
            };
            courses.take(0, &run, &((100.0 * (2.0 - kept)) as usize..200), Some(side));
        }
        courses.settling()
    }

    #[test]
    fn what_noise_hides_in_each_standstill_is_seen_in_all_and_told_as_it_is_in_the_means() {
        // The mean of e^(−t/T) over the kept second and a half.
        let mean = |time: f64| time * ((-0.5 / time).exp() - (-2.0 / time).exp()) / 1.5;
        for time in [0.3, 1.0, 2.0] {
            let Settling { common, by_direction } = settling(|_| 0.02, time, (1.5, 0.0, 0));
            let (left, expected) = (common.unwrap(), 0.02 * mean(time));
            assert!((left.size / expected - 1.0).abs() < 0.3, "{time}: {left:?}, {expected}");
            assert_eq!(left.ends, time < 0.5, "{time}");
            // The sides are not evenly spread.
            assert!(by_direction.is_none_or(|left| left.size.abs() < 0.6 * expected), "{by_direction:?}");
        }
    }

    #[test]
    fn what_goes_with_the_side_is_told_by_it_and_noise_is_nothing() {
        let Settling { by_direction, .. } = settling(|side| 0.02 * side, 0.3, (1.5, 0.0, 0));
        assert!(by_direction.is_some_and(|left| left.size > 0.0 && left.ends), "{by_direction:?}");
        assert_eq!(settling(|_| 0.0, 0.3, (1.5, 0.0, 0)), Settling::default());
    }

    /// Noise that lasts for a second bends each standstill, each in its own way.
    #[test]
    fn noise_that_is_correlated_within_standstills_is_nothing() {
        for seed in 0..100 {
            assert_eq!(settling(|_| 0.0, 0.3, (1.5, 0.99, seed)), Settling::default(), "{seed}");
        }
    }

    /// The variance of the mean of what settles is that of the standstills' own, each fitted by itself.
    #[test]
    fn what_settles_is_as_uncertain_as_it_scatters() {
        let shape = |part: usize| (-middle(part) / 0.4).exp();
        let mut course = Course::default();
        let mut sizes = Vec::new();
        for standstill in 0..40u64 {
            let trend = uniform(standstill);
            let own: [Option<f64>; PARTS] = std::array::from_fn(|part| {
                Some(trend * middle(part) + 0.2 * uniform(1000 + 16 * standstill + part as u64))
            });
            course.take(&own, 0.0, 1.0);
            sizes.push(own);
        }
        // Weights of parts as the fit has them.
        let weights: Vec<f64> = course.parts.iter().map(|part| 1.0 / part.variance()).collect();
        let all: f64 = weights.iter().sum();
        let centre = (0..PARTS).map(|part| weights[part] * shape(part)).sum::<f64>() / all;
        let square: f64 = (0..PARTS).map(|part| weights[part] * (shape(part) - centre).powi(2)).sum();
        let size = |own: &[Option<f64>; PARTS]| -> f64 {
            (0..PARTS).map(|part| weights[part] * (shape(part) - centre) * own[part].unwrap() / square).sum()
        };
        let sizes: Vec<f64> = sizes.iter().map(size).collect();
        let (count, mean) = (sizes.len() as f64, sizes.iter().sum::<f64>() / sizes.len() as f64);
        let variance = sizes.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / (count - 1.0) / count;
        let fit = course.fit(0, 0.4).unwrap();
        assert!((fit.gain / (mean * mean / variance) - 1.0).abs() < 1e-9, "{fit:?} {mean} {variance}");
    }
}
