//! The problem: blocks and factors, immutable once built. It only holds and evaluates; solving is elsewhere.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use thiserror::Error;

use crate::{
    Block, BlockId, Constraint, ConstraintError, DenseLinearization, EvaluateError, Factor, Linearization, LocalValues,
    LossWidth, Manifold, RowsMut, Values,
};

/// Factors evaluated by one task: fixed, so that the work is cut the same way on any number of threads.
const FACTORS_PER_BATCH: usize = 64;

/// Collects blocks and factors.
#[derive(Debug, Default)]
pub struct ProblemBuilder {
    blocks: Vec<Block>,
    initial: Vec<f64>,
    factors: Vec<Factor>,
    constraints: Vec<Constraint>,
}

/// Something that makes a problem unanswerable.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProblemError {
    /// Nothing was measured.
    #[error("no factors: the problem has no measurement")]
    NoFactors,
    /// Nothing is unknown.
    #[error("no unknowns: every block is held")]
    NoUnknowns,
    /// A free block that no factor reads.
    #[error("nothing reads the unknown `{0}`: hold it, or add a measurement of it")]
    Unread(String),
    /// Two blocks of one name.
    #[error("two blocks are named `{0}`")]
    DuplicateName(String),
    /// An initial value that is not finite, or not on the block's manifold.
    #[error("the initial value {value:?} of `{block}` {reason}")]
    Initial {
        /// The block.
        block: String,
        /// Its value.
        value: Vec<f64>,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A factor whose residual and noise have different numbers of rows.
    #[error("factor {factor} has {rows} residuals but noise for {noise}")]
    NoiseRows {
        /// Position in the order of addition.
        factor: usize,
        /// Rows of the residual.
        rows: usize,
        /// Rows of the noise.
        noise: usize,
    },
    /// A loss without a width.
    #[error("factor {factor}: {source}")]
    Loss {
        /// Position in the order of addition.
        factor: usize,
        /// What is wrong with it.
        source: LossWidth,
    },
    /// A residual that reads a block twice.
    #[error("factor {factor} reads `{block}` twice")]
    ReadTwice {
        /// Position in the order of addition.
        factor: usize,
        /// The block.
        block: String,
    },
    /// A constraint that makes no sense.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
}

impl ProblemBuilder {
    /// An empty problem.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a block with its initial value.
    ///
    /// # Panics
    /// If `initial` has another length than the block.
    pub fn add_block(&mut self, block: Block, initial: &[f64]) -> BlockId {
        assert_eq!(block.len(), initial.len(), "initial value of `{}`", block.name);
        let id = BlockId(self.blocks.len() as u32);
        self.blocks.push(block);
        self.initial.extend_from_slice(initial);
        id
    }

    /// Adds a factor.
    pub fn add_factor(&mut self, factor: Factor) {
        self.factors.push(factor);
    }

    /// Adds a constraint.
    pub fn add_constraint(&mut self, constraint: Constraint) {
        self.constraints.push(constraint);
    }

    /// The initial values of the blocks so far.
    pub fn initial(&self) -> Values {
        Values { data: self.initial.clone(), offsets: offsets(self.blocks.iter().map(Block::len)).into() }
    }

    /// Checks everything and fixes the layout. Gives the problem and the initial values.
    ///
    /// # Errors
    /// See [`ProblemError`].
    pub fn build(self) -> Result<(Problem, Values), ProblemError> {
        let initial = self.initial();
        check_blocks(&self.blocks, &initial)?;
        check_factors(&self.blocks, &self.factors)?;
        let stored: Vec<usize> = self.blocks.iter().map(Block::len).collect();
        self.constraints.iter().try_for_each(|constraint| constraint.check(&stored))?;
        let offsets = Arc::clone(&initial.offsets);
        let problem = Problem::assemble(self.blocks, self.factors, self.constraints, offsets);
        if problem.columns.is_empty() { Err(ProblemError::NoUnknowns) } else { Ok((problem, initial)) }
    }
}

fn check_blocks(blocks: &[Block], initial: &Values) -> Result<(), ProblemError> {
    let mut names = HashSet::new();
    for (index, block) in blocks.iter().enumerate() {
        if !names.insert(block.name.as_str()) {
            return Err(ProblemError::DuplicateName(block.name.clone()));
        }
        let value = initial.get(BlockId(index as u32));
        let refuse = |reason| ProblemError::Initial { block: block.name.clone(), value: value.to_vec(), reason };
        if value.iter().any(|v| !v.is_finite()) {
            return Err(refuse("is not finite"));
        }
        if let Manifold::Sphere { radius } = block.manifold {
            let norm = value.iter().map(|v| v * v).sum::<f64>().sqrt();
            if (norm - radius).abs() > 1e-9 * radius {
                return Err(refuse("does not have the length of its sphere"));
            }
        }
    }
    Ok(())
}

