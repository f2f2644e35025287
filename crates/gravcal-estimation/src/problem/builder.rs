//! Collecting a problem, and checking it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::assembled::Problem;
use super::check::{ProblemError, check_blocks, check_constraints, check_factors};
use super::evaluate::Rows;
use super::offsets::offsets;
use crate::derivative_check::panic_message;
use crate::{Block, BlockId, Constraint, Factor, Values};

/// Collects blocks and factors.
#[derive(Debug, Default)]
pub struct ProblemBuilder {
    blocks: Vec<Block>,
    initial: Vec<f64>,
    factors: Vec<Factor>,
    constraints: Vec<Constraint>,
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

    /// A block that was added.
    pub fn block(&self, id: BlockId) -> &Block {
        &self.blocks[id.index()]
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
        check_constraints(&self.blocks, &self.constraints)?;
        let offsets = Arc::clone(&initial.offsets);
        let problem = Problem::assemble(self.blocks, self.factors.into(), self.constraints, offsets);
        if problem.columns.is_empty() {
            return Err(ProblemError::NoUnknowns);
        }
        try_every_shape(&problem, &initial)?;
        Ok((problem, initial))
    }
}

/// Evaluates one factor of every shape, so that a residual that does not keep to its own is told by name before anything relies on
/// it. A factor that has no value at the initial point is left to the solver.
fn try_every_shape(problem: &Problem, initial: &Values) -> Result<(), ProblemError> {
    let mut rows = Rows::new(problem, initial);
    for index in problem.structure.first_of_shapes() {
        let factor = &problem.factors[index];
        let outcome = catch_unwind(AssertUnwindSafe(|| rows.linearize(index, false).is_ok()));
        if let Err(panic) = outcome {
            let (blocks, message) = (names(problem, factor), panic_message(&*panic));
            return Err(ProblemError::Panicked { factor: index, blocks, message });
        }
    }
    Ok(())
}

