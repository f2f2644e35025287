//! Uncertainty robust to model error, by solving again what might have been recorded instead.
//!
//! Each replicate draws as many blocks of neighbouring samples as there are, with replacement, and solves from the
//! estimate (Davison and Hinkley, *Bootstrap methods and their application*, 1997, section 6.2.4: resampling cases, here
//! blocks). The scatter of the solutions about their mean, times `G/(G − 1)` for G blocks, is the covariance; the interval
//! lies between their quantiles
//!
//! ```text
//!     α = Φ(−√(G/(G − 1)) t)   and   1 − α,       t: 0.975-quantile of Student's t with G − 1 degrees of freedom
//! ```
//!
//! instead of 2.5 % and 97.5 %, which are too narrow where blocks are few (Hesterberg, *What teachers should know about
//! the bootstrap*, 2015, on the expanded percentile interval: exact for the mean of normal samples).
//!
//! Factors outside of the blocks are knowledge: each replicate draws their readings anew from their stated noise.
//!
//! **Assumptions.** Those of the sandwich covariance (errors of different blocks do not depend on each other); the model
//! need not be nearly linear. Blocks that a replicate leaves out may be the only ones to determine something: such
//! replicates are left out and counted, as are those that do not converge. What is left is then a little optimistic.
//!
//! Replicate k draws from the random numbers of stream k of the seed: the result does not depend on the number of threads.

use std::sync::Arc;

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use statrs::distribution::{ContinuousCDF, Normal};

use super::redrawn::Redrawn;
use super::uncertainty::Spread;
use super::{Covariance, Quantile, SampleBlocks, Solution, StatisticsError, Uncertainty};
use crate::{BlockId, Factor, RankAnalysis, SolveContext, Solver, Values, in_parallel};

/// How replicates are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Resampling<'a> {
    /// What is drawn.
    pub blocks: &'a SampleBlocks,
    /// How often; percentiles need some hundreds.
    pub replicates: usize,
    /// Replicates of another seed are others.
    pub seed: u64,
    /// Blocks of the problem that are fixed while a replicate is solved, because they fix a combination without effect.
    pub fixed: &'a [BlockId],
}

/// The scatter of the replicates, and how many there are.
#[derive(Clone, Debug)]
pub struct Bootstrap {
    /// Covariance and percentile intervals.
    pub uncertainty: Uncertainty,
    /// Replicates that count.
    pub replicates: usize,
    /// Replicates that did not converge.
    pub not_converged: usize,
    /// Replicates whose samples determine less than all of them do.
    pub undetermined: usize,
}

/// How a replicate ended.
enum Outcome {
    Step(Vec<f64>),
    NotConverged,
    Undetermined,
}

impl Bootstrap {
    /// Solves the replicates of a solved problem.
    ///
    /// # Errors
    /// Where most replicates have no solution, or the problem has eliminated blocks or lacks samples of the blocks.
    pub fn new(
        solution: &Solution<'_>,
        resampling: &Resampling<'_>,
        solver: &dyn Solver,
    ) -> Result<Bootstrap, StatisticsError> {
        solution.without_eliminated()?;
        resampling.blocks.check(solution.problem.factors().len())?;
        let replicates = 0..resampling.replicates as u64;
        let outcomes = in_parallel(replicates, |index| replicate(solution, resampling, solver, index));
        let count = |is: fn(&Outcome) -> bool| outcomes.iter().filter(|outcome| is(outcome)).count();
        let not_converged = count(|outcome| matches!(outcome, Outcome::NotConverged));
        let undetermined = count(|outcome| matches!(outcome, Outcome::Undetermined));
        let steps: Vec<Vec<f64>> =
            outcomes.into_iter().filter_map(|o| if let Outcome::Step(step) = o { Some(step) } else { None }).collect();
        if 2 * steps.len() < resampling.replicates || steps.len() < 2 {
            let replicates = resampling.replicates;
            return Err(StatisticsError::Replicates { replicates, not_converged, undetermined });
        }
        let replicates = Replicates { steps, blocks: resampling.blocks.count() as f64 };
        let covariance = replicates.covariance(solution.problem.columns().len());
        Ok(Bootstrap {
            replicates: replicates.steps.len(),
            uncertainty: Uncertainty { covariance, spread: Spread::Replicates(replicates) },
            not_converged,
            undetermined,
        })
    }
}

