//! Problems with published solutions: each written once with its source, its starts and its minima, to be run by every
//! solver.
//!
//! ```text
//!     minimise over b  Σ_i r_i(b)²
//! ```
//!
//! Two collections: [`more_garbow_hillstrom`], where methods get lost, and [`nist`], where digits do. All numbers are
//! pure, every row has the weight one, and every parameter is a block of its own; derivatives are automatic.
//!
//! ```
//! let problem = &gravcal_estimation::published::more_garbow_hillstrom()[0];
//! assert_eq!(problem.name, "Rosenbrock");
//! let (built, start) = problem.build(&problem.starts[0])?;
//! assert!(problem.minimum_at(2.0 * built.cost(&start)?).is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod more_garbow_hillstrom;
pub mod nist;

use std::sync::Arc;

pub use more_garbow_hillstrom::more_garbow_hillstrom;

use crate::noise::Weights;
use crate::{
    Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, Problem, ProblemBuilder,
    ProblemError, Values,
};
use more_garbow_hillstrom::Function;
use nist::Regression;

/// A sum of squares that has reached a published minimum agrees with it to this share; minima are published to six
/// digits.
const MINIMUM_TOLERANCE: f64 = 1e-5;

/// A sum of squares below this has reached a published minimum of zero. The residuals of the problems in question
/// are of the size of one.
const ZERO: f64 = 1e-16;

/// A least-squares problem with its published solution.
#[derive(Clone, Debug)]
pub struct PublishedProblem {
    /// Its usual name.
    pub name: String,
    /// Where it is published.
    pub source: String,
    /// Names of the parameters, each a block of one number.
    pub parameters: Vec<String>,
    /// Indices of parameters in which, all taken together, the rows are affine: their blocks are marked as
    /// [linear](Block::linear).
    pub linear: Vec<usize>,
    /// Number of rows.
    pub rows: usize,
    /// Where to start from.
    pub starts: Vec<Start>,
    /// The published minima: the global one and, where they are known, local ones and those at infinity.
    pub minima: Vec<Minimum>,
    equations: Equations,
}

/// A point to start from.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// What it is called, such as `10 × standard`.
    pub name: String,
    /// One number a parameter.
    pub values: Vec<f64>,
    /// Why no published minimum is to be expected from here, where that is so.
    pub unreachable: Option<&'static str>,
}

/// A published minimum.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// Σ r².
    pub sum_of_squares: f64,
    /// Where it is, if that is published and a single point.
    pub parameters: Option<Vec<f64>>,
}

impl PublishedProblem {
    /// The problem, and the start as its values: one block a parameter, in the order of
    /// [`parameters`](PublishedProblem::parameters).
    ///
    /// # Errors
    /// Where the start has another number of values than there are parameters, or one that is not finite.
    pub fn build(&self, start: &Start) -> Result<(Problem, Values), ProblemError> {
        let mut builder = ProblemBuilder::new();
        let blocks = self.parameters.iter().zip(&start.values).enumerate();
        let blocks = blocks.map(|(index, (name, value))| {
            let block = Block::scalar(name, "");
            let block = if self.linear.contains(&index) { block.linear() } else { block };
            builder.add_block(block, &[*value])
        });
        let blocks = blocks.collect();
        let formula = Built { blocks, rows: self.rows, equations: self.equations.clone() };
        builder.add_factor(Factor::new(Automatic(formula), Noise::Independent(Weights(vec![1.0; self.rows].into()))));
        builder.build()
    }

    /// The published minimum that this sum of squares has reached, if any.
    pub fn minimum_at(&self, sum_of_squares: f64) -> Option<&Minimum> {
        self.minima.iter().find(|minimum| {
            let tolerance = (MINIMUM_TOLERANCE * minimum.sum_of_squares).max(ZERO);
            (sum_of_squares - minimum.sum_of_squares).abs() <= tolerance
        })
    }
}

/// The rows as functions of the parameters.
#[derive(Clone, Debug)]
enum Equations {
    MoreGarbowHillstrom(Function),
    Nist(Arc<Regression>),
}

/// A published problem over the blocks of one [`Problem`].
#[derive(Debug)]
struct Built {
    blocks: Vec<BlockId>,
    rows: usize,
    equations: Equations,
}

impl Formula for Built {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows
    }

    fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        match &self.equations {
            Equations::MoreGarbowHillstrom(function) => function.evaluate(x.as_slice(), residual),
            Equations::Nist(regression) => regression.evaluate(x.as_slice(), residual),
        }
        Ok(())
    }
}
