//! How often 95 % intervals hold the truth.

use std::error::Error;

use gravcal_estimation::statistics::{
    Bootstrap, NoiseScale, Resampling, SampleBlocks, Solution, StatisticsError, Uncertainty,
};
use gravcal_estimation::{Loss, RankAnalysis, SolveContext, Solver};
use gravcal_solvers::LevenbergMarquardt;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::decay::{TRUTH, problem};
use crate::errors::{BLOCK, Errors, SAMPLES};

/// Why a draw cannot be judged.
pub type Failure = Box<dyn Error + Send + Sync>;

/// How an interval is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// From the noise, as stated.
    Stated,
    /// From the noise, known up to a factor.
    Relative,
    /// From the scatter of blocks.
    Sandwich,
    /// By leaving out blocks, one after the other.
    Jackknife,
    /// By drawing blocks anew, so often.
    Bootstrap(usize),
}

/// Errors, and what is made of them.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// Samples in a recording.
    pub each: usize,
    pub errors: Errors,
    pub loss: Loss,
    pub method: Method,
}

/// How often the interval of each parameter held the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    pub draws: usize,
    pub held: [usize; 3],
}

impl Coverage {
    /// Share of the draws, by parameter.
    pub fn shares(&self) -> [f64; 3] {
        self.held.map(|held| held as f64 / self.draws as f64)
    }

    /// Standard deviation of a share that is expected to be 95 %.
    pub fn noise(&self) -> f64 {
        (0.95 * 0.05 / self.draws as f64).sqrt()
    }
}

/// Simulates a scenario. Draw k takes its random numbers from stream k.
pub fn simulate(scenario: Scenario, draws: usize, done: &(dyn Fn() + Sync)) -> Result<Coverage, Failure> {
    let each = (0..draws).into_par_iter().map(|index| {
        let held = judge(scenario, index as u64);
        done();
        held
    });
    let mut coverage = Coverage { draws, ..Coverage::default() };
    for held in each.collect::<Result<Vec<[bool; 3]>, Failure>>()? {
        coverage.held.iter_mut().zip(held).for_each(|(sum, held)| *sum += usize::from(held));
    }
    Ok(coverage)
}

/// Whether the interval of each parameter holds the truth in one draw.
fn judge(scenario: Scenario, index: u64) -> Result<[bool; 3], Failure> {
    let mut random = Pcg64::new(1, u128::from(index));
    let (problem, start) = problem(&scenario.errors.draw(scenario.each, &mut random), scenario.each, scenario.loss)?;
    let solver = LevenbergMarquardt::default();
    let estimate = solver.solve(&problem, &start, &mut SolveContext::default())?;
    let analysis = RankAnalysis::new(&problem, &estimate.values)?;
    let solution = Solution { problem: &problem, values: &estimate.values, analysis: &analysis };
    let uncertainty = uncertainty(&solution, scenario.method, &solver, index)?;
    let mut held = [false; 3];
    for (i, id) in problem.block_ids().enumerate() {
        let column = problem.columns_of(id).start;
        let [low, high] = uncertainty.interval(estimate.values.scalar(id), &[(column, 1.0)]);
        held[i] = low <= TRUTH[i] && TRUTH[i] <= high;
    }
    Ok(held)
}

fn uncertainty(
    solution: &Solution<'_>,
    method: Method,
    solver: &dyn Solver,
    seed: u64,
) -> Result<Uncertainty, StatisticsError> {
    let blocks = || SampleBlocks::new(0..SAMPLES, BLOCK);
    match method {
        Method::Stated => Uncertainty::from_noise(solution, NoiseScale::Stated),
        Method::Relative => Uncertainty::from_noise(solution, NoiseScale::Relative),
        Method::Sandwich => Uncertainty::sandwich(solution, &blocks()?),
        Method::Jackknife => Ok(Uncertainty::jackknife(solution, &blocks()?)?.uncertainty),
        Method::Bootstrap(replicates) => {
            let resampling = Resampling { blocks: &blocks()?, replicates, seed, fixed: &[] };
            Ok(Bootstrap::new(solution, &resampling, solver)?.uncertainty)
        }
    }
}
