//! What makes blocks, constraints and factors a problem, and what is said of those that make none.

use std::collections::HashSet;

use thiserror::Error;

use crate::{Block, BlockId, Constraint, ConstraintError, Factor, LossWidth, Values};

/// Something that makes a problem unanswerable.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ProblemError {
    /// Nothing was measured.
    #[error("no factors: the problem has no measurement")]
    NoFactors,
    /// Nothing is unknown.
    #[error("no unknowns: every block is fixed")]
    NoUnknowns,
    /// A free block that no factor reads.
    #[error("nothing reads the unknown `{0}`: hold it, or add a measurement of it")]
    Unread(String),
    /// A block that stores nothing.
    #[error("`{0}` has no numbers: give it components, or leave it away")]
    Empty(String),
    /// A block or a constraint without a name, the how-many-th counted from 0.
    #[error("{0} {1} has no name")]
    Nameless(&'static str, usize),
    /// Two constraints of one name.
    #[error("two constraints are named `{0}`")]
    DuplicateConstraint(String),
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
        reason: String,
    },
    /// A factor without a residual.
    #[error("factor {0} has no residuals: leave it away")]
    NoRows(usize),
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
    /// A residual that wrote beyond the rows or columns it has, or failed otherwise inside.
    #[error(
        "factor {factor} (of {blocks}) panicked at the initial values: {message}. Does it write a row or a column that \
         it does not have? `check_derivatives` tells more"
    )]
    Panicked {
        /// Position in the order of addition.
        factor: usize,
        /// Names of the blocks that it reads.
        blocks: String,
        /// What it said.
        message: String,
    },
    /// A constraint that makes no sense.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
}

pub(super) fn check_blocks(blocks: &[Block], initial: &Values) -> Result<(), ProblemError> {
    let mut names = HashSet::new();
    for (index, block) in blocks.iter().enumerate() {
        if block.name.is_empty() {
            return Err(ProblemError::Nameless("block", index));
        }
        if block.is_empty() {
            return Err(ProblemError::Empty(block.name.clone()));
        }
        if !names.insert(block.name.as_str()) {
            return Err(ProblemError::DuplicateName(block.name.clone()));
        }
        let value = initial.get(BlockId(index as u32));
        let refuse = |reason| ProblemError::Initial { block: block.name.clone(), value: value.to_vec(), reason };
        if value.iter().any(|v| !v.is_finite()) {
            return Err(refuse("is not finite".into()));
        }
        block.manifold().check(value).map_err(refuse)?;
    }
    Ok(())
}

pub(super) fn check_constraints(blocks: &[Block], constraints: &[Constraint]) -> Result<(), ProblemError> {
    let stored: Vec<usize> = blocks.iter().map(Block::len).collect();
    let mut names = HashSet::new();
    for (index, constraint) in constraints.iter().enumerate() {
        if constraint.name.is_empty() {
            return Err(ProblemError::Nameless("constraint", index));
        }
        if !names.insert(constraint.name.as_str()) {
            return Err(ProblemError::DuplicateConstraint(constraint.name.clone()));
        }
        constraint.check(&stored)?;
    }
    Ok(())
}

pub(super) fn check_factors(blocks: &[Block], factors: &[Factor]) -> Result<(), ProblemError> {
    if factors.is_empty() {
        return Err(ProblemError::NoFactors);
    }
    // By block, the last factor so far that reads it.
    let mut read: Vec<Option<usize>> = vec![None; blocks.len()];
    for (index, factor) in factors.iter().enumerate() {
        let (rows, noise) = (factor.residual.len(), factor.noise.rows());
        if rows == 0 {
            return Err(ProblemError::NoRows(index));
        }
        if rows != noise {
            return Err(ProblemError::NoiseRows { factor: index, rows, noise });
        }
        factor.loss.checked().map_err(|source| ProblemError::Loss { factor: index, source })?;
        for id in factor.residual.blocks() {
            if id.index() >= blocks.len() {
                return Err(ProblemError::Foreign { factor: index, block: id.index(), blocks: blocks.len() });
            }
            if read[id.index()].replace(index) == Some(index) {
                return Err(ProblemError::ReadTwice { factor: index, block: blocks[id.index()].name.clone() });
            }
        }
    }
    match blocks.iter().zip(&read).find(|(block, read)| block.fixed.is_none() && read.is_none()) {
        Some((block, _)) => Err(ProblemError::Unread(block.name.clone())),
        None => Ok(()),
    }
}
