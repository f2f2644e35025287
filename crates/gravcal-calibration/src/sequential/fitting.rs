//! The small least-squares problems of the steps: solved, checked for rank, told with their covariance, and held against the
//! noise of their own readings.

use std::ops::Range;

use gravcal_estimation::statistics::stored_coordinates;
use gravcal_estimation::{
    Block, BlockId, Covariance, Estimate, EvaluateError, Problem, ProblemBuilder, RankAnalysis, Values,
};
use gravcal_identification::SolveEnvironment;
use nalgebra::{DMatrix, DVector};

use super::carried::CarriedErrors;
use super::found::{Frozen, Missing};

/// Why blocks are fixed.
const FROZEN: &str = "found by an earlier step";

/// A problem of a step, and which of its blocks earlier steps froze.
#[derive(Default)]
pub(super) struct StepProblem {
    pub builder: ProblemBuilder,
    /// And where their numbers stand among the [`CarriedErrors`].
    frozen: Vec<(BlockId, Range<usize>)>,
}

impl StepProblem {
    /// Adds a block of numbers that an earlier step froze, or that are exact.
    pub fn freeze(&mut self, block: Block, values: &[f64], places: Range<usize>) -> BlockId {
        let id = self.builder.add_block(block, values);
        self.frozen.push((id, places));
        id
    }
}

/// A solved step.
pub(super) struct StepFit {
    pub problem: Problem,
    pub estimate: Estimate,
    pub covariance: Covariance,
    pub degrees_of_freedom: usize,
    frozen: Frame,
}

/// How residuals and unknowns move with what is frozen.
struct Frame {
    /// Of each column: where its number stands among the [`CarriedErrors`].
    places: Vec<usize>,
    /// Of the unknowns, which follow.
    unknowns: DMatrix<f64>,
    /// Of the whitened residuals, with the unknowns following.
    residuals: DMatrix<f64>,
    /// The whitened residuals.
    left: DVector<f64>,
}

impl StepFit {
    /// Solves the step's problem; refuses it where the readings leave a direction open.
    pub fn solve(step: StepProblem, environment: &SolveEnvironment<'_>, cure: &str) -> Result<StepFit, Missing> {
        let refuse = |why: String| Missing::new(why, cure);
        let (open, initial) = step.builder.build().map_err(|e| refuse(e.to_string()))?;
        let fixed: Vec<BlockId> = step.frozen.iter().map(|(id, _)| *id).collect();
        let problem = open.with_fixed(&fixed, FROZEN);
        let estimate = environment.solve(&problem, &initial).map_err(|e| refuse(e.to_string()))?;
        if !estimate.termination.converged() {
            return Err(refuse(format!("the fit ended without an answer: {}", estimate.termination)));
        }
        let analysis = RankAnalysis::of(&problem, &estimate).map_err(|e| refuse(e.to_string()))?;
        if analysis.rank() < problem.columns().len() {
            return Err(refuse("the readings of this step leave a combination of its unknowns open".into()));
        }
        let covariance = analysis.covariance();
        let frozen = Frame::new((&open, &problem), &estimate.values, &step.frozen, &covariance);
        Ok(StepFit {
            degrees_of_freedom: problem.rows() - analysis.rank(),
            frozen: frozen.map_err(|e| refuse(e.to_string()))?,
            covariance,
            problem,
            estimate,
        })
    }

    pub fn values(&self) -> &Values {
        &self.estimate.values
    }

    /// A scalar block with its standard deviation, unless that exceeds `limit`.
    pub fn frozen(&self, id: BlockId, limit: f64, cure: &str) -> Result<Frozen, Missing> {
        let value = self.values().scalar(id);
        let std = self.problem.columns_of(id).next().map_or(0.0, |column| self.covariance.std(column));
        if std <= limit {
            Ok(Frozen { value, std })
        } else {
            let name = &self.problem.block(id).name;
            Err(Missing::new(
                format!("its step fixes {name} only to ±{std:.3}, more than {limit:.3}, which would be of use"),
                cure,
            ))
        }
    }

    /// Where the numbers of what was frozen stand among the [`CarriedErrors`].
    pub fn frozen_places(&self) -> Vec<usize> {
        self.frozen.places.clone()
    }

    /// Of the stored numbers of some blocks: covariance given what was frozen, and how they move with that.
    pub fn errors_of(&self, blocks: impl Iterator<Item = BlockId>) -> (DMatrix<f64>, DMatrix<f64>) {
        let blocks: Vec<BlockId> = blocks.collect();
        let functions = stored_coordinates(&self.problem, self.values(), &blocks);
        let own = self.covariance.of(&functions);
        let stored = DMatrix::from_fn(functions.len(), self.problem.columns().len(), |i, column| {
            functions[i].iter().filter(|(own, _)| *own == column).map(|(_, coefficient)| coefficient).sum::<f64>()
        });
        (DMatrix::from_row_slice(functions.len(), functions.len(), &own), stored * &self.frozen.unknowns)
    }

    /// χ² of the step's readings, with the errors that what was frozen may have: the least of `‖r + F δ‖² + δᵀ cov⁻¹ δ` over
    /// these errors δ, on as many degrees of freedom as without them.
    pub fn chi_squared(&self, earlier: &CarriedErrors) -> f64 {
        let Frame { places, residuals, left, .. } = &self.frozen;
        let covariance = earlier.of(places);
        let slope = residuals.transpose() * left;
        let stiffness = DMatrix::identity(places.len(), places.len()) + &covariance * residuals.transpose() * residuals;
        let allowed = match places.len() {
            0 => 0.0,
            _ => stiffness.lu().solve(&(covariance * &slope)).map_or(0.0, |errors| slope.dot(&errors)),
        };
        left.norm_squared() - allowed
    }
}

impl Frame {
    /// `open`: the problem with the frozen blocks free.
    fn new(
        (open, problem): (&Problem, &Problem),
        values: &Values,
        frozen: &[(BlockId, Range<usize>)],
        covariance: &Covariance,
    ) -> Result<Frame, EvaluateError> {
        let width = open.columns().len() + 1;
        let all = DMatrix::from_row_slice(open.rows(), width, &open.augmented_jacobian(values)?);
        let columns =
            |ids: &mut dyn Iterator<Item = BlockId>| -> Vec<usize> { ids.flat_map(|id| open.columns_of(id)).collect() };
        let free = &mut problem.block_ids().filter(|id| !problem.columns_of(*id).is_empty());
        let own = all.select_columns(&columns(free));
        let by_frozen = all.select_columns(&columns(&mut frozen.iter().map(|(id, _)| *id)));
        let size = problem.columns().len();
        let inverse = DMatrix::from_fn(size, size, |i, j| covariance.at(i, j));
        let unknowns = -inverse * own.transpose() * &by_frozen;
        Ok(Frame {
            places: frozen.iter().flat_map(|(_, places)| places.clone()).collect(),
            residuals: by_frozen + own * &unknowns,
            unknowns,
            left: all.column(width - 1).into_owned(),
        })
    }
}
