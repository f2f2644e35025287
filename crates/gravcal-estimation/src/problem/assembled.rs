//! Blocks and factors put together: what a problem holds, and the same with something fixed, replaced or left out.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use super::check::{ProblemError, check_constraints, check_factors};
use super::offsets::offsets;
use super::structure::{RowPlan, Shape, Structure};
use crate::noise::{Weights, Whitener};
use crate::{Block, BlockId, Constraint, EvaluateError, Factor, Loss, Noise, Reference, Values};

/// Multiplications of an orthogonal factorization that take no longer than normal equations.
const SMALL: usize = 1_000;

fn fix(blocks: &mut [Block], ids: &[BlockId], reason: &str) {
    for id in ids {
        blocks[id.index()].fixed.get_or_insert_with(|| reason.to_owned());
    }
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
    blocks: Arc<[Block]>,
    pub(super) factors: Arc<[Factor]>,
    constraints: Vec<Constraint>,
    value_offsets: Arc<[usize]>,
    /// First column of each block, and the number of columns at the end.
    column_offsets: Arc<[usize]>,
    pub(super) columns: Arc<[Column]>,
    /// First row of each factor, and the number of rows at the end.
    pub(super) row_offsets: Arc<[usize]>,
    pub(super) structure: Arc<Structure>,
    reference: Option<Arc<Reference>>,
}

