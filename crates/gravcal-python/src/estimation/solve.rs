//! A problem that Python says, solved, and what the data determine of it.

use std::sync::Arc;

use gravcal::estimation::statistics::{NoiseScale, Solution, along_constraints, stored_coordinates};
use gravcal::estimation::{
    BlockId, Estimate, IterationRecord, NamedCombination, Problem, RankAnalysis, SolveContext, Uncertainty,
    named_combinations,
};
use gravcal::solvers::SolverName;
use pyo3::prelude::*;

use super::residual::Raised;
use super::said::{SaidBlock, SaidConstraint, SaidResidual, problem};
use crate::failure::bad_input_reported;
use crate::work::{Report, run};

/// Name, unit and coefficient of each part of a combination, and all of it in words.
type Combination = (String, Vec<(String, String, f64)>);

/// What came of it; components of blocks are counted block after block.
#[pyclass(frozen, get_all, module = "gravcal._native")]
pub struct Estimated {
    /// Where it ended.
    values: Vec<f64>,
    cost: f64,
    converged: bool,
    termination: String,
    /// Of each iteration: cost, largest cosine between the residual and a column of the Jacobian, length of the step.
    iterations: Vec<(f64, f64, f64)>,
    rank: usize,
    rows: usize,
    singular_values: Vec<f64>,
    /// Whether the readings determine each component; held ones count as determined.
    determined: Vec<bool>,
    /// Combinations of which the readings say nothing.
    undetermined: Vec<Combination>,
    /// Combinations of which they say little, and how many times less well these are known than the median one.
    weak: Vec<(Combination, f64)>,
    /// Covariance of all components, row-major, and their intervals of 95 %; empty where there is none.
    covariance: Vec<f64>,
    intervals: Vec<(f64, f64)>,
    /// Why there is none.
    without_uncertainty: Option<String>,
    /// How much the loss counts each row.
    weights: Vec<f64>,
    /// Constraints on which it leans, with their multipliers.
    active: Vec<(String, f64)>,
}

/// Solves. `options`: the solver's, as JSON. `relative`: only ratios of the noise are known.
#[pyfunction]
#[pyo3(signature = (blocks, residuals, constraints, solver, options, relative, progress=None))]
#[expect(clippy::too_many_arguments)] // Python names each of them
pub fn estimate(
    py: Python<'_>,
    blocks: Vec<SaidBlock>,
    residuals: Vec<SaidResidual>,
    constraints: Vec<SaidConstraint>,
    solver: &str,
    options: &str,
    relative: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Estimated> {
    let raised = Arc::new(Raised::default());
    let noise = if relative { NoiseScale::Relative } else { NoiseScale::Stated };
    let solved = run(py, progress, raised.stop(), |report| {
        let said = Said { blocks: &blocks, constraints: &constraints, solver, options, noise };
        said.solve(residuals, &raised, report)
    })?;
    match raised.take() {
        Some(error) => Err(error),
        None => solved.map_err(|error| bad_input_reported(py, &error)),
    }
}

struct Said<'a> {
    blocks: &'a [SaidBlock],
    constraints: &'a [SaidConstraint],
    solver: &'a str,
    options: &'a str,
    noise: NoiseScale,
}

impl Said<'_> {
    fn solve(
        &self,
        residuals: Vec<SaidResidual>,
        raised: &Arc<Raised>,
        report: &Report<'_>,
    ) -> Result<Estimated, String> {
        let (problem, start) = problem(self.blocks, residuals, self.constraints, raised)?;
        let name: SolverName = self.solver.parse().map_err(reported)?;
        let options: serde_json::Value = serde_json::from_str(self.options).map_err(reported)?;
        let solver = name.with_options(options).map_err(|error| format!("{name}: {error}"))?;
        let mut observer = |record: &IterationRecord| {
            report(format!("iteration {}, cost {:.6e}", record.iteration, record.cost));
        };
        let mut context = SolveContext { observer: Some(&mut observer), stop: Some(raised.stop()), checkpoint: None };
        let estimate = solver.solve(&problem, &start, &mut context).map_err(reported)?;
        judged(&problem, &estimate, self.noise)
    }
}

