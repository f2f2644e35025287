//! Uncertainty robust to model error, by what the estimate would be without each block of neighbouring samples.
//!
//! To first order no block needs to be left out for that. In coordinates in which the curvature of the whole cost is the identity, with
//! `K_b` the curvature of block b's share of the cost and `s_b` its slope, the estimate without block b differs by
//!
//! ```text
//!     d_b = (I − K_b)⁻¹ s_b  =  Z_bᵀ (I − Z_b Z_bᵀ)⁻¹ r_b         the second without losses: Z_b whitened rows, r_b residuals
//! ```
//!
//! which is exact where the model is linear, and the covariance is
//!
//! ```text
//!     Σ = (G − 1)/G Σ_b d_b d_bᵀ + K_outside
//! ```
//!
//! (the delete-a-group jackknife about the estimate: MacKinnon and White, *Journal of Econometrics* 29, 1985, the estimator HC3 and its
//! exact form; Bell and McCaffrey, *Bias reduction in standard errors for linear regression with multi-stage samples*, 2002; CR3 in
//! Cameron and Miller, *A practitioner's guide to cluster-robust inference*, 2015, section VI.B). About the mean of the `d_b` it would be
//! a little smaller; about the estimate it also counts by how much blocks on the whole pull against knowledge. Σ exceeds the truth
//! where the stated noise is right, by more the fewer blocks tell a function, and so errs to the safe side where the sandwich, which is
//! unbiased there, is too small by chance. `K_outside` is the part of the factors outside of the blocks: knowledge, which enters with its
//! stated noise.
//!
//! **Intervals** are Student's with as many degrees of freedom as blocks tell the function, less one. With `γ_b = cᵀ K_b c` that number is
//!
//! ```text
//!     G* = (cᵀc)² / Σ_b γ_b²
//! ```
//!
//! the effective number of clusters of Carter, Schnepel and Steigerwald (*Review of Economics and Statistics* 99, 2017, with equal
//! variances): G where all blocks tell the same, 2 where only two of them carry the load that tells a gain.
//!
//! **Unknowns of single samples** (eliminated blocks) are taken for errors of their samples: a sample's rows `Z` and residuals `r` become
//! `M^(−1/2) Z` and `M^(−1/2) r` with `M = I − O Oᵀ`, `O Oᵀ` that part of the rows' covariance at the estimate that is due to the eliminated unknowns
//! alone. That is the same as to whiten them with the noise and the scatter of these unknowns together, and what is known of them
//! beforehand leaves with their sample.
//!
//! **A block that alone determines a direction** (an eigenvalue 1 of `K_b`) leaves nothing that could tell how well. Its `d_b` is taken
//! across that direction only, which is exact for all functions that the direction does not change; along it the variance is that of
//! the noise, and [`Jackknife::alone`] says so. To drop such blocks in silence promises too much (Hansen, *Jackknife standard
//! errors for clustered regression*, 2025).
//!
//! **Few blocks.** With fewer than twice as many blocks as directions Σ is singular, or nearly: its standard deviations hold, and no χ²
//! of many parameters. There correlations are those of the noise.

use std::ops::Range;

use faer::Mat;

use super::determined_by_blocks::DeterminedByBlocks;
use super::eigen::{ALONE, Eigen};
use super::projected::{Projected, add_outer, back};
use super::uncertainty::Spread;
use super::{NoiseScale, SampleBlocks, Solution, StatisticsError, Uncertainty};
use crate::{EvaluateError, Loss};

/// With fewer than so many blocks for each direction a covariance of their scatter is no matrix to be inverted.
const BLOCKS_A_DIRECTION: usize = 2;
/// An eliminated unknown takes up all that this share of a row could say.
const TAKEN_UP: f64 = 1e-12;

/// What blocks left out one after the other tell.
#[derive(Clone, Debug)]
pub struct Jackknife {
    /// Covariance and intervals.
    pub uncertainty: Uncertainty,
    /// What single blocks alone determine.
    pub alone: Vec<DeterminedByOneBlock>,
}