fn check_factors(blocks: &[Block], factors: &[Factor]) -> Result<(), ProblemError> {
    if factors.is_empty() {
        return Err(ProblemError::NoFactors);
    }
    let mut read = vec![false; blocks.len()];
    for (index, factor) in factors.iter().enumerate() {
        let (rows, noise) = (factor.residual.len(), factor.noise.rows());
        if rows != noise || rows == 0 {
            return Err(ProblemError::NoiseRows { factor: index, rows, noise });
        }
        factor.loss.checked().map_err(|source| ProblemError::Loss { factor: index, source })?;
        let mut own = HashSet::new();
        for id in factor.residual.blocks() {
            if !own.insert(id) {
                return Err(ProblemError::ReadTwice { factor: index, block: blocks[id.index()].name.clone() });
            }
            read[id.index()] = true;
        }
    }
    match blocks.iter().zip(&read).find(|(block, read)| block.held.is_none() && !**read) {
        Some((block, _)) => Err(ProblemError::Unread(block.name.clone())),
        None => Ok(()),
    }
}

fn offsets(lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut offsets = vec![0];
    let mut total = 0;
    for length in lengths {
        total += length;
        offsets.push(total);
    }
    offsets
}

/// One tangent coordinate of a free block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// The block.
    pub block: BlockId,
    /// Which of its tangent coordinates.
    pub index: usize,
}

/// Blocks with names and units, and the factors between them.
#[derive(Clone, Debug)]
pub struct Problem {
    blocks: Vec<Block>,
    factors: Vec<Factor>,
    constraints: Vec<Constraint>,
    value_offsets: Arc<[usize]>,
    /// First column of each block, and the number of columns at the end.
    column_offsets: Vec<usize>,
    columns: Vec<Column>,
    /// First row of each factor, and the number of rows at the end.
    row_offsets: Vec<usize>,
    /// Local stored offsets of each factor's blocks.
    local_offsets: Vec<Vec<usize>>,
}

impl Problem {
    fn assemble(
        blocks: Vec<Block>,
        factors: Vec<Factor>,
        constraints: Vec<Constraint>,
        value_offsets: Arc<[usize]>,
    ) -> Self {
        let column_offsets = offsets(blocks.iter().map(Block::tangent_dimension));
        let columns = blocks
            .iter()
            .enumerate()
            .flat_map(|(block, b)| {
                (0..b.tangent_dimension()).map(move |index| Column { block: BlockId(block as u32), index })
            })
            .collect();
        let row_offsets = offsets(factors.iter().map(|f| f.residual.len()));
        let local_offsets =
            factors.iter().map(|f| offsets(f.residual.blocks().iter().map(|id| blocks[id.index()].len()))).collect();
        Problem { blocks, factors, constraints, value_offsets, column_offsets, columns, row_offsets, local_offsets }
    }

    /// All blocks, in the order of addition.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Names of all blocks, in the order of addition.
    pub fn block_ids(&self) -> impl Iterator<Item = BlockId> + use<> {
        (0..self.blocks.len() as u32).map(BlockId)
    }

    /// One block.
    pub fn block(&self, id: BlockId) -> &Block {
        &self.blocks[id.index()]
    }

    /// The block of this name.
    pub fn find(&self, name: &str) -> Option<BlockId> {
        self.blocks.iter().position(|b| b.name == name).map(|index| BlockId(index as u32))
    }

    /// All factors, in the order of addition.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Tangent coordinates of the free blocks, one a column of the Jacobian.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The columns of one block; empty where it is held.
    pub fn columns_of(&self, id: BlockId) -> Range<usize> {
        self.column_offsets[id.index()]..self.column_offsets[id.index() + 1]
    }

    /// Number of residual rows.
    pub fn rows(&self) -> usize {
        self.row_offsets.last().copied().unwrap_or(0)
    }

    /// The rows of one factor.
    pub fn rows_of(&self, factor: usize) -> Range<usize> {
        self.row_offsets[factor]..self.row_offsets[factor + 1]
    }

    /// The same problem with more blocks held at their initial values.
    pub fn holding(&self, ids: &[BlockId], reason: &str) -> Problem {
        let mut blocks = self.blocks.clone();
        for id in ids {
            blocks[id.index()].held.get_or_insert_with(|| reason.to_owned());
        }
        Problem::assemble(blocks, self.factors.clone(), self.constraints.clone(), Arc::clone(&self.value_offsets))
    }

