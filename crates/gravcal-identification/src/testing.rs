//! What the tests of this crate share: a sensor of three parameters.

use gravcal_estimation::{
    Automatic, Block, BlockId, EvaluateError, Factor, Formula, LocalNumbers, Loss, Noise, Number, Problem,
    ProblemBuilder, SolveContext, Solver, Values,
};
use gravcal_solvers::SolverName;

use crate::environment::SolveEnvironment;

/// Reading of `gain · (x + offset) + bias`: a bias and an offset cannot be told apart.
#[derive(Debug)]
struct Reading {
    blocks: [BlockId; 3],
    x: f64,
    y: f64,
}

impl Formula for Reading {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        residual[0] = p.scalar(0) * (p.scalar(1) + self.x) + p.scalar(2) - self.y;
        Ok(())
    }
}

/// Readings `(x, y, std)` of a sensor, started at these values of gain, offset and bias; those named are fixed there.
pub fn sensor(
    readings: &[(f64, f64, f64)],
    start: [f64; 3],
    fixed: &[usize],
    loss: Loss,
) -> (Problem, Values, [BlockId; 3]) {
    let mut builder = ProblemBuilder::new();
    let names = ["gain", "offset", "bias"];
    let blocks = [0, 1, 2].map(|index| builder.add_block(Block::scalar(names[index], "V"), &[start[index]]));
    for (x, y, std) in readings {
        let residual = Automatic(Reading { blocks, x: *x, y: *y });
        let factor = Factor::new(residual, Noise::independent(&[*std]).unwrap());
        builder.add_factor(Factor { loss, ..factor });
    }
    let (problem, values) = builder.build().unwrap();
    let fixed: Vec<BlockId> = fixed.iter().map(|index| blocks[*index]).collect();
    (problem.with_fixed(&fixed, "by the test"), values, blocks)
}

/// A line `y = a + b x` by its normal equations of weights one: intercept, slope, and `Σ (x − x̄)²`.
pub fn line(readings: &[(f64, f64, f64)]) -> (f64, f64, f64) {
    let n = readings.len() as f64;
    let [x, y] =
        [|r: &(f64, f64, f64)| r.0, |r: &(f64, f64, f64)| r.1].map(|of| readings.iter().map(of).sum::<f64>() / n);
    let sxx: f64 = readings.iter().map(|r| (r.0 - x).powi(2)).sum();
    let slope = readings.iter().map(|r| (r.0 - x) * (r.1 - y)).sum::<f64>() / sxx;
    (y - slope * x, slope, sxx)
}

/// Runs something with the default method.
pub fn with_environment<T>(run: impl FnOnce(&SolveEnvironment<'_>) -> T) -> T {
    let solver = SolverName::LevenbergMarquardt.build();
    run(&SolveEnvironment::new(solver.as_ref(), &|_| {}))
}

/// Where the default method ends.
pub fn solved(problem: &Problem, start: &Values) -> gravcal_estimation::Estimate {
    let solver: Box<dyn Solver> = SolverName::LevenbergMarquardt.build();
    solver.solve(problem, start, &mut SolveContext::default()).unwrap()
}