/// A direction that one block alone determines, so that nothing but the noise tells how well.
#[derive(Clone, Debug, PartialEq)]
pub struct DeterminedByOneBlock {
    /// The factors of the block.
    pub factors: Range<usize>,
    /// A step by the problem's shared columns of one standard deviation of the noise.
    pub step: Vec<f64>,
}

impl Uncertainty {
    /// The uncertainty that blocks left out one after the other tell; nothing is solved again.
    ///
    /// # Errors
    /// Where the problem lacks samples of the blocks, has eliminated blocks together with losses, or so much is forgiven by a loss that no
    /// minimum is left.
    pub fn jackknife(solution: &Solution<'_>, blocks: &SampleBlocks) -> Result<Jackknife, StatisticsError> {
        blocks.check(solution.problem.factors().len())?;
        let projected = Projected::of_shared(solution)?;
        let projected = if projected.has_eliminated() { projected } else { projected.with_unit_curvature()? };
        let rank = projected.rank();
        let (mut scatter, mut outside) = (Mat::zeros(rank, rank), information(&projected, solution, blocks)?);
        let (mut reported, mut alone) = (Vec::new(), Vec::new());
        let size = unexplained(solution)?;
        for block in blocks.iter() {
            let share = Share::new(&projected, block.clone())?;
            add_outer(&mut scatter, 1.0, &share.change);
            for direction in share.alone {
                // Known by the noise alone, which may be larger than stated.
                add_outer(&mut outside, size, &direction);
                alone.push(DeterminedByOneBlock {
                    factors: block.clone(),
                    step: back(&projected.directions, &direction),
                });
            }
            reported.push(share.rows);
        }
        let count = blocks.count() as f64;
        let covariance = projected.covariance(&(faer::Scale((count - 1.0) / count) * scatter + outside));
        let mut covariance = solution.analysis.over_all_columns(covariance);
        if blocks.count() < BLOCKS_A_DIRECTION * rank {
            let noise = Uncertainty::from_noise(solution, NoiseScale::Stated)?.covariance;
            covariance = noise.widened(&covariance.ratios_to(&noise));
        }
        let reported = DeterminedByBlocks::new(projected.directions, reported);
        Ok(Jackknife { uncertainty: Uncertainty { covariance, spread: Spread::LeftOut(reported) }, alone })
    }
}

/// `K_outside`. Of eliminated unknowns, what is known beforehand leaves with their samples: there it is what all blocks leave of the whole.
fn information(
    projected: &Projected<'_>,
    solution: &Solution<'_>,
    blocks: &SampleBlocks,
) -> Result<Mat<f64>, StatisticsError> {
    if !projected.has_eliminated() {
        return Ok(projected.curvature(blocks.outside(solution.problem.factors().len())));
    }
    let mut left = Mat::identity(projected.rank(), projected.rank());
    for block in blocks.iter() {
        without_eliminated(projected, block)?.0.iter().for_each(|row| add_outer(&mut left, -1.0, row));
    }
    Ok(left)
}

/// How many times the variance of the residuals exceeds that of the stated noise, and at least 1; 1 where losses let it be anything.
fn unexplained(solution: &Solution<'_>) -> Result<f64, EvaluateError> {
    let (rows, rank) = (solution.problem.rows(), solution.analysis.rank());
    if rows <= rank || solution.problem.factors().iter().any(|factor| factor.loss != Loss::None) {
        return Ok(1.0);
    }
    let squares: f64 = solution.problem.residuals(solution.values)?.iter().map(|r| r * r).sum();
    Ok((squares / (rows - rank) as f64).max(1.0))
}

/// What one block tells, in coordinates in which the curvature of the whole cost is the identity.
struct Share {
    /// `d_b`.
    change: Vec<f64>,
    /// Directions of which the block holds all the information.
    alone: Vec<Vec<f64>>,
    /// `Z_b`, with what the losses leave of each row.
    rows: Vec<Vec<f64>>,
}