impl Problem {
    pub(super) fn assemble(
        blocks: Vec<Block>,
        factors: Arc<[Factor]>,
        constraints: Vec<Constraint>,
        value_offsets: Arc<[usize]>,
    ) -> Self {
        let column_offsets: Arc<[usize]> = offsets(blocks.iter().map(Block::tangent_dimension)).into();
        let columns: Arc<[Column]> = blocks
            .iter()
            .enumerate()
            .flat_map(|(block, b)| {
                (0..b.tangent_dimension()).map(move |index| Column { block: BlockId(block as u32), index })
            })
            .collect();
        let row_offsets = offsets(factors.iter().map(|f| f.residual.len())).into();
        let structure = Arc::new(Structure::new(&blocks, &factors, &column_offsets));
        let blocks = blocks.into();
        Problem {
            blocks,
            factors,
            constraints,
            value_offsets,
            column_offsets,
            columns,
            row_offsets,
            structure,
            reference: None,
        }
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

    /// The columns of one block; empty where it is fixed.
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

    /// The factor to which a row belongs.
    pub(crate) fn factor_of(&self, row: usize) -> usize {
        self.row_offsets.partition_point(|start| *start <= row) - 1
    }

    /// The same problem with more blocks fixed at their initial values.
    pub fn with_fixed(&self, ids: &[BlockId], reason: &str) -> Problem {
        if ids.iter().all(|id| self.block(*id).fixed.is_some()) {
            return self.clone();
        }
        let mut blocks = self.blocks.to_vec();
        fix(&mut blocks, ids, reason);
        let factors = Arc::clone(&self.factors);
        self.reassembled(blocks, factors)
    }

    /// The same with other blocks and factors; the reference stays.
    fn reassembled(&self, blocks: Vec<Block>, factors: Arc<[Factor]>) -> Problem {
        let assembled = Problem::assemble(blocks, factors, self.constraints.clone(), Arc::clone(&self.value_offsets));
        Problem { reference: self.reference.clone(), ..assembled }
    }

    /// The same with a reference prior, in place of the one that it may have.
    ///
    /// # Panics
    /// If the reference is about values of another problem.
    pub fn with_reference(&self, reference: Reference) -> Problem {
        assert!(reference.is_of(self), "the reference is about values of another problem");
        Problem { reference: Some(Arc::new(reference)), ..self.clone() }
    }

    /// The same without.
    pub fn without_reference(&self) -> Problem {
        Problem { reference: None, ..self.clone() }
    }

    /// Where unknowns rest of which the readings say nothing, if anywhere.
    pub fn reference(&self) -> Option<&Reference> {
        self.reference.as_deref()
    }

    /// The same with another loss of some factors, given by their positions. Losses are state: the structure stays.
    ///
    /// # Errors
    /// Where the loss has no width.
    ///
    /// # Panics
    /// If there are no such factors.
    pub fn with_loss(&self, factors: Range<usize>, loss: Loss) -> Result<Problem, ProblemError> {
        loss.checked().map_err(|source| ProblemError::Loss { factor: factors.start, source })?;
        let mut all = self.factors.to_vec();
        all[factors].iter_mut().for_each(|factor| factor.loss = loss);
        Ok(Problem { factors: all.into(), ..self.clone() })
    }

    /// The same without losses: each row counts by the root of the weight that its loss gives it at these values ([`Problem::weights`]). Where they solve
    /// this problem they solve that one, too.
    ///
    /// # Errors
    /// As [`Problem::residuals`].
    pub fn weighted_at(&self, values: &Values) -> Result<Problem, EvaluateError> {
        let weights = self.weights(values)?;
        let weighted = |(index, factor): (usize, &Factor)| {
            let weights = &weights[self.rows_of(index)];
            let noise = match &factor.noise {
                Noise::Independent(Weights(own)) => {
                    let rows = own.iter().zip(weights).map(|(own, weight)| own * weight.sqrt());
                    Noise::Independent(Weights(rows.collect()))
                }
                // They have one weight together.
                Noise::Correlated(Whitener(own)) => {
                    let root = weights.first().map_or(1.0, |weight| weight.sqrt());
                    Noise::Correlated(Whitener(own.iter().map(|entry| root * entry).collect()))
                }
            };
            Factor { noise, loss: Loss::None, ..factor.clone() }
        };
        let factors: Vec<Factor> = self.factors.iter().enumerate().map(weighted).collect();
        Ok(Problem { factors: factors.into(), ..self.clone() })
    }

    /// The same blocks with other factors: other noise, other samples.
    ///
    /// # Errors
    /// As [`build`](crate::ProblemBuilder::build), of the factors.
    pub fn with_factors(&self, factors: Vec<Factor>) -> Result<Problem, ProblemError> {
        self.rebuilt(&[], "", factors)
    }

    /// The same problem under other constraints.
    ///
    /// # Errors
    /// As [`build`](crate::ProblemBuilder::build), of the constraints.
    pub fn with_constraints(&self, constraints: Vec<Constraint>) -> Result<Problem, ProblemError> {
        check_constraints(&self.blocks, &constraints)?;
        Ok(Problem { constraints, ..self.clone() })
    }

    /// The same with blocks that none of these factors reads fixed at their initial values, for the stated reason.
    ///
    /// # Errors
    /// As [`Problem::with_factors`].
    pub fn with_only(&self, factors: Vec<Factor>, reason: &str) -> Result<Problem, ProblemError> {
        let read: BTreeSet<BlockId> = factors.iter().flat_map(|f| f.residual.blocks()).copied().collect();
        let unread: Vec<BlockId> = self.block_ids().filter(|id| !read.contains(id)).collect();
        self.rebuilt(&unread, reason, factors)
    }

    fn rebuilt(&self, fixed: &[BlockId], reason: &str, factors: Vec<Factor>) -> Result<Problem, ProblemError> {
        let mut blocks = self.blocks.to_vec();
        fix(&mut blocks, fixed, reason);
        check_factors(&blocks, &factors)?;
        Ok(self.reassembled(blocks, factors.into()))
    }

    /// Whether values have a number for each of its blocks: those of another problem may not.
    pub fn fits(&self, values: &Values) -> bool {
        values.offsets == self.value_offsets
    }

    /// What the unknowns must obey.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Whether an orthogonal factorization costs so little that the digits it spares need no second thought.
    pub(crate) fn is_small(&self) -> bool {
        self.structure.components.is_empty() && self.rows() * self.columns.len().pow(2) <= SMALL
    }

    /// First column of each block, and the number of columns at the end.
    pub(crate) fn column_offsets(&self) -> &Arc<[usize]> {
        &self.column_offsets
    }

    pub(super) fn shape_of(&self, factor: usize) -> &Shape {
        &self.structure.shapes[self.structure.shape_of[factor]]
    }

    /// How the shared columns of each row of a factor are picked.
    pub(crate) fn plans(&self, factor: usize) -> &[RowPlan] {
        &self.shape_of(factor).rows
    }

    /// The different lists of shared columns that the rows of a factor touch.
    pub(crate) fn column_lists(&self, factor: usize) -> &[Vec<usize>] {
        &self.shape_of(factor).columns
    }

    /// How it is laid out for linearization.
    pub(crate) fn structure(&self) -> &Structure {
        &self.structure
    }

    /// Moves every free block by its part of `step`.
    pub fn retract(&self, values: &Values, step: &[f64]) -> Values {
        let mut moved = values.clone();
        for (index, block) in self.blocks.iter().enumerate() {
            let columns = self.columns_of(BlockId(index as u32));
            if !columns.is_empty() {
                let range = self.value_offsets[index]..self.value_offsets[index + 1];
                block.manifold().retract(&mut moved.data[range], &step[columns]);
            }
        }
        moved
    }

    /// `∂(stored coordinates)/∂(columns)` of a free block: stored × tangent, row-major.
    pub fn tangent_basis(&self, values: &Values, id: BlockId) -> Vec<f64> {
        let (manifold, x) = (self.block(id).manifold(), values.get(id));
        let mut basis = vec![0.0; x.len() * manifold.tangent_dimension(x.len())];
        manifold.basis(x, &mut basis);
        basis
    }
}
