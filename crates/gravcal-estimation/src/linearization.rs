//! What a method needs of the Jacobian, without seeing how it is stored.

use faer::linalg::solvers::Qr;
use faer::{Mat, MatRef};

use crate::{EvaluateError, Problem, Values};

/// Columns smaller than this share of the largest are rounding errors. Units differ by far less (1e6 between a count
/// and a metre), rounding by more (1e-16).
const DUST: f64 = 1e-12;

/// A problem linearized at one point.
pub trait Linearization {
    /// Cost ½ ‖r‖² there.
    fn cost(&self) -> f64;
    /// `Jᵀ r`.
    fn gradient(&self) -> &[f64];
    /// Euclidean norm of each column of J.
    fn column_norms(&self) -> &[f64];
    /// Scale of each column: its norm, or 1 for a column of zeros.
    fn column_scales(&self) -> Vec<f64> {
        self.column_norms().iter().map(|norm| if *norm > 0.0 { *norm } else { 1.0 }).collect()
    }
    /// Minimises `½ ‖J δ + r‖² + ½ λ ‖diag(scaling) δ‖²` and writes `δ`.
    fn damped_step(&mut self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> StepInfo;

    /// `‖J v‖²`.
    fn image_norm_squared(&self, v: &[f64]) -> f64;

    /// `JᵀJ`, row-major, of all columns: memory grows with their square.
    fn hessian(&self) -> Vec<f64>;

    /// Largest |cosine| between the residual and a column of J: 0 at a stationary point, whatever the scales.
    fn largest_cosine(&self) -> f64 {
        let residual = (2.0 * self.cost()).sqrt();
        self.gradient()
            .iter()
            .zip(self.column_norms())
            .filter(|(_, norm)| **norm > 0.0 && residual > 0.0)
            .map(|(g, norm)| g.abs() / (norm * residual))
            .fold(0.0, f64::max)
    }
}

/// What a step promises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInfo {
    /// Reduction of the cost that the linear model predicts for the step, not counting the damping.
    pub predicted_reduction: f64,
}

/// QR of the dense whitened Jacobian: no digit is lost to normal equations, and a step at another damping costs
/// only a factorization of the small triangle.
#[derive(Debug)]
pub struct DenseLinearization {
    /// `R` of `J = Q R`; at most as many rows as columns.
    triangle: Mat<f64>,
    /// `Qᵀ r`.
    rotated_residual: Vec<f64>,
    cost: f64,
    gradient: Vec<f64>,
    column_norms: Vec<f64>,
}

impl DenseLinearization {
    /// Linearizes `problem` at `values`.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn new(problem: &Problem, values: &Values) -> Result<Self, EvaluateError> {
        let columns = problem.columns().len();
        let mut rows = problem.corrected_jacobian(values)?;
        clear_dust(&mut rows, columns + 1);
        let augmented = MatRef::from_row_major_slice(&rows, problem.rows(), columns + 1);
        // The residual rides along as a last column, so that its rotation needs no Q.
        let factored = augmented.qr();
        let r = factored.thin_R();
        let kept = r.nrows().min(columns);
        let triangle = r.get(0..kept, 0..columns).to_owned();
        let rotated_residual: Vec<f64> = (0..kept).map(|i| r[(i, columns)]).collect();
        let residual = augmented.col(columns);
        let jacobian = augmented.get(.., 0..columns);
        let gradient: Vec<f64> =
            (0..columns).map(|j| jacobian.col(j).iter().zip(residual.iter()).map(|(a, b)| a * b).sum()).collect();
        Ok(DenseLinearization {
            triangle,
            rotated_residual,
            cost: problem.cost(values)?,
            gradient,
            column_norms: (0..columns).map(|j| jacobian.col(j).norm_l2()).collect(),
        })
    }

    /// The triangular factor of the whitened Jacobian: it has the Jacobian's singular values and null space.
    pub(crate) fn triangle(&self) -> MatRef<'_, f64> {
        self.triangle.as_ref()
    }
}

/// Makes columns that are zero but for rounding errors zero, so that nothing walks along them or takes them for
/// information. The last column is the residual and stays.
fn clear_dust(rows: &mut [f64], width: usize) {
    let mut squares = vec![0.0; width];
    for row in rows.chunks_exact(width) {
        squares.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * v);
    }
    let largest = squares[..width - 1].iter().fold(0.0, |m: f64, v| m.max(*v));
    let dust: Vec<usize> = (0..width - 1).filter(|j| squares[*j] <= DUST * DUST * largest).collect();
    for row in rows.chunks_exact_mut(width) {
        dust.iter().for_each(|j| row[*j] = 0.0);
    }
}

impl Linearization for DenseLinearization {
    fn cost(&self) -> f64 {
        self.cost
    }

    fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    fn column_norms(&self) -> &[f64] {
        &self.column_norms
    }

    fn damped_step(&mut self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> StepInfo {
        let (kept, columns) = (self.triangle.nrows(), self.triangle.ncols());
        // QR of [R; √λ D | −Qᵀr; 0]: the damped step without ever squaring the condition.
        let stacked = Mat::from_fn(kept + columns, columns + 1, |i, j| match (i < kept, j < columns) {
            (true, true) => self.triangle[(i, j)],
            (true, false) => -self.rotated_residual[i],
            (false, true) if i - kept == j => lambda.sqrt() * scaling[j],
            (false, _) => 0.0,
        });
        let factored: Qr<f64> = stacked.qr();
        let r = factored.thin_R();
        let mut solution = Mat::from_fn(columns, 1, |i, _| r[(i, columns)]);
        r.get(0..columns, 0..columns).solve_upper_triangular_in_place(solution.as_mut());
        (0..columns).for_each(|j| step[j] = solution[(j, 0)]);
        // ½‖r‖² − ½‖Jδ + r‖² = −gᵀδ − ½‖Rδ‖²
        let along: f64 = self.gradient.iter().zip(&*step).map(|(g, d)| g * d).sum();
        StepInfo { predicted_reduction: -along - 0.5 * self.image_norm_squared(step) }
    }

    fn image_norm_squared(&self, v: &[f64]) -> f64 {
        let row = |i: usize| v.iter().enumerate().map(|(j, v)| self.triangle[(i, j)] * v).sum::<f64>();
        (0..self.triangle.nrows()).map(|i| row(i).powi(2)).sum()
    }

    fn hessian(&self) -> Vec<f64> {
        let columns = self.triangle.ncols();
        let product = self.triangle.transpose() * &self.triangle;
        (0..columns * columns).map(|k| product[(k / columns, k % columns)]).collect()
    }
}
