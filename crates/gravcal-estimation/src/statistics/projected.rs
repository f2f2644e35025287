//! The whitened rows `[J r]` seen along the directions that the data determine, and what the losses make of them.
//!
//! With `T` a basis of these directions (one a column) and `z = Tᵀ j` a row in its coordinates, a piece of the problem
//! (one row where the noise is independent, a whole factor where it is correlated) with `s = ‖r‖²` has
//!
//! ```text
//!     score        ρ′ Zᵀ r                            slope of its cost; the scores of all pieces sum to zero
//!     curvature    ρ′ ZᵀZ + 2 ρ″ (Zᵀ r)(Zᵀ r)ᵀ        of its cost, without second derivatives of r
//! ```

use std::ops::Range;

use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};

use super::{Covariance, Solution, StatisticsError};
use crate::by_column::ByColumn;
use crate::eliminated_columns::Reduced;
use crate::loss::LossValue;
use crate::problem::Rows;
use crate::{Loss, Noise, Problem};

/// Rows of a problem in the coordinates of the determined directions.
pub(super) struct Projected<'a> {
    problem: &'a Problem,
    /// `Tᵀ`: one direction a row.
    pub directions: Vec<Vec<f64>>,
    /// `z` of each row.
    rows: Vec<Vec<f64>>,
    residuals: Vec<f64>,
    /// What each row reads of eliminated columns once these follow the shared ones, where there are any.
    eliminated: Vec<Reduced>,
}

/// What is whitened, and forgiven, together.
pub(super) struct Piece<'a> {
    rows: &'a [Vec<f64>],
    residuals: &'a [f64],
    /// `s`.
    pub square: f64,
    /// ρ and its derivatives.
    pub loss: LossValue,
}

impl<'a> Projected<'a> {
    /// Directions such that `J̃ T` has orthonormal columns, with J̃ the Jacobian that the rank analysis decomposed.
    pub fn new(solution: &Solution<'a>) -> Result<Self, StatisticsError> {
        solution.without_eliminated()?;
        let directions = solution.analysis.determined_directions();
        let by_column = ByColumn::of(&directions, solution.problem.columns().len());
        let project = |row: &[(usize, f64)], residual: f64, _: &mut [f64]| {
            let mut along = vec![0.0; directions.len()];
            by_column.along(row.iter().copied(), &mut along);
            (along, residual)
        };
        let (_, rows) = solution.problem.made_of_rows(solution.values, 0, project)?;
        let (rows, residuals) = rows.into_iter().unzip();
        Ok(Projected { problem: solution.problem, rows, residuals, eliminated: Vec::new(), directions })
    }

    /// The same of a problem that may have eliminated blocks, of its shared columns, if no loss forgives anything there.
    pub fn of_shared(solution: &Solution<'a>) -> Result<Self, StatisticsError> {
        let (problem, analysis) = (solution.problem, solution.analysis);
        if !analysis.has_eliminated() || problem.factors().iter().any(|factor| factor.loss != Loss::None) {
            return Self::new(solution);
        }
        let directions = analysis.determined_directions();
        let mut projected =
            Projected { problem, directions, rows: Vec::new(), residuals: Vec::new(), eliminated: Vec::new() };
        let mut loaded = Rows::new(problem, solution.values);
        for factor in 0..problem.factors().len() {
            loaded.linearize(factor, false)?;
            loaded.check_jacobian(factor)?;
            for row in 0..problem.rows_of(factor).len() {
                let mut entries = Vec::new();
                loaded.for_columns(factor, row, |column, entry| entries.push((column, entry)));
                let reduced = analysis.reduce(entries);
                projected.rows.push(Self::of_function(&projected.directions, &reduced.shared));
                projected.residuals.push(loaded.residual(row));
                projected.eliminated.push(reduced);
            }
        }
        Ok(projected)
    }