fn replicate(solution: &Solution<'_>, resampling: &Resampling<'_>, solver: &dyn Solver, index: u64) -> Outcome {
    let mut random = Pcg64::new(u128::from(resampling.seed), u128::from(index));
    let factors = draw(solution, resampling.blocks, &mut random);
    // A block of the problem that none of the drawn samples reads is not determined.
    let Ok(problem) = solution.problem.with_factors(factors) else { return Outcome::Undetermined };
    let fixed = problem.with_fixed(resampling.fixed, "a combination that has no effect is fixed by it");
    let solved = solver.solve(&fixed, solution.values, &mut SolveContext::default());
    let Ok(estimate) = solved else { return Outcome::NotConverged };
    if !estimate.termination.converged() {
        return Outcome::NotConverged;
    }
    match RankAnalysis::new(&problem, &estimate.values) {
        Ok(analysis) if analysis.rank() >= solution.analysis.rank() => {
            let step = step_between(solution, &estimate.values);
            Outcome::Step(solution.analysis.determined_part(&step))
        }
        _ => Outcome::Undetermined,
    }
}

/// The factors of one replicate.
fn draw(solution: &Solution<'_>, blocks: &SampleBlocks, random: &mut Pcg64) -> Vec<Factor> {
    let all = solution.problem.factors();
    let cuts: Vec<_> = blocks.iter().collect();
    let mut factors = Vec::with_capacity(all.len());
    for _ in 0..cuts.len() {
        let drawn = random.random_range(0..cuts.len());
        factors.extend_from_slice(&all[cuts[drawn].clone()]);
    }
    factors.extend(blocks.outside(all.len()).map(|factor| redrawn(&all[factor], random)));
    factors
}

/// A factor with another reading of the same noise.
fn redrawn(factor: &Factor, random: &mut Pcg64) -> Factor {
    let mut error: Vec<f64> = (0..factor.residual.len()).map(|_| StandardNormal.sample(random)).collect();
    factor.noise.unwhiten(&mut error);
    let residual = Redrawn { residual: Arc::clone(&factor.residual), error };
    Factor { residual: Arc::new(residual), ..factor.clone() }
}

/// The step from the estimate to other values, by the problem's columns.
fn step_between(solution: &Solution<'_>, values: &Values) -> Vec<f64> {
    let mut step = vec![0.0; solution.problem.columns().len()];
    for id in solution.problem.block_ids() {
        let columns = solution.problem.columns_of(id);
        let basis = solution.problem.tangent_basis(solution.values, id);
        let (from, to) = (solution.values.get(id), values.get(id));
        for (t, column) in columns.clone().enumerate() {
            let along =
                from.iter().zip(to).enumerate().map(|(s, (from, to))| basis[s * columns.len() + t] * (to - from));
            step[column] = along.sum();
        }
    }
    step
}

/// Steps from the estimate to that of each replicate, by the problem's columns.
#[derive(Clone, Debug)]
pub(super) struct Replicates {
    steps: Vec<Vec<f64>>,
    /// How many blocks were drawn from.
    blocks: f64,
}

impl Replicates {
    /// By which variances of replicates are too small.
    fn correction(&self) -> f64 {
        self.blocks / (self.blocks - 1.0)
    }

    /// Student's quantile with one degree of freedom less than there are blocks.
    pub fn quantile(&self) -> Quantile {
        Quantile::student(self.blocks - 1.0)
    }

    /// Covariance of the steps about their mean.
    fn covariance(&self, size: usize) -> Covariance {
        let count = self.steps.len() as f64;
        let mean: Vec<f64> = (0..size).map(|i| self.steps.iter().map(|step| step[i]).sum::<f64>() / count).collect();
        let mut tangent = vec![0.0; size * size];
        for step in &self.steps {
            let offset: Vec<f64> = step.iter().zip(&mean).map(|(s, m)| s - m).collect();
            for (row, left) in tangent.chunks_exact_mut(size).zip(&offset) {
                row.iter_mut().zip(&offset).for_each(|(sum, right)| *sum += left * right / (count - 1.0));
            }
        }
        Covariance::new(tangent, size).scaled(self.correction())
    }

