//! What Python says of a problem: objects with these attributes.

use std::sync::Arc;

use gravcal::estimation::{
    Affine, Block, BlockId, Constraint, Factor, Loss, LossName, Noise, Problem, ProblemBuilder, Sphere, Values,
};
use pyo3::prelude::*;

use super::residual::{PythonResidual, Raised};

/// A named group of unknowns.
#[derive(FromPyObject)]
pub struct SaidBlock {
    name: String,
    unit: String,
    components: Vec<String>,
    initial: Vec<f64>,
    held: Option<String>,
    linear: bool,
    /// The known length of a vector.
    length: Option<f64>,
}

impl SaidBlock {
    fn block(&self) -> Block {
        let components: Vec<&str> = self.components.iter().map(String::as_str).collect();
        let block = Block::vector(&self.name, &self.unit, &components);
        let block = self.length.map_or(block.clone(), |radius| block.on(Sphere { radius }));
        let block = if self.linear { block.linear() } else { block };
        self.held.as_ref().map_or(block.clone(), |reason| block.fixed(reason))
    }
}

/// Readings less what a model says of them.
#[derive(FromPyObject)]
pub struct SaidResidual {
    /// By their places.
    blocks: Vec<usize>,
    rows: usize,
    /// Of each row.
    std: Vec<f64>,
    /// Of all rows, row-major; instead of `std`.
    covariance: Option<Vec<f64>>,
    loss: String,
    width: Option<f64>,
    evaluate: Py<PyAny>,
}

impl SaidResidual {
    fn factor(self, ids: &[BlockId], raised: &Arc<Raised>) -> Result<Factor, String> {
        let noise = match &self.covariance {
            Some(covariance) => Noise::correlated(covariance, self.rows),
            None => Noise::independent(&self.std),
        };
        let loss: LossName = self.loss.parse().map_err(reported)?;
        let loss: Loss = self.width.map_or(loss.efficient(), |width| loss.with_width(width));
        let blocks = self.blocks.iter().map(|place| ids[*place]).collect();
        let raised = Arc::clone(raised);
        let residual = PythonResidual { blocks, rows: self.rows, evaluate: self.evaluate, raised };
        Ok(Factor::new(residual, noise.map_err(reported)?).with_loss(loss))
    }
}

/// `constant + Σ coefficient · component`, with block and component by their places.
#[derive(FromPyObject)]
pub struct SaidAffine {
    terms: Vec<(usize, usize, f64)>,
    constant: f64,
}

impl SaidAffine {
    fn affine(&self, ids: &[BlockId]) -> Affine {
        let terms = self.terms.iter().map(|(block, component, factor)| (ids[*block], *component, *factor)).collect();
        Affine { terms, constant: self.constant }
    }
}

/// What unknowns must obey.
#[derive(FromPyObject)]
pub enum SaidConstraint {
    /// `lower ≤ function ≤ upper`.
    Range { name: String, function: SaidAffine, lower: f64, upper: f64 },
    /// `‖norm_of‖ ≤ at_most`.
    Cone { name: String, norm_of: Vec<SaidAffine>, at_most: SaidAffine },
    /// `‖block‖ = length`.
    Length { name: String, block: usize, length: f64 },
}

impl SaidConstraint {
    fn constraint(&self, ids: &[BlockId]) -> Constraint {
        match self {
            SaidConstraint::Range { name, function, lower, upper } => {
                Constraint::range(name, function.affine(ids), *lower, *upper)
            }
            SaidConstraint::Cone { name, norm_of, at_most } => {
                Constraint::cone(name, norm_of.iter().map(|part| part.affine(ids)).collect(), at_most.affine(ids))
            }
            SaidConstraint::Length { name, block, length } => Constraint::length(name, ids[*block], *length),
        }
    }
}

/// All of it, as a problem with its start.
pub fn problem(
    blocks: &[SaidBlock],
    residuals: Vec<SaidResidual>,
    constraints: &[SaidConstraint],
    raised: &Arc<Raised>,
) -> Result<(Problem, Values), String> {
    let mut builder = ProblemBuilder::new();
    let ids: Vec<BlockId> = blocks.iter().map(|said| builder.add_block(said.block(), &said.initial)).collect();
    for said in residuals {
        builder.add_factor(said.factor(&ids, raised)?);
    }
    constraints.iter().for_each(|said| builder.add_constraint(said.constraint(&ids)));
    builder.build().map_err(reported)
}

fn reported(error: impl std::error::Error) -> String {
    error.to_string()
}