    /// The same in coordinates in which the curvature of the whole cost is the identity; as they are where no loss bends it.
    pub fn with_unit_curvature(mut self) -> Result<Self, StatisticsError> {
        if self.problem.factors().iter().all(|factor| factor.loss == Loss::None) {
            return Ok(self);
        }
        let curvature = self.curvature(0..self.problem.factors().len());
        let factor = Llt::new(curvature.as_ref(), faer::Side::Lower).map_err(|_| StatisticsError::NotConvex)?;
        let lower = factor.L();
        for row in &mut self.rows {
            for i in 0..row.len() {
                let known: f64 = (0..i).map(|k| lower[(i, k)] * row[k]).sum();
                row[i] = (row[i] - known) / lower[(i, i)];
            }
        }
        for i in 0..self.directions.len() {
            let (done, rest) = self.directions.split_at_mut(i);
            let direction = &mut rest[0];
            for (k, known) in done.iter().enumerate() {
                direction.iter_mut().zip(known).for_each(|(d, known)| *d -= lower[(i, k)] * known);
            }
            direction.iter_mut().for_each(|d| *d /= lower[(i, i)]);
        }
        Ok(self)
    }

    /// Number of determined directions.
    pub fn rank(&self) -> usize {
        self.directions.len()
    }

    /// Whether some columns are eliminated.
    pub fn has_eliminated(&self) -> bool {
        !self.eliminated.is_empty()
    }

    /// `z` of each row of some factors.
    pub fn rows_of(&self, factors: Range<usize>) -> &[Vec<f64>] {
        &self.rows[self.range(factors)]
    }

    /// Whitened residuals of some factors.
    pub fn residuals_of(&self, factors: Range<usize>) -> &[f64] {
        &self.residuals[self.range(factors)]
    }

    /// The loss of a factor.
    pub fn loss(&self, factor: usize) -> Loss {
        self.problem.factors()[factor].loss
    }

    /// `√ρ′ z` of each row of some factors.
    pub fn weighted_rows(&self, factors: Range<usize>) -> Vec<Vec<f64>> {
        let mut weighted = Vec::new();
        for piece in factors.flat_map(|factor| self.pieces(factor)) {
            let weight = piece.loss.first.max(0.0).sqrt();
            weighted.extend(piece.rows.iter().map(|row| row.iter().map(|z| weight * z).collect::<Vec<f64>>()));
        }
        weighted
    }

    /// `√ρ′ r` of each row of some factors.
    pub fn weighted_residuals(&self, factors: Range<usize>) -> Vec<f64> {
        let mut weighted = Vec::new();
        for piece in factors.flat_map(|factor| self.pieces(factor)) {
            let weight = piece.loss.first.max(0.0).sqrt();
            weighted.extend(piece.residuals.iter().map(|r| weight * r));
        }
        weighted
    }

    /// Part of what two rows have in common that is due to eliminated columns alone.
    pub fn common_of_eliminated(&self, a: usize, b: usize) -> f64 {
        if self.has_eliminated() { self.eliminated[a].own_covariance(&self.eliminated[b]) } else { 0.0 }
    }

    /// The rows of consecutive factors.
    pub fn range(&self, factors: Range<usize>) -> Range<usize> {
        let rows = |factor: usize| self.problem.rows_of(factor);
        if factors.is_empty() { 0..0 } else { rows(factors.start).start..rows(factors.end - 1).end }
    }

    /// The pieces of one factor.
    pub fn pieces(&self, factor: usize) -> impl Iterator<Item = Piece<'_>> {
        let length = match self.problem.factors()[factor].noise {
            Noise::Independent(_) => 1,
            Noise::Correlated(_) => self.problem.rows_of(factor).len(),
        };
        Pieces::new(self, factor, length)
    }

    /// Sum of `ZᵀZ` of some factors.
    pub fn gram(&self, factors: impl Iterator<Item = usize>) -> Mat<f64> {
        let mut sum = Mat::zeros(self.rank(), self.rank());
        factors.for_each(|factor| self.pieces(factor).for_each(|piece| piece.add_gram(&mut sum)));
        sum
    }

    /// Sum of the curvatures of some factors.
    pub fn curvature(&self, factors: impl Iterator<Item = usize>) -> Mat<f64> {
        let mut sum = Mat::zeros(self.rank(), self.rank());
        factors.for_each(|factor| self.pieces(factor).for_each(|piece| piece.add_curvature(&mut sum)));
        sum
    }

    /// Sum of the scores of some factors.
    pub fn score(&self, factors: impl Iterator<Item = usize>) -> Vec<f64> {
        let mut score = vec![0.0; self.rank()];
        for factor in factors {
            for piece in self.pieces(factor) {
                let along = piece.along_residual();
                score.iter_mut().zip(along).for_each(|(sum, a)| *sum += piece.loss.first * a);
            }
        }
        score
    }

    /// `T M Tᵀ`: a covariance in the coordinates of the directions, by the problem's shared columns.
    pub fn covariance(&self, matrix: &Mat<f64>) -> Covariance {
        let size = self.directions.first().map_or(self.problem.columns().len(), Vec::len);
        let mut tangent = vec![0.0; size * size];
        for (k, left) in self.directions.iter().enumerate() {
            let mut row = vec![0.0; size];
            for (l, right) in self.directions.iter().enumerate() {
                row.iter_mut().zip(right).for_each(|(sum, v)| *sum += matrix[(k, l)] * v);
            }
            for (i, left) in left.iter().enumerate() {
                tangent[i * size..(i + 1) * size].iter_mut().zip(&row).for_each(|(sum, v)| *sum += left * v);
            }
        }
        Covariance::new(tangent, size)
    }

    /// A linear function of the columns in the coordinates of the directions.
    pub fn of_function(directions: &[Vec<f64>], function: &[(usize, f64)]) -> Vec<f64> {
        directions.iter().map(|d| function.iter().map(|(column, c)| c * d[*column]).sum()).collect()
    }
}

