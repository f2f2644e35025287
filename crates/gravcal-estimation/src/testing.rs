//! Linear residuals and a solver, for the tests of this crate.

use crate::statistics::Solution;
use crate::{
    Block, BlockId, Estimate, EvaluateError, Factor, LocalValues, Loss, Noise, Problem, ProblemBuilder, RankAnalysis,
    Residual, RowsMut, SolveContext, SolveError, Solver, Termination, Unsupported, Values,
};

/// `Σ coefficient · x − reading` over all stored coordinates of some blocks.
#[derive(Clone, Debug)]
pub struct Line {
    blocks: Vec<BlockId>,
    coefficients: Vec<f64>,
    reading: f64,
}

impl Line {
    /// One coefficient a stored coordinate.
    pub fn new(blocks: &[BlockId], coefficients: &[f64], reading: f64) -> Self {
        Line { blocks: blocks.to_vec(), coefficients: coefficients.to_vec(), reading }
    }

    /// One coordinate of a block of up to three.
    pub fn component(block: BlockId, component: usize) -> Self {
        let coefficients = (0..3).map(|i| f64::from(u8::from(i == component))).collect();
        Line { blocks: vec![block], coefficients, reading: 0.0 }
    }
}

impl Residual for Line {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
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
        residual[0] = x.as_slice().iter().zip(&self.coefficients).map(|(x, c)| x * c).sum::<f64>() - self.reading;
        if let Some(mut rows) = jacobian {
            rows.row(0).iter_mut().zip(&self.coefficients).for_each(|(entry, c)| *entry = *c);
        }
        Ok(())
    }
}

/// Newton's steps until they no longer count.
pub struct Newton;

impl Solver for Newton {
    fn name(&self) -> &'static str {
        "newton"
    }

    fn check(&self, _problem: &Problem) -> Result<(), Unsupported> {
        Ok(())
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        _context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        let mut values = initial.clone();
        for _ in 0..50 {
            let mut linearization = problem.linearize(&values)?;
            let scaling = linearization.column_scales();
            let mut step = vec![0.0; scaling.len()];
            linearization.damped_step(1e-12, &scaling, &mut step);
            values = problem.retract(&values, &step);
        }
        let termination = Termination::Step { relative: 0.0 };
        Ok(Estimate {
            cost: problem.cost(&values)?,
            values,
            termination,
            iterations: Vec::new(),
            iterates: Vec::new(),
            active: Vec::new(),
            without_effect: Vec::new(),
            normal_equations: None,
        })
    }
}

/// A problem at its solution.
pub struct Solved {
    pub problem: Problem,
    pub values: Values,
    analysis: RankAnalysis,
}

impl Solved {
    pub fn solution(&self) -> Solution<'_> {
        Solution { problem: &self.problem, values: &self.values, analysis: &self.analysis }
    }
}

/// Solves what was built.
pub fn fit(builder: ProblemBuilder) -> Solved {
    let (problem, initial) = builder.build().unwrap();
    let values = Newton.solve(&problem, &initial, &mut SolveContext::default()).unwrap().values;
    let analysis = RankAnalysis::new(&problem, &values).unwrap();
    Solved { problem, values, analysis }
}

/// Readings `a + b t` at t = 0, 1, …, with unit noise.
pub fn line(y: &[f64]) -> ProblemBuilder {
    let mut builder = ProblemBuilder::new();
    let blocks = ["a", "b"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
    for (t, y) in y.iter().enumerate() {
        add(&mut builder, Line::new(&blocks, &[1.0, t as f64], *y));
    }
    builder
}

/// Readings of one level, with unit noise.
pub fn level(y: &[f64]) -> (ProblemBuilder, BlockId) {
    let mut builder = ProblemBuilder::new();
    let block = builder.add_block(Block::scalar("level", ""), &[0.0]);
    y.iter().for_each(|y| add(&mut builder, Line::new(&[block], &[1.0], *y)));
    (builder, block)
}

/// Adds a factor of unit noise.
pub fn add(builder: &mut ProblemBuilder, residual: Line) {
    builder.add_factor(Factor::new(residual, Noise::independent(&[1.0]).unwrap()));
}

/// The level of readings under a loss.
pub fn fit_robustly(y: &[f64], loss: Loss) -> Solved {
    let mut builder = ProblemBuilder::new();
    let block = builder.add_block(Block::scalar("level", ""), &[0.0]);
    for y in y {
        let factor = Factor::new(Line::new(&[block], &[1.0], *y), Noise::independent(&[1.0]).unwrap());
        builder.add_factor(factor.with_loss(loss));
    }
    fit(builder)
}
