//! Uncertainty robust to model error: the scatter of blocks of neighbouring samples tells it, not the stated noise.
//!
//! With `A` the curvature of the cost (JᵀJ without a loss) and `s_b` the slope of block b's share of the cost
//! (`Σ ρ′ j r` over its rows, zero in sum over everything), the covariance is
//!
//! ```text
//!     Σ = A⁻¹ (Σ_b s_b s_bᵀ) A⁻¹
//! ```
//!
//! (White, 1980; Liang and Zeger, 1986; Cameron and Miller, *A practitioner's guide to cluster-robust inference*, 2015,
//! section II). It holds whatever the noise is within a block: of unequal size, correlated, or an error of the model that
//! neighbours share. **Assumptions.** Errors of different blocks do not depend on each other, so a block must be longer
//! than the errors are correlated; and the estimate is close to where it would be without errors.
//!
//! **Small samples.** A fit follows its data, so residuals, and with them `s_b`, are too small. In coordinates in which
//! `A` is the identity let `K_b` be the curvature of block b's share of the cost. Each block enters as
//!
//! ```text
//!     s̃_b = (I − K_b)^(−1/2) s_b
//! ```
//!
//! which makes Σ unbiased where the stated noise is right (CR2: Bell and McCaffrey, *Bias reduction in standard errors for
//! linear regression with multi-stage samples*, 2002; Cameron and Miller, section VI.B). Intervals are Student's. For the
//! function `c` of the parameters, in the same coordinates, with `w_b = K_b (I − K_b)^(−1/2) c` and under the same noise,
//! Σ behaves like an estimate with
//!
//! ```text
//!     ν = (cᵀc)² / ( Σ_b (cᵀ K_b c)² + Σ_{b ≠ d} (w_bᵀ w_d)² )
//! ```
//!
//! degrees of freedom (Satterthwaite's approximation; Bell and McCaffrey; Cameron and Miller, section VI.D). It may be far
//! below the number of blocks where few of them tell most of `c`.
//!
//! Factors outside of the blocks are knowledge and enter with their stated noise: `Σ_b s̃_b s̃_bᵀ + K_outside`. Directions
//! without information are left out, as everywhere.

use faer::Mat;

use super::eigen::Eigen;
use super::projected::{Projected, add_outer, back};
use super::uncertainty::Spread;
use super::{SampleBlocks, Solution, StatisticsError, Uncertainty};

impl Uncertainty {
    /// The uncertainty that the scatter of blocks tells.
    ///
    /// # Errors
    /// Where the problem lacks samples of the blocks, one block alone determines something, or so much is forgiven by a loss that no minimum is left.
    pub fn sandwich(solution: &Solution<'_>, blocks: &SampleBlocks) -> Result<Uncertainty, StatisticsError> {
        blocks.check(solution.problem.factors().len())?;
        let projected = Projected::new(solution)?.with_unit_curvature()?;
        let outside = blocks.outside(solution.problem.factors().len());
        let mut meat = projected.curvature(outside);
        let mut shares = Vec::with_capacity(blocks.count());
        for block in blocks.iter() {
            let curvature = projected.curvature(block.clone());
            let eigen = Eigen::of(&curvature)?;
            if let Some(direction) = eigen.whole() {
                let step = back(&projected.directions, direction);
                let combination = solution.name_direction(&step);
                return Err(StatisticsError::SingleBlock { first: block.start + 1, last: block.end, combination });
            }
            let share = BlockShare::new(curvature, &eigen, &projected.score(block.clone()));
            add_outer(&mut meat, 1.0, &share.score);
            shares.push(share);
        }
        let covariance = projected.covariance(&meat);
        let freedom = Freedom { directions: projected.directions, shares };
        Ok(Uncertainty { covariance, spread: Spread::Blocks(freedom) })
    }
}

/// What one block contributes, in coordinates in which the curvature of the whole cost is the identity.
#[derive(Clone, Debug)]
struct BlockShare {
    /// `K_b`.
    curvature: Mat<f64>,
    /// `K_b (I − K_b)^(−1/2)`.
    adjusted_curvature: Mat<f64>,
    /// `s̃_b`.
    score: Vec<f64>,
}

impl BlockShare {
    fn new(curvature: Mat<f64>, eigen: &Eigen, score: &[f64]) -> BlockShare {
        let mut adjusted_curvature = Mat::zeros(score.len(), score.len());
        let mut adjusted = vec![0.0; score.len()];
        for (value, direction) in eigen.pairs() {
            let left = (1.0 - value).sqrt();
            let along: f64 = direction.iter().zip(score).map(|(d, s)| d * s).sum();
            adjusted.iter_mut().zip(direction).for_each(|(sum, d)| *sum += along / left * d);
            add_outer(&mut adjusted_curvature, value / left, direction);
        }
        BlockShare { curvature, adjusted_curvature, score: adjusted }
    }
}

/// What tells the degrees of freedom of a function of the parameters.
#[derive(Clone, Debug)]
pub(super) struct Freedom {
    directions: Vec<Vec<f64>>,
    shares: Vec<BlockShare>,
}