impl Share {
    fn new(projected: &Projected<'_>, block: Range<usize>) -> Result<Share, StatisticsError> {
        let forgiving = block.clone().any(|factor| projected.loss(factor) != Loss::None);
        let (rows, residuals) = if projected.has_eliminated() {
            without_eliminated(projected, block.clone())?
        } else {
            (projected.weighted_rows(block.clone()), projected.residuals_of(block.clone()).to_vec())
        };
        if !forgiving && rows.len() < projected.rank() {
            return Self::by_rows(rows, &residuals);
        }
        let (curvature, score) = if projected.has_eliminated() {
            let mut gram = Mat::zeros(projected.rank(), projected.rank());
            rows.iter().for_each(|row| add_outer(&mut gram, 1.0, row));
            (gram, combined(&rows, &residuals))
        } else {
            (projected.curvature(block.clone()), projected.score(block))
        };
        let eigen = Eigen::of(&curvature)?;
        let mut share = Share { change: vec![0.0; score.len()], alone: Vec::new(), rows };
        for (value, direction) in eigen.pairs() {
            if 1.0 - value < ALONE {
                share.alone.push(direction.clone());
            } else {
                let along: f64 = direction.iter().zip(&score).map(|(d, s)| d * s).sum();
                share.change.iter_mut().zip(direction).for_each(|(sum, d)| *sum += along / (1.0 - value) * d);
            }
        }
        Ok(share)
    }

    /// By the eigenvalues of `Z_b Z_bᵀ`, which are fewer where a block has fewer rows than there are directions.
    fn by_rows(rows: Vec<Vec<f64>>, residuals: &[f64]) -> Result<Share, StatisticsError> {
        let hat = Mat::from_fn(rows.len(), rows.len(), |i, j| rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum());
        let mut weights = vec![0.0; rows.len()];
        let mut alone = Vec::new();
        for (value, direction) in Eigen::of(&hat)?.pairs() {
            if 1.0 - value < ALONE {
                alone.push(combined(&rows, direction));
            } else {
                let along: f64 = direction.iter().zip(residuals).map(|(d, r)| d * r).sum();
                weights.iter_mut().zip(direction).for_each(|(sum, d)| *sum += along / (1.0 - value) * d);
            }
        }
        Ok(Share { change: combined(&rows, &weights), alone, rows })
    }
}

/// Rows and residuals of a block with its eliminated unknowns taken for errors.
fn without_eliminated(
    projected: &Projected<'_>,
    block: Range<usize>,
) -> Result<(Vec<Vec<f64>>, Vec<f64>), StatisticsError> {
    let (mut rows, mut residuals) = (Vec::new(), Vec::new());
    let (own_rows, own_residuals) = (projected.rows_of(block.clone()), projected.residuals_of(block.clone()));
    let first = projected.range(block).start;
    let left = Mat::from_fn(own_rows.len(), own_rows.len(), |i, j| {
        f64::from(u8::from(i == j)) - projected.common_of_eliminated(first + i, first + j)
    });
    for (value, direction) in Eigen::of(&left)?.pairs() {
        // What the eliminated unknowns take up altogether says nothing of others.
        if value > TAKEN_UP {
            let weights: Vec<f64> = direction.iter().map(|d| d / value.sqrt()).collect();
            rows.push(combined(own_rows, &weights));
            residuals.push(weights.iter().zip(own_residuals).map(|(w, r)| w * r).sum());
        }
    }
    Ok((rows, residuals))
}