fn reported(error: impl std::error::Error) -> String {
    error.to_string()
}

/// With what the active constraints hold taken for known.
fn judged(problem: &Problem, estimate: &Estimate, noise: NoiseScale) -> Result<Estimated, String> {
    let alone = RankAnalysis::of(problem, estimate).map_err(reported)?;
    let along = along_constraints(problem, estimate, &alone).map_err(reported)?;
    let analysis =
        along.as_ref().map(|along| RankAnalysis::new(along, &estimate.values)).transpose().map_err(reported)?;
    let (analysis, judged) = (analysis.as_ref().unwrap_or(&alone), along.as_ref().unwrap_or(problem));
    let solution = Solution { problem: judged, values: &estimate.values, analysis };

    let columns: Vec<usize> = (0..problem.columns().len()).collect();
    let name = |steps: &[Vec<f64>]| named_combinations(judged, &estimate.values, &columns, steps);
    let weak = analysis.weak_directions(&columns);
    let weak_names = name(&weak.iter().map(|weak| weak.step.clone()).collect::<Vec<_>>());
    let (uncertainty, without_uncertainty) = match Uncertainty::from_noise(&solution, noise) {
        Ok(uncertainty) => (Some(uncertainty), None),
        Err(error) => (None, Some(error.to_string())),
    };
    let ids: Vec<BlockId> = problem.block_ids().collect();
    let covariance = |known: &Uncertainty| known.covariance().stored(judged, &estimate.values, &ids);
    let record = |one: &IterationRecord| (one.cost, one.cosine, one.step);
    Ok(Estimated {
        values: estimate.values.as_slice().to_vec(),
        cost: estimate.cost,
        converged: estimate.termination.converged(),
        termination: estimate.termination.to_string(),
        iterations: estimate.iterations.iter().map(record).collect(),
        rank: alone.rank(),
        rows: problem.rows(),
        singular_values: alone.singular_values().to_vec(),
        determined: determined(judged, analysis),
        undetermined: name(&analysis.null_directions(&columns)).iter().map(in_words).collect(),
        weak: weak_names.iter().map(in_words).zip(weak.iter().map(|weak| weak.times_worse)).collect(),
        covariance: uncertainty.as_ref().map_or_else(Vec::new, covariance),
        intervals: uncertainty.as_ref().map_or_else(Vec::new, |known| intervals(&solution, known)),
        without_uncertainty,
        weights: problem.weights(&estimate.values).map_err(reported)?,
        active: estimate.active.iter().map(|active| (active.name.clone(), active.multiplier)).collect(),
    })
}

fn in_words(combination: &NamedCombination) -> Combination {
    let term = |term: &gravcal::estimation::NamedTerm| (term.name.clone(), term.unit.clone(), term.coefficient);
    (combination.to_string(), combination.terms.iter().map(term).collect())
}

/// Of each component; a block on a manifold, such as a vector of known length, is determined as a whole or not.
fn determined(problem: &Problem, analysis: &RankAnalysis) -> Vec<bool> {
    let of_block = |id: BlockId| {
        let (columns, block) = (problem.columns_of(id), problem.block(id));
        let known = |columns: &[usize]| analysis.null_space_within(columns).is_empty();
        match columns.len() {
            0 => vec![true; block.len()],
            _ if block.is_euclidean() => columns.map(|column| known(&[column])).collect(),
            _ => vec![known(&columns.collect::<Vec<_>>()); block.len()],
        }
    };
    problem.block_ids().flat_map(of_block).collect()
}

fn intervals(solution: &Solution<'_>, uncertainty: &Uncertainty) -> Vec<(f64, f64)> {
    let ids: Vec<BlockId> = solution.problem.block_ids().collect();
    let functions = stored_coordinates(solution.problem, solution.values, &ids);
    let interval = |(value, function): (&f64, &Vec<(usize, f64)>)| {
        let [low, high] = uncertainty.interval(*value, function);
        (low, high)
    };
    solution.values.as_slice().iter().zip(&functions).map(interval).collect()
}
