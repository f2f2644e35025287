//! How many neighbouring samples share an error, from the residuals.
//!
//! **Correlation of neighbours.** A fit takes from residuals what it follows: under the stated noise their covariance is `I − H`, with H the
//! hat matrix, and neighbours are correlated though no error is. With that allowed for, and `s² = Σ e²/Σ (1 − h_ii)`, a channel's
//! correlation of neighbours and its standard deviation where there is none are
//!
//! ```text
//!     ρ = Σ (e_i e_{i+1}/s² + h_{i,i+1}) / Σ (1 − h_ii)(1 − h_{i+1,i+1})
//!     σ = √(Σ (1 − h_ii)(1 − h_{i+1,i+1}) + h²_{i,i+1}) / Σ (1 − h_ii)(1 − h_{i+1,i+1})
//! ```
//!
//! Counted are channels, and all of them together, whose ρ is larger than chance makes it; the largest of them speaks for the blocks,
//! which are of all channels.
//!
//! **Length of blocks.** Of blocks of `l` of `n` samples whose errors are autoregressive the variance of a mean comes out too small by
//! the share `2ρ/((1 − ρ²) l)`, and scatters by `√(2l/n)`. Together they are least at
//!
//! ```text
//!     l = (2ρ/(1 − ρ²))^(2/3) n^(1/3)
//! ```
//!
//! (Carlstein, *Annals of Statistics* 14, 1986, section 4).

use statrs::distribution::{ContinuousCDF, Normal};

use super::projected::Projected;
use super::{Solution, StatisticsError};

/// Probability with which errors that are not correlated pass for such.
const SIGNIFICANCE: f64 = 0.01;
/// Beyond this correlation a length says nothing.
const LARGEST: f64 = 0.98;

/// Correlation of the errors of neighbouring samples; 0 where there is none but by chance. `channels`: for each the rows of its
/// stretches of neighbouring samples.
///
/// # Errors
/// Where the problem cannot be evaluated, or so much is forgiven by a loss that no minimum is left.
pub fn neighbour_correlation(solution: &Solution<'_>, channels: &[Vec<Vec<usize>>]) -> Result<f64, StatisticsError> {
    let projected = Projected::of_shared(solution)?;
    let projected = if projected.has_eliminated() { projected } else { projected.with_unit_curvature()? };
    let rows = Rows::of(solution, &projected);
    let each: Vec<Neighbours> = channels.iter().map(|stretches| rows.neighbours(stretches)).collect();
    let all = each.iter().fold(Neighbours::default(), |sum, one| sum.plus(one));
    let quantile = |tests: usize| Normal::standard().inverse_cdf(1.0 - SIGNIFICANCE / tests.max(1) as f64);
    let (of_each, of_all) = (quantile(each.len()), quantile(1));
    let significant = each.iter().filter_map(|one| one.beyond(of_each)).chain(all.beyond(of_all));
    Ok(significant.fold(0.0, f64::max).min(LARGEST))
}

/// Samples in a block, for errors of neighbours that are so correlated.
pub fn block_length(correlation: f64, samples: usize) -> usize {
    let share = 2.0 * correlation.max(0.0) / (1.0 - correlation * correlation);
    (share.powf(2.0 / 3.0) * (samples as f64).cbrt()).ceil().max(1.0) as usize
}

/// Rows of a problem with what a fit takes from their residuals.
struct Rows<'p> {
    projected: &'p Projected<'p>,
    rows: Vec<Vec<f64>>,
    residuals: Vec<f64>,
    /// `1 − h_ii`.
    left: Vec<f64>,
}

/// Sums over neighbours.
#[derive(Clone, Copy, Default)]
struct Neighbours {
    products: f64,
    size: f64,
    variance: f64,
}

impl<'p> Rows<'p> {
    fn of(solution: &Solution<'_>, projected: &'p Projected<'p>) -> Self {
        let all = 0..solution.problem.factors().len();
        let rows = projected.weighted_rows(all.clone());
        let residuals = projected.weighted_residuals(all);
        let of_row = |(row, z): (usize, &Vec<f64>)| 1.0 - dot(z, z) - projected.common_of_eliminated(row, row);
        let left = rows.iter().enumerate().map(|row| of_row(row).max(0.0)).collect();
        Rows { projected, rows, residuals, left }
    }

    fn neighbours(&self, stretches: &[Vec<usize>]) -> Neighbours {
        let all = || stretches.iter().flatten();
        let squares: f64 = all().map(|row| self.residuals[*row].powi(2)).sum();
        let freedom: f64 = all().map(|row| self.left[*row]).sum();
        let mut sums = Neighbours::default();
        if squares <= 0.0 || freedom <= 0.0 {
            return sums;
        }
        for pair in stretches.iter().flat_map(|stretch| stretch.windows(2)) {
            let (a, b) = (pair[0], pair[1]);
            let common = dot(&self.rows[a], &self.rows[b]) + self.projected.common_of_eliminated(a, b);
            let size = self.left[a] * self.left[b];
            sums.products += self.residuals[a] * self.residuals[b] * freedom / squares + common;
            sums.size += size;
            sums.variance += size + common * common;
        }
        sums
    }
}

impl Neighbours {
    fn plus(self, other: &Neighbours) -> Neighbours {
        Neighbours {
            products: self.products + other.products,
            size: self.size + other.size,
            variance: self.variance + other.variance,
        }
    }