    /// The same blocks with other factors: other losses, other samples.
    ///
    /// # Errors
    /// As [`ProblemBuilder::build`], of the factors.
    pub fn with_factors(&self, factors: Vec<Factor>) -> Result<Problem, ProblemError> {
        check_factors(&self.blocks, &factors)?;
        let (blocks, constraints) = (self.blocks.clone(), self.constraints.clone());
        Ok(Problem::assemble(blocks, factors, constraints, Arc::clone(&self.value_offsets)))
    }

    /// What the unknowns must obey.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Linearizes at `values`, in the form that suits the problem's size and structure.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn linearize<'p>(&'p self, values: &Values) -> Result<Box<dyn Linearization + 'p>, EvaluateError> {
        Ok(Box::new(DenseLinearization::new(self, values)?))
    }

    /// Whitened residuals at `values`, one a row.
    ///
    /// # Errors
    /// Where a model has no value there, or gives one that is not finite.
    pub fn residuals(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        let mut rows = vec![0.0; self.rows()];
        self.for_each_batch(&mut rows, 1, |this, factor, out, scratch| {
            this.evaluate_factor(values, factor, out, None, scratch)
        })?;
        Ok(rows)
    }

    /// Cost ½ Σ ρ of the whitened residuals, with ρ each factor's loss.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn cost(&self, values: &Values) -> Result<f64, EvaluateError> {
        let residuals = self.residuals(values)?;
        let of_factor = |(index, factor): (usize, &Factor)| factor.cost(&residuals[self.rows_of(index)]);
        Ok(self.factors.iter().enumerate().map(of_factor).sum())
    }

    /// Weight ρ′ of every row: 1 where the reading counts fully, near 0 where its loss takes it for an outlier.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn weights(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        let residuals = self.residuals(values)?;
        let of_factor = |(index, factor): (usize, &Factor)| factor.weights(&residuals[self.rows_of(index)]);
        Ok(self.factors.iter().enumerate().flat_map(of_factor).collect())
    }

    /// Whitened `[J r]` by the tangent coordinates, before any loss: one row a residual, the residual last, row-major.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn augmented_jacobian(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        self.augmented(values, |_, _, _| ())
    }

    /// The same with every factor's loss, so that `J̃ᵀ r̃` is the gradient of the cost and `J̃ᵀ J̃` its curvature.
    pub(crate) fn corrected_jacobian(&self, values: &Values) -> Result<Vec<f64>, EvaluateError> {
        self.augmented(values, Factor::correct)
    }

    fn augmented(
        &self,
        values: &Values,
        correct: impl Fn(&Factor, &mut [f64], usize) + Sync,
    ) -> Result<Vec<f64>, EvaluateError> {
        let width = self.columns.len() + 1;
        let mut rows = vec![0.0; self.rows() * width];
        self.for_each_batch(&mut rows, width, |this, factor, out, scratch| {
            this.linearize_factor(values, factor, out, scratch)?;
            correct(&this.factors[factor], out, width);
            Ok(())
        })?;
        Ok(rows)
    }

    /// Moves every free block by its part of `step`.
    pub fn retract(&self, values: &Values, step: &[f64]) -> Values {
        let mut moved = values.clone();
        for (index, block) in self.blocks.iter().enumerate() {
            let columns = self.columns_of(BlockId(index as u32));
            if !columns.is_empty() {
                let range = self.value_offsets[index]..self.value_offsets[index + 1];
                block.manifold.retract(&mut moved.data[range], &step[columns]);
            }
        }
        moved
    }

    /// `∂(stored coordinates)/∂(columns)` of a free block: stored × tangent, row-major.
    pub fn tangent_basis(&self, values: &Values, id: BlockId) -> Vec<f64> {
        let block = self.block(id);
        match block.manifold.basis(values.get(id)) {
            Some(basis) => basis.to_vec(),
            None => (0..block.len() * block.len()).map(|k| f64::from(k % (block.len() + 1) == 0)).collect(),
        }
    }

    /// Runs `task` on every factor, batches in parallel, each writing only its own rows of `width` numbers.
    fn for_each_batch<F>(&self, rows: &mut [f64], width: usize, task: F) -> Result<(), EvaluateError>
    where
        F: Fn(&Self, usize, &mut [f64], &mut Scratch) -> Result<(), EvaluateError> + Sync,
    {
        let mut batches = Vec::new();
        let mut rest = rows;
        for start in (0..self.factors.len()).step_by(FACTORS_PER_BATCH) {
            let end = (start + FACTORS_PER_BATCH).min(self.factors.len());
            let (batch, tail) = rest.split_at_mut((self.row_offsets[end] - self.row_offsets[start]) * width);
            batches.push((start..end, batch));
            rest = tail;
        }
        let run = |(factors, mut rows): (Range<usize>, &mut [f64])| {
            let mut scratch = Scratch::default();
            for factor in factors {
                let (own, tail) = rows.split_at_mut(self.rows_of(factor).len() * width);
                task(self, factor, own, &mut scratch)?;
                rows = tail;
            }
            Ok(())
        };
        // The first error in the order of the factors, whichever task met its own first.
        let outcomes: Vec<Result<(), EvaluateError>> = if batches.len() < 4 {
            batches.into_iter().map(run).collect()
        } else {
            batches.into_par_iter().map(run).collect()
        };
        outcomes.into_iter().collect()
    }

    fn evaluate_factor(
        &self,
        values: &Values,
        factor: usize,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
        scratch: &mut Scratch,
    ) -> Result<(), EvaluateError> {
        let Factor { residual: model, noise, .. } = &self.factors[factor];
        scratch.local.clear();
        for id in model.blocks() {
            scratch.local.extend_from_slice(values.get(*id));
        }
        model.evaluate(LocalValues::new(&scratch.local, &self.local_offsets[factor]), residual, jacobian)?;
        if let Some(row) = residual.iter().position(|r| !r.is_finite()) {
            return Err(self.not_finite(factor, row, residual[row], values));
        }
        noise.whiten(residual, 1);
        Ok(())
    }

    fn linearize_factor(
        &self,
        values: &Values,
        factor: usize,
        out: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), EvaluateError> {
        let Factor { residual: model, noise, .. } = &self.factors[factor];
        let (rows, width) = (model.len(), self.columns.len() + 1);
        let local_width = self.local_offsets[factor].last().copied().unwrap_or(0);
        let mut jacobian = std::mem::take(&mut scratch.jacobian);
        let mut residual = std::mem::take(&mut scratch.residual);
        jacobian.clear();
        jacobian.resize(rows * local_width, 0.0);
        residual.clear();
        residual.resize(rows, 0.0);
        let local_rows = RowsMut::new(&mut jacobian, local_width);
        self.evaluate_factor(values, factor, &mut residual, Some(local_rows), scratch)?;
        if let Some(at) = jacobian.iter().position(|v| !v.is_finite()) {
            return Err(self.not_finite(factor, at / local_width.max(1), f64::NAN, values));
        }
        noise.whiten(&mut jacobian, local_width);
        for row in 0..rows {
            out[row * width + width - 1] = residual[row];
        }
        for (local, id) in model.blocks().iter().enumerate() {
            let stored = self.local_offsets[factor][local]..self.local_offsets[factor][local + 1];
            self.scatter(values, *id, &jacobian, local_width, stored, out);
        }
        scratch.jacobian = jacobian;
        scratch.residual = residual;
        Ok(())
    }

    /// Adds a block's stored columns to its tangent columns: `J_tangent += J_stored · B`.
    fn scatter(
        &self,
        values: &Values,
        id: BlockId,
        jacobian: &[f64],
        local_width: usize,
        stored: Range<usize>,
        out: &mut [f64],
    ) {
        let columns = self.columns_of(id);
        if columns.is_empty() {
            return;
        }
        let basis = self.block(id).manifold.basis(values.get(id));
        let width = self.columns.len() + 1;
        for (local_row, out_row) in jacobian.chunks_exact(local_width).zip(out.chunks_exact_mut(width)) {
            let (source, target) = (&local_row[stored.clone()], &mut out_row[columns.clone()]);
            match basis {
                None => target.iter_mut().zip(source).for_each(|(t, s)| *t += s),
                Some(basis) => {
                    for (t, value) in target.iter_mut().enumerate() {
                        *value += (0..source.len()).map(|s| source[s] * basis[s * 2 + t]).sum::<f64>();
                    }
                }
            }
        }
    }

    fn not_finite(&self, factor: usize, row: usize, value: f64, values: &Values) -> EvaluateError {
        let at: Vec<String> = self.factors[factor]
            .residual
            .blocks()
            .iter()
            .map(|id| format!("{} = {:?}", self.block(*id).name, values.get(*id)))
            .collect();
        EvaluateError(format!("row {row} of factor {factor} gives {value} at {}", at.join(", ")))
    }
}

#[derive(Default)]
struct Scratch {
    local: Vec<f64>,
    jacobian: Vec<f64>,
    residual: Vec<f64>,
}