/// Cuts the rows of a factor.
struct Pieces<'p> {
    rows: std::slice::Chunks<'p, Vec<f64>>,
    residuals: std::slice::Chunks<'p, f64>,
    loss: Loss,
}

impl<'p> Pieces<'p> {
    fn new(projected: &'p Projected<'_>, factor: usize, length: usize) -> Self {
        let rows = projected.problem.rows_of(factor);
        Pieces {
            rows: projected.rows[rows.clone()].chunks(length),
            residuals: projected.residuals[rows].chunks(length),
            loss: projected.problem.factors()[factor].loss,
        }
    }
}

impl<'p> Iterator for Pieces<'p> {
    type Item = Piece<'p>;

    fn next(&mut self) -> Option<Piece<'p>> {
        let (rows, residuals) = (self.rows.next()?, self.residuals.next()?);
        let square = dot(residuals, residuals);
        Some(Piece { rows, residuals, square, loss: self.loss.at(square) })
    }
}

impl Piece<'_> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.residuals.len()
    }

    /// `Zᵀ r`.
    fn along_residual(&self) -> Vec<f64> {
        let mut along = vec![0.0; self.rows.first().map_or(0, Vec::len)];
        for (row, residual) in self.rows.iter().zip(self.residuals) {
            along.iter_mut().zip(row).for_each(|(sum, z)| *sum += residual * z);
        }
        along
    }

    fn add_gram(&self, sum: &mut Mat<f64>) {
        self.rows.iter().for_each(|row| add_outer(sum, 1.0, row));
    }

    fn add_curvature(&self, sum: &mut Mat<f64>) {
        self.rows.iter().for_each(|row| add_outer(sum, self.loss.first, row));
        if self.loss.second != 0.0 {
            add_outer(sum, 2.0 * self.loss.second, &self.along_residual());
        }
    }
}

/// Adds `weight · v vᵀ`.
pub(super) fn add_outer(sum: &mut Mat<f64>, weight: f64, v: &[f64]) {
    for (j, right) in v.iter().enumerate() {
        let factor = weight * right;
        sum.col_mut(j).iter_mut().zip(v).for_each(|(entry, left)| *entry += factor * left);
    }
}

/// `A⁻¹ B A⁻¹` of symmetric matrices, A positive definite.
pub(super) fn sandwiched(bread: &Mat<f64>, meat: &Mat<f64>) -> Result<Mat<f64>, StatisticsError> {
    let factor = Llt::new(bread.as_ref(), faer::Side::Lower).map_err(|_| StatisticsError::NotConvex)?;
    let half = factor.solve(meat);
    Ok(factor.solve(half.transpose().to_owned()))
}

/// The step by the problem's columns that moves by `along` in the coordinates of the directions.
pub(super) fn back(directions: &[Vec<f64>], along: &[f64]) -> Vec<f64> {
    let mut step = vec![0.0; directions.first().map_or(0, Vec::len)];
    for (direction, along) in directions.iter().zip(along) {
        step.iter_mut().zip(direction).for_each(|(sum, d)| *sum += along * d);
    }
    step
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