    /// The correlation, where it exceeds so many of its standard deviations.
    fn beyond(&self, quantile: f64) -> Option<f64> {
        (self.size > 0.0 && self.products > quantile * self.variance.sqrt()).then(|| self.products / self.size)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::statistics::{SampleBlocks, Uncertainty};
    use crate::testing::{Line, Solved, add, fit};
    use crate::{Block, BlockId, ProblemBuilder};

    /// A polynomial of so many coefficients through samples whose errors are autoregressive; the truth is zero.
    fn solved(samples: usize, coefficients: usize, correlation: f64, seed: u128) -> Solved {
        let mut random = Pcg64::new(seed, 5);
        let mut draw = move || -> f64 { StandardNormal.sample(&mut random) };
        let mut builder = ProblemBuilder::new();
        let blocks: Vec<BlockId> =
            (0..coefficients).map(|k| builder.add_block(Block::scalar(format!("c{k}"), ""), &[0.0])).collect();
        let mut error = draw();
        for k in 0..samples {
            let t = 2.0 * k as f64 / samples as f64 - 1.0;
            let slopes: Vec<f64> = (0..coefficients).map(|power| t.powi(power as i32)).collect();
            add(&mut builder, Line::new(&blocks, &slopes, error));
            error = correlation * error + (1.0 - correlation * correlation).sqrt() * draw();
        }
        fit(builder)
    }

    fn correlation(solved: &Solved, samples: usize) -> f64 {
        neighbour_correlation(&solved.solution(), &[vec![(0..samples).collect()]]).unwrap()
    }

    /// A fit of many coefficients makes residuals of neighbours go against each other; with that allowed for, white errors pass for
    /// correlated ones in about two of a hundred (one channel, and all together are the same test).
    #[test]
    fn white_errors_need_no_blocks() {
        let correlated = (0..200).filter(|seed| correlation(&solved(60, 8, 0.0, *seed), 60) > 0.0).count();
        assert!(correlated <= 9, "{correlated} of 200");
        assert_eq!(block_length(0.0, 500), 1);
    }

    #[test]
    fn correlated_errors_are_found_and_blocks_are_as_long_as_carlstein_says() {
        let found: Vec<f64> = (0..100).map(|seed| correlation(&solved(200, 4, 0.6, seed), 200)).collect();
        let mean = found.iter().sum::<f64>() / 100.0;
        assert!((mean - 0.6).abs() < 0.05, "{mean}");
        assert!(found.iter().all(|rho| *rho > 0.2));
        // (1.2/0.64)^(2/3) 200^(1/3) = 1.5206 · 5.8480
        assert_eq!(block_length(0.6, 200), 9);
        assert!(block_length(LARGEST, 1000) > 100);
    }

    #[test]
    fn one_channel_among_many_is_enough() {
        let solved = solved(240, 3, 0.0, 1);
        let thirds: Vec<Vec<Vec<usize>>> =
            (0..3).map(|channel| vec![(0..240).filter(|row| row % 3 == channel).collect()]).collect();
        assert_eq!(neighbour_correlation(&solved.solution(), &thirds).unwrap(), 0.0);
        let mut random = Pcg64::new(3, 3);
        let mut builder = ProblemBuilder::new();
        let block = builder.add_block(Block::scalar("level", ""), &[0.0]);
        let mut walk = 0.0;
        for row in 0..240 {
            let white: f64 = StandardNormal.sample(&mut random);
            if row % 3 == 1 {
                walk = 0.9 * walk + 0.4 * white;
            }
            add(&mut builder, Line::new(&[block], &[1.0], if row % 3 == 1 { walk } else { white }));
        }
        let found = neighbour_correlation(&fit(builder).solution(), &thirds).unwrap();
        assert!(found > 0.6, "{found}");
    }

    /// Share of intervals that hold the truth, errors correlated by 0.6 over neighbours: blocks of the length that is found.
    #[test]
    fn intervals_hold_with_coloured_errors() {
        const DRAWS: u128 = 200;
        let (mut by_blocks, mut by_noise) = (0, 0);
        for seed in 0..DRAWS {
            let solved = solved(150, 3, 0.6, 1000 + seed);
            let length = block_length(correlation(&solved, 150), 150);
            let blocks = SampleBlocks::within(std::slice::from_ref(&(0..150)), length).unwrap();
            let jackknife = Uncertainty::jackknife(&solved.solution(), &blocks).unwrap().uncertainty;
            let white = Uncertainty::from_noise(&solved.solution(), crate::statistics::NoiseScale::Relative).unwrap();
            for (column, value) in solved.values.as_slice().iter().enumerate() {
                let holds = |uncertainty: &Uncertainty| {
                    let [low, high] = uncertainty.interval(*value, &[(column, 1.0)]);
                    usize::from(low <= 0.0 && 0.0 <= high)
                };
                by_blocks += holds(&jackknife);
                by_noise += holds(&white);
            }
        }
        let [by_blocks, by_noise] = [by_blocks, by_noise].map(|count| count as f64 / (3.0 * DRAWS as f64));
        assert!((0.91..0.985).contains(&by_blocks), "{by_blocks}");
        assert!(by_noise < 0.8, "{by_noise}");
    }
}
