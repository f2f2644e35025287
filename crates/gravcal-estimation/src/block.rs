//! Parameter blocks: named groups of numbers, and the values of all of them.

use std::sync::Arc;

use crate::Manifold;
use crate::manifold::Euclidean;

/// Names a block of one [`Problem`](crate::Problem). Obtained from
/// [`ProblemBuilder::add_block`](crate::ProblemBuilder::add_block).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlockId(pub(crate) u32);

impl BlockId {
    /// Position of the block in the order of addition.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A named group of unknowns that belong together (a gain; a vector).
#[derive(Clone, Debug)]
pub struct Block {
    /// Unique name, such as `joint1.torque_gain`.
    pub name: String,
    /// Unit of every component, such as `count/(N·m)`; the empty string for a pure number.
    pub units: Vec<String>,
    /// Names of the components, such as `x`, `y`, `z`; for a block of one number, the empty string.
    pub components: Vec<String>,
    /// Where the values live; all of ℝⁿ without.
    curved: Option<Arc<dyn Manifold>>,
    /// Why the block is fixed at its initial value, if it is.
    pub fixed: Option<String>,
    /// Whether it belongs to a few factors only, as the unknowns of one pose do: see [`Block::eliminated`].
    pub eliminated: bool,
    /// Whether the residuals are affine in it: see [`Block::linear`].
    pub linear: bool,
}

impl Block {
    /// A free block of one number.
    pub fn scalar(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Block {
            name: name.into(),
            units: vec![unit.into()],
            components: vec![String::new()],
            curved: None,
            fixed: None,
            eliminated: false,
            linear: false,
        }
    }

    /// A free block of several numbers of one unit.
    pub fn vector(name: impl Into<String>, unit: &str, components: &[&str]) -> Self {
        Block {
            name: name.into(),
            units: vec![unit.to_owned(); components.len()],
            components: components.iter().map(|c| (*c).to_owned()).collect(),
            curved: None,
            fixed: None,
            eliminated: false,
            linear: false,
        }
    }

    /// The same block on a manifold, such as a [`Sphere`](crate::Sphere).
    #[must_use]
    pub fn on(self, manifold: impl Manifold + 'static) -> Self {
        Block { curved: Some(Arc::new(manifold)), ..self }
    }

    /// The same block fixed at its initial value, for the stated reason.
    #[must_use]
    pub fn fixed(self, reason: impl Into<String>) -> Self {
        Block { fixed: Some(reason.into()), ..self }
    }

    /// The same block as one of a kind that grows with the data (the unknowns of one pose). Such blocks are eliminated
    /// before the rest, so that cost and memory grow linearly with their number; the result is the same.
    #[must_use]
    pub fn eliminated(self) -> Self {
        Block { eliminated: true, ..self }
    }

    /// The same block as one of those in which, all taken together, every residual is affine.
    #[must_use]
    pub fn linear(self) -> Self {
        Block { linear: true, ..self }
    }

    /// Where the values live.
    pub fn manifold(&self) -> &dyn Manifold {
        self.curved.as_deref().unwrap_or(&Euclidean)
    }

    /// Whether its values are all of ℝⁿ and a step is added to them: whether it is [on](Block::on) no manifold.
    pub fn is_euclidean(&self) -> bool {
        self.curved.is_none()
    }

    /// How many numbers store the block.
    pub fn len(&self) -> usize {
        self.units.len()
    }

    /// Whether the block stores nothing.
    pub fn is_empty(&self) -> bool {
        self.units.is_empty()
    }

    /// Dimension of a step of this block: zero where it is fixed.
    pub fn tangent_dimension(&self) -> usize {
        if self.fixed.is_some() { 0 } else { self.manifold().tangent_dimension(self.len()) }
    }

    /// Name of stored component `index`: `gravity.x`, or only the block's name where it is one number.
    pub fn component_name(&self, index: usize) -> String {
        match self.components[index].as_str() {
            "" => self.name.clone(),
            component => format!("{}.{component}", self.name),
        }
    }
}

/// The stored coordinates of every block of a problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    pub(crate) data: Vec<f64>,
    /// Start of each block in `data`, and the total length at the end.
    pub(crate) offsets: Arc<[usize]>,
}

impl Values {
    /// The numbers of one block.
    pub fn get(&self, id: BlockId) -> &[f64] {
        &self.data[self.offsets[id.index()]..self.offsets[id.index() + 1]]
    }

    /// The number of a block that stores one.
    pub fn scalar(&self, id: BlockId) -> f64 {
        self.get(id)[0]
    }

    /// Replaces the numbers of one block.
    ///
    /// # Panics
    /// If `value` has another length than the block.
    pub fn set(&mut self, id: BlockId, value: &[f64]) {
        self.data[self.offsets[id.index()]..self.offsets[id.index() + 1]].copy_from_slice(value);
    }

    /// All numbers, block after block.
    pub fn as_slice(&self) -> &[f64] {
        &self.data
    }
}
