//! Collecting a problem, and checking it.

use std::collections::HashSet;
use std::sync::Arc;

use thiserror::Error;

use super::{Problem, offsets};
use crate::{Block, BlockId, Constraint, ConstraintError, Factor, LossWidth, Manifold, Values};

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
    /// A residual that reads a block of another problem.
    #[error("factor {factor} reads block number {block}, but there are only {blocks}: is it of another problem?")]
    Foreign {
        /// Position in the order of addition.
        factor: usize,
        /// Position of the block that it reads.
        block: usize,
        /// Number of blocks there are.
        blocks: usize,
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
        let problem = Problem::assemble(self.blocks, self.factors.into(), self.constraints, offsets);
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
            if id.index() >= blocks.len() {
                return Err(ProblemError::Foreign { factor: index, block: id.index(), blocks: blocks.len() });
            }
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
