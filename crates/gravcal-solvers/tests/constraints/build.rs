//! Problems in few words.

use gravcal_estimation::{
    Block, BlockId, Constraint, Estimate, EvaluateError, Factor, LocalValues, Noise, Problem, ProblemBuilder, Residual,
    RowsMut, SolveContext, SolveError, Solver, Values,
};
use gravcal_solvers::Clarabel;

/// Residual and Jacobian (row-major) over all blocks together.
pub type Model = Box<dyn Fn(&[f64], &mut [f64], &mut [f64]) + Send + Sync>;

/// A residual that is a function.
pub struct Function {
    pub blocks: Vec<BlockId>,
    pub rows: usize,
    pub model: Model,
}

impl std::fmt::Debug for Function {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a function of {:?}", self.blocks)
    }
}

impl Residual for Function {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.rows
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let columns = x.as_slice().len();
        let mut full = vec![0.0; self.rows * columns];
        (self.model)(x.as_slice(), residual, &mut full);
        if let Some(mut rows) = jacobian {
            for row in 0..self.rows {
                rows.row(row).copy_from_slice(&full[row * columns..(row + 1) * columns]);
            }
        }
        Ok(())
    }
}

/// A free block of so many numbers.
pub fn block(name: &str, size: usize) -> Block {
    let names: Vec<String> = (0..size).map(|i| i.to_string()).collect();
    Block::vector(name, "", &names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Each block is read as it is: ½ ‖x − reading‖².
pub fn readings(builder: &mut ProblemBuilder, id: BlockId, values: &[f64]) {
    let (expected, rows) = (values.to_vec(), values.len());
    let model = move |x: &[f64], r: &mut [f64], j: &mut [f64]| {
        for i in 0..x.len() {
            r[i] = x[i] - expected[i];
            j[i * x.len() + i] = 1.0;
        }
    };
    let residual = Function { blocks: vec![id], rows, model: Box::new(model) };
    builder.add_factor(Factor::new(residual, Noise::independent(&vec![1.0; rows]).unwrap()));
}

/// One block, one residual, and the constraints on it.
pub fn build(
    start: &[f64],
    rows: usize,
    model: fn(&[f64], &mut [f64], &mut [f64]),
    constraints: impl FnOnce(BlockId) -> Vec<Constraint>,
) -> (Problem, Values, BlockId) {
    let mut builder = ProblemBuilder::new();
    let id = builder.add_block(block("x", start.len()), start);
    let residual = Function { blocks: vec![id], rows, model: Box::new(model) };
    builder.add_factor(Factor::new(residual, Noise::independent(&vec![1.0; rows]).unwrap()));
    constraints(id).into_iter().for_each(|c| builder.add_constraint(c));
    let (problem, initial) = builder.build().unwrap();
    (problem, initial, id)
}

/// Solves by the constrained method.
pub fn solve(problem: &Problem, initial: &Values) -> Result<Estimate, SolveError> {
    Clarabel::default().solve(problem, initial, &mut SolveContext::default())
}

/// Name and multiplier of each active constraint.
pub fn active(estimate: &Estimate) -> Vec<(&str, f64)> {
    estimate.active.iter().map(|a| (a.name.as_str(), a.multiplier)).collect()
}

/// Whether numbers agree to `tolerance`.
pub fn near(found: &[f64], expected: &[f64], tolerance: f64) -> bool {
    found.len() == expected.len() && found.iter().zip(expected).all(|(f, e)| (f - e).abs() <= tolerance)
}