fn names(problem: &Problem, factor: &Factor) -> String {
    let names: Vec<String> = factor.residual.blocks().iter().map(|id| problem.block(*id).name.clone()).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EvaluateError, LocalValues, Loss, Noise, Residual, RowsMut, Sphere};

    /// `x − 1`, with a choice of mistakes.
    #[derive(Debug)]
    struct Mistaken {
        reads: Vec<BlockId>,
        /// Column that it writes.
        column: usize,
    }

    impl Residual for Mistaken {
        fn blocks(&self) -> &[BlockId] {
            &self.reads
        }

        fn len(&self) -> usize {
            1
        }

        fn evaluate(
            &self,
            x: LocalValues<'_>,
            residual: &mut [f64],
            jacobian: Option<RowsMut<'_>>,
        ) -> Result<(), EvaluateError> {
            residual[0] = x.scalar(0) - 1.0;
            if let Some(mut rows) = jacobian {
                rows.row(0)[self.column] = 1.0;
            }
            Ok(())
        }
    }

    fn unit() -> Noise {
        Noise::independent(&[1.0]).unwrap()
    }

    fn refusal(fill: impl FnOnce(&mut ProblemBuilder)) -> String {
        let mut builder = ProblemBuilder::new();
        fill(&mut builder);
        builder.build().unwrap_err().to_string()
    }

    #[test]
    fn a_problem_without_an_answer_is_refused_by_name() {
        assert!(refusal(|_| ()).starts_with("no factors"));
        let unread = |builder: &mut ProblemBuilder| {
            let x = builder.add_block(Block::scalar("x", "m"), &[0.0]);
            builder.add_block(Block::scalar("lonely", "m"), &[0.0]);
            builder.add_factor(Factor::new(Mistaken { reads: vec![x], column: 0 }, unit()));
        };
        assert!(refusal(unread).starts_with("nothing reads the unknown `lonely`"));
        let fixed = |builder: &mut ProblemBuilder| {
            let x = builder.add_block(Block::scalar("x", "m").fixed("known"), &[0.0]);
            builder.add_factor(Factor::new(Mistaken { reads: vec![x], column: 0 }, unit()));
        };
        assert!(refusal(fixed).starts_with("no unknowns"));
        let infinite = |builder: &mut ProblemBuilder| {
            builder.add_block(Block::scalar("x", "m"), &[f64::INFINITY]);
        };
        assert_eq!(refusal(infinite), "the initial value [inf] of `x` is not finite");
    }

    #[test]
    fn a_residual_of_the_wrong_shape_is_refused_by_name() {
        let with = |reads: fn(BlockId) -> Vec<BlockId>, column: usize, noise: Noise| {
            refusal(|builder| {
                let x = builder.add_block(Block::scalar("x", "m"), &[0.0]);
                builder.add_factor(Factor::new(Mistaken { reads: reads(x), column }, noise));
            })
        };
        let two = Noise::independent(&[1.0, 1.0]).unwrap();
        assert_eq!(with(|x| vec![x], 0, two), "factor 0 has 1 residuals but noise for 2");
        assert_eq!(with(|x| vec![x, x], 0, unit()), "factor 0 reads `x` twice");
        assert!(with(|x| vec![x, BlockId(7)], 0, unit()).starts_with("factor 0 reads block number 7, but there are"));
        let reported = with(|x| vec![x], 1, unit());
        assert!(
            reported.starts_with("factor 0 (of x) panicked at the initial values: index out of bounds"),
            "{reported}"
        );
    }

    #[test]
    fn blocks_and_constraints_that_are_none_are_refused_by_name() {
        let block = |block: Block, initial: &[f64]| refusal(|builder| _ = builder.add_block(block, initial));
        assert_eq!(block(Block::scalar("", "m"), &[0.0]), "block 0 has no name");
        assert_eq!(
            block(Block::vector("v", "m", &[]), &[]),
            "`v` has no numbers: give it components, or leave it away"
        );
        let sphere = |components: &[&str], radius: f64| {
            let on = Block::vector("v", "m", components).on(Sphere { radius });
            block(on, &vec![1.0; components.len()])
        };
        for radius in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            let reported =
                format!("of `v` lies on no sphere of radius {radius}: that takes 3 numbers, and a radius that is");
            assert!(sphere(&["x", "y", "z"], radius).contains(&reported));
        }
        for components in [&["x"][..], &["x", "y"], &["x", "y", "z", "w"]] {
            assert!(sphere(components, 1.0).contains("of `v` lies on no sphere of radius 1: that takes 3 numbers"));
        }
        let constraints = |names: [&str; 2]| {
            refusal(|builder| {
                let x = builder.add_block(Block::scalar("x", "m"), &[0.0]);
                builder.add_factor(Factor::new(Mistaken { reads: vec![x], column: 0 }, unit()));
                names.into_iter().for_each(|name| builder.add_constraint(Constraint::bound(name, x, 0, -1.0, 1.0)));
            })
        };
        assert_eq!(constraints(["one", ""]), "constraint 1 has no name");
        assert_eq!(constraints(["one", "one"]), "two constraints are named `one`");
    }

    #[test]
    fn another_loss_counts_for_the_factors_that_it_is_of_and_keeps_the_structure() {
        let mut builder = ProblemBuilder::new();
        let x = builder.add_block(Block::scalar("x", "m"), &[5.0]);
        (0..2).for_each(|_| builder.add_factor(Factor::new(Mistaken { reads: vec![x], column: 0 }, unit())));
        let (problem, values) = builder.build().unwrap();
        let robust = problem.with_loss(1..2, Loss::Huber(1.0)).unwrap();
        // ½ 4², and beyond the width 1 · (4 − ½).
        assert_eq!((problem.cost(&values), robust.cost(&values)), (Ok(16.0), Ok(11.5)));
        assert!(Arc::ptr_eq(&problem.structure, &robust.structure));
        let refused = problem.with_loss(1..2, Loss::Huber(-1.0)).unwrap_err().to_string();
        assert!(refused.starts_with("factor 1: the width -1"), "{refused}");
    }

    /// Rows of one noise and correlated ones: what is left of each is the root of its weight, and no loss.
    #[test]
    fn a_weighted_problem_has_the_gradient_of_that_with_losses() {
        let mut builder = ProblemBuilder::new();
        let x = builder.add_block(Block::scalar("x", "m"), &[5.0]);
        let correlated = Noise::correlated(&[4.0], 1).unwrap();
        for noise in [unit(), correlated] {
            builder.add_factor(Factor::new(Mistaken { reads: vec![x], column: 0 }, noise).with_loss(Loss::Huber(1.0)));
        }
        let (problem, values) = builder.build().unwrap();
        let weighted = problem.weighted_at(&values).unwrap();
        let (plain, weights) = (problem.residuals(&values).unwrap(), problem.weights(&values).unwrap());
        // Beyond the width a residual counts by the width over it.
        assert_eq!((plain.as_slice(), weights.as_slice()), (&[4.0, 2.0][..], &[0.25, 0.5][..]));
        assert_eq!(weighted.weights(&values).unwrap(), [1.0, 1.0]);
        let left = weighted.residuals(&values).unwrap();
        assert!(
            left.iter().zip([2.0, 2f64.sqrt()]).all(|(left, expected)| (left - expected).abs() < 1e-12),
            "{left:?}"
        );
    }

    #[test]
    fn a_loss_without_a_width_is_refused() {
        let reported = refusal(|builder| {
            let x = builder.add_block(Block::scalar("x", "m"), &[0.0]);
            let residual = Mistaken { reads: vec![x], column: 0 };
            builder.add_factor(Factor::new(residual, unit()).with_loss(Loss::Huber(-1.0)));
        });
        assert_eq!(reported, "factor 0: the width -1 of a loss must be between 0.001 and 1000000 standard deviations");
    }
}