/// `Σ weight · row`.
fn combined(rows: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; rows.first().map_or(0, Vec::len)];
    for (row, weight) in rows.iter().zip(weights) {
        sum.iter_mut().zip(row).for_each(|(sum, z)| *sum += weight * z);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Covariance;
    use crate::testing::{Line, Solved, add, fit, fit_robustly};
    use crate::{Block, BlockId, Factor, Noise, ProblemBuilder};

    /// Numbers between −1 and 1 without any order.
    fn noise(k: usize) -> f64 {
        ((k * k * 7919 + 31 * k) % 1009) as f64 / 504.5 - 1.0
    }

    fn jackknife(solved: &Solved, samples: usize, length: usize) -> Jackknife {
        let blocks = SampleBlocks::within(std::slice::from_ref(&(0..samples)), length).unwrap();
        Uncertainty::jackknife(&solved.solution(), &blocks).unwrap()
    }

    /// Least squares by the textbook: the normal equations by Gauss's elimination.
    fn least_squares(rows: &[(Vec<f64>, f64)]) -> Vec<f64> {
        let size = rows[0].0.len();
        let mut system = vec![vec![0.0; size + 1]; size];
        for (slopes, reading) in rows {
            for i in 0..size {
                (0..size).for_each(|j| system[i][j] += slopes[i] * slopes[j]);
                system[i][size] += slopes[i] * reading;
            }
        }
        for pivot in 0..size {
            let best =
                (pivot..size).max_by(|a, b| system[*a][pivot].abs().total_cmp(&system[*b][pivot].abs())).unwrap();
            system.swap(pivot, best);
            for i in (0..size).filter(|i| *i != pivot) {
                let factor = system[i][pivot] / system[pivot][pivot];
                (0..=size).for_each(|j| system[i][j] -= factor * system[pivot][j]);
            }
        }
        (0..size).map(|i| system[i][size] / system[i][i]).collect()
    }

    /// `(G − 1)/G Σ d dᵀ` of so many parameters by leaving out one block after the other and solving again.
    fn by_hand(samples: &[Vec<(Vec<f64>, f64)>], length: usize, further: &[(Vec<f64>, f64)], size: usize) -> Vec<f64> {
        let rows = |kept: &dyn Fn(usize) -> bool| {
            let kept = (0..samples.len()).filter(|sample| kept(*sample)).flat_map(|sample| samples[sample].clone());
            kept.chain(further.iter().cloned()).collect::<Vec<_>>()
        };
        let all = least_squares(&rows(&|_| true));
        let count = samples.len() / length;
        let mut sum = vec![0.0; size * size];
        for block in 0..count {
            let without = least_squares(&rows(&|sample| sample / length != block));
            for i in 0..size {
                for j in 0..size {
                    sum[i * size + j] +=
                        (without[i] - all[i]) * (without[j] - all[j]) * (count - 1) as f64 / count as f64;
                }
            }
        }
        sum
    }

    fn assert_same(found: &Covariance, expected: &[f64], size: usize) {
        for i in 0..size {
            for j in 0..size {
                let scale = (expected[i * (size + 1)] * expected[j * (size + 1)]).sqrt();
                let difference = (found.at(i, j) - expected[i * size + j]).abs() / scale;
                assert!(difference < 1e-10, "{i} {j}: {} {}", found.at(i, j), expected[i * size + j]);
            }
        }
    }

    /// The rows of a sample: slopes by all parameters, and the reading.
    type Sample = Vec<(Vec<f64>, f64)>;

    /// `a + b t + c t²` with noise that grows.
    fn parabola(count: usize) -> (ProblemBuilder, [BlockId; 3], Vec<Sample>) {
        let mut builder = ProblemBuilder::new();
        let blocks = ["a", "b", "c"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        let sample = |k: usize| {
            let t = k as f64 / count as f64;
            (vec![1.0, t, t * t], 2.0 - t + (1.0 + 3.0 * t) * noise(k))
        };
        let samples: Vec<(Vec<f64>, f64)> = (0..count).map(sample).collect();
        samples.iter().for_each(|(slopes, y)| add(&mut builder, Line::new(&blocks, slopes, *y)));
        (builder, blocks, samples.into_iter().map(|sample| vec![sample]).collect())
    }

    #[test]
    fn it_is_what_solving_again_without_each_block_gives() {
        let (builder, _, samples) = parabola(60);
        let solved = fit(builder);
        // Blocks of fewer rows than parameters, and of more: two ways to the same.
        for length in [1, 2, 5] {
            let found = jackknife(&solved, 60, length);
            assert!(found.alone.is_empty());
            assert_same(found.uncertainty.covariance(), &by_hand(&samples, length, &[], 3), 3);
        }
    }

    #[test]
    fn knowledge_stays_where_blocks_leave_and_adds_its_own_noise() {
        let (mut builder, blocks, samples) = parabola(60);
        // c = 1 ± 0.5 beside samples of unit noise, and a that nothing else says about c.
        builder.add_factor(Factor::new(Line::new(&blocks[2..], &[1.0], 1.0), Noise::independent(&[0.5]).unwrap()));
        let prior = [(vec![0.0, 0.0, 2.0], 2.0)];
        let mut expected = by_hand(&samples, 3, &prior, 3);
        // How the estimate follows the prior's reading, by moving it.
        let all = |reading: f64| {
            let rows: Vec<(Vec<f64>, f64)> = samples.iter().flatten().cloned().collect();
            least_squares(&[rows, vec![(prior[0].0.clone(), reading)]].concat())
        };
        let slope: Vec<f64> = all(3.0).iter().zip(all(2.0)).map(|(a, b)| a - b).collect();
        (0..9).for_each(|k| expected[k] += slope[k / 3] * slope[k % 3]);
        assert_same(jackknife(&fit(builder), 60, 3).uncertainty.covariance(), &expected, 3);
    }

    /// Readings `a + b t + e`, two a sample, with an unknown error `e = 0 ± 1` of each sample.
    fn with_errors_of_samples(eliminated: bool) -> (Solved, Vec<Sample>) {
        const SAMPLES: usize = 24;
        let mut builder = ProblemBuilder::new();
        let [a, b] = ["a", "b"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        let errors: Vec<BlockId> = (0..SAMPLES)
            .map(|k| {
                let block = Block::scalar(format!("e{k}"), "");
                builder.add_block(if eliminated { block.eliminated() } else { block }, &[0.0])
            })
            .collect();
        let unit = || Noise::independent(&[1.0]).unwrap();
        let mut samples = Vec::new();
        for (k, error) in errors.iter().enumerate() {
            let row = |slope: f64, share: f64, reading: f64| {
                let mut row = vec![0.0; 2 + SAMPLES];
                (row[0], row[1], row[2 + k]) = (1.0, slope, share);
                (row, reading)
            };
            let both = [(k as f64 / 8.0, 1.0, 2.0 * noise(k)), (k as f64 / 5.0, -0.7, 3.0 * noise(k + 100))];
            let lines = both.map(|(t, share, y)| Line::new(&[a, b, *error], &[1.0, t, share], y));
            // One factor a sample, of two rows.
            builder.add_factor(Factor::new(Both(lines), Noise::independent(&[1.0, 1.0]).unwrap()));
            let mut rows: Vec<(Vec<f64>, f64)> = both.iter().map(|(t, share, y)| row(*t, *share, *y)).collect();
            let mut prior = vec![0.0; 2 + SAMPLES];
            prior[2 + k] = 1.0;
            rows.push((prior, 0.0));
            samples.push(rows);
        }
        for error in errors {
            builder.add_factor(Factor::new(Line::new(&[error], &[1.0], 0.0), unit()));
        }
        (fit(builder), samples)
    }

    #[derive(Debug)]
    struct Both([Line; 2]);

    impl crate::Residual for Both {
        fn blocks(&self) -> &[BlockId] {
            self.0[0].blocks()
        }

        fn len(&self) -> usize {
            2
        }

        fn evaluate(
            &self,
            x: crate::LocalValues<'_>,
            residual: &mut [f64],
            jacobian: Option<crate::RowsMut<'_>>,
        ) -> Result<(), EvaluateError> {
            let mut rows = vec![0.0; 2 * x.as_slice().len()];
            let width = x.as_slice().len();
            for (k, line) in self.0.iter().enumerate() {
                let own = crate::RowsMut::new(&mut rows[k * width..(k + 1) * width], width);
                line.evaluate(x, &mut residual[k..=k], Some(own))?;
            }
            if let Some(mut jacobian) = jacobian {
                (0..2).for_each(|k| jacobian.row(k).copy_from_slice(&rows[k * width..(k + 1) * width]));
            }
            Ok(())
        }
    }

    /// What is known of a sample's own error leaves with the sample: without its readings it says nothing of the rest anyway.
    #[test]
    fn unknowns_of_single_samples_leave_with_them() {
        let (solved, samples) = with_errors_of_samples(true);
        let found = jackknife(&solved, 24, 2);
        let expected = {
            // Left out, a sample's readings; its prior stays, so that the system is regular, and changes nothing else.
            let readings: Vec<Sample> = samples.iter().map(|rows| rows[..2].to_vec()).collect();
            let priors: Vec<(Vec<f64>, f64)> = samples.iter().map(|rows| rows[2].clone()).collect();
            by_hand(&readings, 2, &priors, 2)
        };
        assert_same(found.uncertainty.covariance(), &expected, 2);
        // Their own errors have a variance, too: at most what was known beforehand, and more than nothing.
        let own = found.uncertainty.covariance().std(2 + 5);
        assert!(own > 0.1 && own < 1.2, "{own}");
        let [low, high] = found.uncertainty.interval(0.0, &[(2 + 5, 1.0)]);
        assert!(low < -own && high > own && high.is_finite());
        // Without elimination priors are knowledge beside the samples, and their noise is added: more.
        let (plain, _) = with_errors_of_samples(false);
        let plain = jackknife(&plain, 24, 2);
        assert!(plain.uncertainty.covariance().at(0, 0) > found.uncertainty.covariance().at(0, 0));
    }

    #[test]
    fn under_a_loss_it_is_nearly_what_solving_again_gives() {
        let mut y: Vec<f64> = (0..80).map(|k| 1.5 * noise(k)).collect();
        (0..80).step_by(13).for_each(|k| y[k] += 9.0);
        for loss in [Loss::Huber(1.3), Loss::Cauchy(2.4)] {
            let solved = fit_robustly(&y, loss);
            let level = solved.values.as_slice()[0];
            let changes = (0..20).map(|block| {
                let kept: Vec<f64> = (0..80).filter(|k| k / 4 != block).map(|k| y[k]).collect();
                fit_robustly(&kept, loss).values.as_slice()[0] - level
            });
            let expected = changes.map(|d| d * d).sum::<f64>() * 19.0 / 20.0;
            let ratio = jackknife(&solved, 80, 4).uncertainty.covariance().at(0, 0) / expected;
            assert!((ratio - 1.0).abs() < 0.05, "{loss:?}: {ratio}");
        }
    }

    #[test]
    fn what_one_block_alone_tells_has_the_variance_of_the_noise_and_is_reported() {
        let (mut builder, blocks, samples) = parabola(57);
        let step = builder.add_block(Block::scalar("step", ""), &[0.0]);
        let unknowns = [&blocks[..], &[step]].concat();
        for k in 0..3 {
            add(&mut builder, Line::new(&unknowns, &[1.0, 1.0, 1.0, 1.0], 5.0 + noise(k)));
        }
        let solved = fit(builder);
        let found = jackknife(&solved, 60, 3);
        let [alone] = &found.alone[..] else { panic!("{:?}", found.alone) };
        assert_eq!(alone.factors, 57..60);
        assert!(alone.step[..3].iter().all(|s| s.abs() < 1e-9) && alone.step[3].abs() > 0.1, "{alone:?}");
        // The others never heard of the step, and are what they are without the block; which it leaves as they are.
        let mut expected = by_hand(&samples, 3, &[], 3);
        expected.iter_mut().for_each(|v| *v *= (19.0 / 20.0) / (18.0 / 19.0));
        assert_same(found.uncertainty.covariance(), &expected, 3);
        let (std, noise) = (found.uncertainty.covariance().std(3), solved.solution().analysis.covariance().std(3));
        assert!(std > 0.9 * noise && std.is_finite());
        assert!(found.uncertainty.interval(0.0, &[(3, 1.0)]).iter().all(|end| end.is_finite()));
    }

    #[test]
    fn with_few_blocks_correlations_are_those_of_the_noise() {
        let mut builder = ProblemBuilder::new();
        let blocks: Vec<BlockId> =
            (0..8).map(|k| builder.add_block(Block::scalar(format!("x{k}"), ""), &[0.0])).collect();
        let slopes = |k: usize| (0..8).map(|j| noise(k * 8 + j)).collect::<Vec<f64>>();
        let samples: Vec<Sample> = (0..60).map(|k| vec![(slopes(k), noise(1000 + 3 * k))]).collect();
        samples.iter().flatten().for_each(|(slopes, y)| add(&mut builder, Line::new(&blocks, slopes, *y)));
        let solved = fit(builder);
        let found = jackknife(&solved, 60, 5).uncertainty;
        let expected = by_hand(&samples, 5, &[], 8);
        let white = solved.solution().analysis.covariance();
        for i in 0..8 {
            assert!((found.covariance().std(i) / expected[i * 9].sqrt() - 1.0).abs() < 1e-10);
            for j in 0..8 {
                assert!((found.covariance().correlation(i, j) - white.correlation(i, j)).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn equal_blocks_have_one_degree_of_freedom_less_and_few_that_tell_have_few() {
        let mut builder = ProblemBuilder::new();
        let [a, b] = ["level", "load"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        for k in 0..40 {
            // Two of twenty blocks carry a load.
            let load = if k < 4 { 100.0 } else { 0.0 };
            add(&mut builder, Line::new(&[a, b], &[1.0, load], noise(k)));
        }
        let found = jackknife(&fit(builder), 40, 2).uncertainty;
        let Spread::LeftOut(reported) = &found.spread else { panic!("no blocks") };
        assert!((reported.freedom(&[(0, 1.0)]) - 17.0).abs() < 1e-6, "18 tell the level");
        // Each of the two tells 0.45 of the load's variance, each of the others 0.1/18: 1/(2 · 0.2025 + 0.01/18) − 1.
        assert!((reported.freedom(&[(1, 1.0)]) - 1.465_753).abs() < 1e-6, "{}", reported.freedom(&[(1, 1.0)]));
    }

    #[test]
    fn the_larger_of_two_is_never_smaller_than_either() {
        let (builder, ..) = parabola(60);
        let solved = fit(builder);
        let white = Uncertainty::from_noise(&solved.solution(), NoiseScale::Stated).unwrap();
        let blocks = jackknife(&solved, 60, 4).uncertainty;
        let both = white.clone().larger_of(blocks.clone());
        for i in 0..3 {
            let stds = [&white, &blocks].map(|one| one.covariance().std(i));
            assert!((both.covariance().std(i) / stds[0].max(stds[1]) - 1.0).abs() < 1e-12);
            let larger = if stds[0] < stds[1] { &blocks } else { &white };
            assert_eq!(both.interval(1.0, &[(i, 1.0)]), larger.interval(1.0, &[(i, 1.0)]));
            for j in 0..3 {
                let correlation = both.covariance().correlation(i, j) - white.covariance().correlation(i, j);
                assert!(correlation.abs() < 1e-12);
            }
        }
        let again = both.clone().larger_of(both.clone());
        assert!((again.covariance().std(1) / both.covariance().std(1) - 1.0).abs() < 1e-12);
    }
}