impl Freedom {
    /// ν of a linear function of the columns; infinite where it has no variance.
    pub fn of(&self, function: &[(usize, f64)]) -> f64 {
        let c = Projected::of_function(&self.directions, function);
        let total: f64 = c.iter().map(|c| c * c).sum();
        let mut products: Mat<f64> = Mat::zeros(c.len(), c.len());
        let mut spread = 0.0;
        for share in &self.shares {
            let own: f64 = times(&share.curvature, &c).iter().zip(&c).map(|(k, c)| k * c).sum();
            let w = times(&share.adjusted_curvature, &c);
            spread += own * own - w.iter().map(|w| w * w).sum::<f64>().powi(2);
            add_outer(&mut products, 1.0, &w);
        }
        // Σ_bd (w_bᵀ w_d)² = ‖Σ_b w_b w_bᵀ‖²
        spread += products.col_iter().flat_map(|column| column.iter()).map(|p| p * p).sum::<f64>();
        if spread > 0.0 { total * total / spread } else { f64::INFINITY }
    }
}

fn times(matrix: &Mat<f64>, v: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; v.len()];
    for (column, v) in matrix.col_iter().zip(v) {
        product.iter_mut().zip(column.iter()).for_each(|(sum, entry)| *sum += v * entry);
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Line, Solved, add, fit, fit_robustly, level};
    use crate::{Block, Factor, Loss, Noise, ProblemBuilder};

    /// Readings without any order.
    fn readings(count: usize) -> Vec<f64> {
        (0..count).map(|k| ((k * k * 7919 + 31 * k) % 1009) as f64 / 500.0 - 1.0).collect()
    }

    fn sandwich(solved: &Solved, samples: usize, length: usize) -> Uncertainty {
        Uncertainty::sandwich(&solved.solution(), &SampleBlocks::new(0..samples, length).unwrap()).unwrap()
    }

    fn freedom(uncertainty: &Uncertainty, function: &[(usize, f64)]) -> f64 {
        let Spread::Blocks(freedom) = &uncertainty.spread else { panic!("no blocks") };
        freedom.of(function)
    }

    /// Blocks of equal size are as good as their means: the textbook's variance of a mean, with G − 1 degrees of freedom.
    #[test]
    fn equal_blocks_of_a_level_are_their_means() {
        let y = readings(120);
        let uncertainty = sandwich(&fit(level(&y).0), 120, 4);
        let means: Vec<f64> = y.chunks(4).map(|block| block.iter().sum::<f64>() / 4.0).collect();
        let mean = means.iter().sum::<f64>() / 30.0;
        let expected = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 29.0 / 30.0;
        let found = uncertainty.covariance().at(0, 0);
        assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
        assert!((freedom(&uncertainty, &[(0, 1.0)]) - 29.0).abs() < 1e-8);
    }

    #[test]
    fn units_and_gauges_change_nothing() {
        let y = readings(100);
        let plain = sandwich(&fit(level(&y).0), 100, 3);
        // The same level as 2000 (a + b), of which only the sum has an effect.
        let mut builder = ProblemBuilder::new();
        let blocks = ["a", "b"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        y.iter().for_each(|y| add(&mut builder, Line::new(&blocks, &[2000.0, 2000.0], *y)));
        let sum = sandwich(&fit(builder), 100, 3);
        let function = [(0, 2000.0), (1, 2000.0)];
        assert!((sum.covariance().std_of(&function) / plain.covariance().std(0) - 1.0).abs() < 1e-9);
        assert!((freedom(&sum, &function) / freedom(&plain, &[(0, 1.0)]) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn knowledge_beside_the_samples_keeps_its_stated_noise() {
        let y = readings(90);
        let (mut builder, id) = level(&y);
        let prior = Factor::new(Line::new(&[id], &[1.0], 0.0), Noise::independent(&[1e-3]).unwrap());
        builder.add_factor(prior);
        let uncertainty = sandwich(&fit(builder), 90, 3);
        // A millionth of the samples' information: the prior's noise and nothing of the scatter remains.
        assert!((uncertainty.covariance().std(0) / 1e-3 - 1.0).abs() < 1e-3);
        assert!(freedom(&uncertainty, &[(0, 1.0)]) > 1e6);
    }

    #[test]
    fn what_one_block_alone_determines_is_reported_by_name() {
        let (mut builder, id) = level(&readings(88));
        let step = builder.add_block(Block::scalar("step", ""), &[0.0]);
        [0.2, 0.3].iter().for_each(|y| add(&mut builder, Line::new(&[id, step], &[1.0, 1.0], *y)));
        let solved = fit(builder);
        let blocks = SampleBlocks::new(0..90, 3).unwrap();
        let refused = Uncertainty::sandwich(&solved.solution(), &blocks).unwrap_err();
        let StatisticsError::SingleBlock { first: 88, last: 90, combination } = refused else { panic!("{refused}") };
        assert!(combination.contains("step"), "{combination}");
    }

    /// Far outliers under a loss that ignores them leave the covariance of the others.
    #[test]
    fn readings_that_count_nothing_change_nothing() {
        let y = readings(120);
        let clean = sandwich(&fit_robustly(&y, Loss::Tukey(50.0)), 120, 4);
        let mut spoilt = y.clone();
        spoilt.extend([1e3; 4]);
        let spoilt = sandwich(&fit_robustly(&spoilt, Loss::Tukey(50.0)), 124, 4);
        let ratio = spoilt.covariance().at(0, 0) / clean.covariance().at(0, 0);
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
}