    /// Where a function's interval begins and ends, from the estimate. Of `n` steps the k-th stands for the share
    /// `k/(n + 1)`, neighbouring ones in proportion for what is between.
    pub fn percentiles(&self, function: &[(usize, f64)]) -> [f64; 2] {
        let along = |step: &Vec<f64>| function.iter().map(|(column, c)| c * step[*column]).sum();
        let mut offsets: Vec<f64> = self.steps.iter().map(along).collect();
        offsets.sort_by(f64::total_cmp);
        let half_width = self.quantile().interval(0.0, self.correction().sqrt())[1];
        let tail = Normal::standard().cdf(-half_width);
        [tail, 1.0 - tail].map(|share| {
            let place = (share * (offsets.len() as f64 + 1.0) - 1.0).clamp(0.0, offsets.len() as f64 - 1.0);
            let (below, above) = (place.floor() as usize, place.ceil() as usize);
            offsets[below] + (place - place.floor()) * (offsets[above] - offsets[below])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_stand_between_their_neighbours_and_a_little_farther_out_where_blocks_are_few() {
        let steps: Vec<Vec<f64>> = (1..40).rev().map(|k| vec![0.0, f64::from(k)]).collect();
        let many = Replicates { steps: steps.clone(), blocks: 1e12 };
        let [low, high] = many.percentiles(&[(1, 2.0)]);
        assert!((low - 2.0).abs() < 1e-6 && (high - 78.0).abs() < 1e-6, "{low} {high}");
        assert_eq!(many.percentiles(&[]), [0.0, 0.0]);
        // √(30/29) 2.0452 = 2.0802, beyond which 1.876 % of a normal distribution lie.
        let hundred = Replicates { steps: (1..1000).map(|k| vec![f64::from(k)]).collect(), blocks: 30.0 };
        let [low, _] = hundred.percentiles(&[(0, 1.0)]);
        assert!((low - 18.76).abs() < 0.02, "{low}");
    }

    use crate::testing::{Line, Newton, add, fit, level};
    use crate::{Block, Noise};

    fn bootstrap(builder: crate::ProblemBuilder, samples: usize, seed: u64) -> Result<Bootstrap, StatisticsError> {
        let solved = fit(builder);
        let blocks = SampleBlocks::new(0..samples, 2).unwrap();
        let resampling = Resampling { blocks: &blocks, replicates: 400, seed, fixed: &[] };
        Bootstrap::new(&solved.solution(), &resampling, &Newton)
    }

    fn readings() -> Vec<f64> {
        (0..60).map(|k| f64::from(k * k * 37 % 101) / 50.0 - 1.0).collect()
    }

    /// Drawn means, corrected, scatter with the textbook's variance of a mean of blocks.
    #[test]
    fn a_level_scatters_as_the_means_of_its_blocks() {
        let y = readings();
        let found = bootstrap(level(&y).0, 60, 1).unwrap();
        assert_eq!((found.replicates, found.not_converged, found.undetermined), (400, 0, 0));
        let means: Vec<f64> = y.chunks(2).map(|block| 0.5 * (block[0] + block[1])).collect();
        let mean = means.iter().sum::<f64>() / 30.0;
        let expected = (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 29.0 / 30.0).sqrt();
        let std = found.uncertainty.covariance().std(0);
        // The standard deviation of 400 draws is known to 1/√800; four of those.
        assert!((std / expected - 1.0).abs() < 4.0 / 800.0_f64.sqrt(), "{std} {expected}");
        let [low, high] = found.uncertainty.interval(mean, &[(0, 1.0)]);
        assert!((high - low) / std > 3.5 && (high - low) / std < 4.6, "{low} {high} {std}");
    }

    #[test]
    fn knowledge_is_drawn_from_its_noise() {
        let (mut builder, _) = level(&readings());
        let other = builder.add_block(Block::scalar("other", ""), &[0.0]);
        builder.add_factor(Factor::new(Line::new(&[other], &[1.0], 3.0), Noise::independent(&[0.25]).unwrap()));
        let std = bootstrap(builder, 60, 1).unwrap().uncertainty.covariance().std(1);
        assert!((std / 0.25 - 1.0).abs() < 4.0 / 800.0_f64.sqrt(), "{std}"); // the correction is 2 %
    }

    #[test]
    fn replicates_that_lack_what_determines_something_are_counted() {
        let (mut builder, id) = level(&readings()[..58]);
        let step = builder.add_block(Block::scalar("step", ""), &[0.0]);
        [0.2, 0.3].iter().for_each(|y| add(&mut builder, Line::new(&[id, step], &[1.0, 1.0], *y)));
        let found = bootstrap(builder, 60, 1).unwrap();
        // A block of 30 is never drawn in (1 − 1/30)^30 of the replicates.
        let share = found.undetermined as f64 / 400.0;
        assert!((share - (1.0 - 1.0 / 30.0_f64).powi(30)).abs() < 0.1, "{share}");
        assert_eq!(found.replicates + found.undetermined, 400);
    }

    #[test]
    fn the_seed_decides_and_the_threads_do_not() {
        let run = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| format!("{:?}", bootstrap(level(&readings()).0, 60, seed).unwrap()))
        };
        assert_eq!(run(1, 7), run(2, 7));
        assert_ne!(run(1, 7), run(1, 8));
    }
}
