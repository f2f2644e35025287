//! What the data determine: rank, null space, and directions of which they say little.
//!
//! With `D` the norms of the columns of the whitened Jacobian J, everything is judged on `J D⁻¹`, whose columns have unit
//! length, so that units do not matter:
//!
//! - *Without information* is a direction whose singular value is below [`RANK_TOLERANCE`] of the largest.
//! - *Weak* is a direction whose standard deviation, in units of `1/D`, exceeds that of the median direction
//!   [`WEAK`] times. Within some of the columns, what is left of the information when all others are unknown counts.
//!
//! A direction is a step of the parameters that changes the residuals not at all, or hardly.
//! [`named_combinations`](crate::named_combinations) puts it into words.

mod decomposition;
mod elimination;

use std::sync::Arc;

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par};

use crate::by_column::ByColumn;
use crate::eliminated_columns::{EliminatedColumns, Reduced};
use crate::sparse_basis::sparse_basis;
use crate::statistics::Covariance;
use crate::{Estimate, EvaluateError, NormalEquations, Problem, Values};
use decomposition::Decomposition;
pub use elimination::Elimination;

/// Singular values of the column-scaled Jacobian below this share of the largest are zero. The scaled matrix
/// carries rounding errors of about (rows · 1e-16); a direction weaker than 1e-9 cannot be told from them.
const RANK_TOLERANCE: f64 = 1e-9;

/// A column takes part in a null direction (of unit length, in scaled coordinates) if its entry exceeds this. Null
/// vectors are accurate to about 1e-16 over the smallest true singular value: 1e-7 at the rank tolerance.
const SHADOW_TOLERANCE: f64 = 1e-6;

/// A direction is weak where it is known this many times worse than the median one.
const WEAK: f64 = 1e3;

/// Parts of a weak direction below this share of its largest, in scaled coordinates, are not told.
const READABLE: f64 = 0.02;

/// A direction of which the data say little.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakDirection {
    /// A step by the columns in question, in their units; its length means nothing.
    pub step: Vec<f64>,
    /// How many times the standard deviation along it exceeds that of the median direction.
    pub times_worse: f64,
}

/// Singular value decomposition of the whitened Jacobian, columns scaled to unit length so that units do not matter.
#[derive(Debug)]
pub struct RankAnalysis {
    /// Scale of every column of J, see [`Linearization::column_scales`].
    column_scales: Vec<f64>,
    /// What follows from the others.
    eliminated: Arc<EliminatedColumns>,
    /// Scales of the shared columns. These alone are decomposed, after elimination.
    scales: Vec<f64>,
    /// Singular values of the scaled Jacobian, largest first.
    singular_values: Vec<f64>,
    /// Right singular vectors, one a row.
    directions: Vec<Vec<f64>>,
    rank: usize,
    /// Columns of zeros: the last directions.
    zero_columns: Vec<usize>,
}

impl RankAnalysis {
    /// Decomposes the Jacobian of `problem` at `values`.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn new(problem: &Problem, values: &Values) -> Result<Self, EvaluateError> {
        Self::with_known(problem, values, None)
    }

    /// The same where an estimate of this very problem ended: what its method summed there is not summed again.
    ///
    /// # Errors
    /// As [`RankAnalysis::new`].
    pub fn of(problem: &Problem, estimate: &Estimate) -> Result<Self, EvaluateError> {
        Self::with_known(problem, &estimate.values, estimate.normal_equations.as_ref())
    }

    fn with_known(problem: &Problem, values: &Values, known: Option<&NormalEquations>) -> Result<Self, EvaluateError> {
        let Decomposition { column_scales, eliminated, zero_columns, mut singular_values, mut directions } =
            Decomposition::new(problem, values, known)?;
        let scales: Vec<f64> = problem.structure().shared.iter().map(|column| column_scales[*column]).collect();
        let largest = singular_values.first().copied().unwrap_or(0.0);
        let rank = singular_values.iter().filter(|s| **s > RANK_TOLERANCE * largest).count();
        for column in &zero_columns {
            singular_values.push(0.0);
            directions.push((0..scales.len()).map(|j| f64::from(j == *column)).collect());
        }
        Ok(RankAnalysis {
            column_scales,
            eliminated: Arc::new(eliminated),
            scales,
            singular_values,
            directions,
            rank,
            zero_columns,
        })
    }

    /// Number of directions that the data determine.
    pub fn rank(&self) -> usize {
        self.rank + self.eliminated.count()
    }

    /// Singular values of the column-scaled Jacobian, after elimination, largest first.
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// Condition of the scaled Jacobian among the directions that the data determine, after elimination: largest over
    /// smallest singular value; infinite where they determine none.
    pub fn condition(&self) -> f64 {
        self.rank.checked_sub(1).map_or(f64::INFINITY, |last| self.singular_values[0] / self.singular_values[last])
    }

    /// Norm of one column of the whitened Jacobian: what a change of one unit does to the residuals.
    pub fn column_scale(&self, column: usize) -> f64 {
        self.column_scales[column]
    }

    /// How much a column takes part in the directions without information: the length of the projection of its axis on them, in scaled
    /// coordinates, between 0 and 1. Of an eliminated column, which follows the others, 0.
    pub fn null_share(&self, column: usize) -> f64 {
        let Some(index) = self.eliminated.shared(column) else { return 0.0 };
        self.directions[self.rank..].iter().map(|null| null[index] * null[index]).sum::<f64>().sqrt()
    }

    /// Basis of what the directions without information do to the given columns, in the columns' units: empty where
    /// every one of these columns is determined. One vector a direction, one entry a column.
    pub fn null_space_within(&self, columns: &[usize]) -> Vec<Vec<f64>> {
        let (shown, _) = self.null_space_shadow(columns);
        shown.iter().map(|v| v.iter().zip(columns).map(|(c, j)| c / self.column_scales[*j]).collect()).collect()
    }

    /// Basis of the linear functions of the given columns alone that the data determine, and that none of some further steps by these
    /// columns (in their units) changes: coefficients by column.
    pub fn determined_within(&self, columns: &[usize], unchanged_by: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let scaled = |step: &Vec<f64>| -> Vec<f64> {
            let scaled: Vec<f64> = step.iter().zip(columns).map(|(c, j)| c * self.column_scales[*j]).collect();
            let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
            scaled.iter().map(|c| if length > 0.0 { c / length } else { 0.0 }).collect()
        };
        let further: Vec<Vec<f64>> = unchanged_by.iter().map(scaled).collect();
        let (_, complement) = self.shadow_of(columns, &further);
        complement.iter().map(|v| v.iter().zip(columns).map(|(c, j)| c * self.column_scales[*j]).collect()).collect()
    }

    /// Orthonormal bases, in scaled coordinates, of the null space's projection on some columns and of its
    /// orthogonal complement. Columns of zeros come as directions of their own; columns of eliminated blocks, which follow the
    /// others, are in none.
    fn null_space_shadow(&self, columns: &[usize]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        self.shadow_of(columns, &[])
    }

    /// The same of the null space and of further directions, given by these columns in scaled coordinates.
    fn shadow_of(&self, columns: &[usize], further: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let null = &self.directions[self.rank..self.directions.len() - self.zero_columns.len()];
        let shared: Vec<Option<usize>> = columns.iter().map(|column| self.eliminated.shared(*column)).collect();
        let is_zero = |i: &usize| shared[*i].is_some_and(|index| self.zero_columns.contains(&index));
        let active: Vec<(usize, usize)> =
            (0..columns.len()).filter(|i| !is_zero(i)).filter_map(|i| Some((i, shared[i]?))).collect();
        let size = active.len();
        let of_null = null.iter().flat_map(|null| active.iter().map(|(_, index)| null[*index]));
        let of_further = further.iter().flat_map(|step| active.iter().map(|(place, _)| step[*place]));
        let entries = of_null.chain(of_further);
        if entries.map(|entry| entry * entry).sum::<f64>() <= SHADOW_TOLERANCE * SHADOW_TOLERANCE {
            // No singular value is larger than this sum's root.
            let axis = |place: usize| (0..columns.len()).map(|i| f64::from(i == place)).collect();
            let zero_columns = (0..columns.len()).filter(is_zero).map(axis).collect();
            return (zero_columns, active.iter().map(|(place, _)| axis(*place)).collect());
        }
        // Square at least, so that the complement comes out of the same decomposition.
        let shadow = Mat::from_fn(size, (null.len() + further.len()).max(size), |i, k| {
            let of_further = || further.get(k - null.len()).map_or(0.0, |step| step[active[i].0]);
            null.get(k).map_or_else(of_further, |null| null[active[i].1])
        });
        let Ok(svd) = shadow.svd() else {
            return (Vec::new(), Vec::new());
        };
        let vector = |k: usize| {
            let mut vector = vec![0.0; columns.len()];
            active.iter().enumerate().for_each(|(i, (place, _))| vector[*place] = svd.U()[(i, k)]);
            vector
        };
        let shown = (0..size).filter(|k| svd.S()[*k] > SHADOW_TOLERANCE).count();
        let zero_columns = (0..columns.len()).filter(is_zero);
        let alone = zero_columns.map(|place| (0..columns.len()).map(|i| f64::from(i == place)).collect());
        ((0..shown).map(vector).chain(alone).collect(), (shown..size).map(vector).collect())
    }

    /// The directions without information as they show in the given columns, each with as few parts as can be found: steps
    /// in the columns' units.
    pub fn null_directions(&self, columns: &[usize]) -> Vec<Vec<f64>> {
        let (shown, _) = self.null_space_shadow(columns);
        self.readable(columns, &shown)
    }

    /// The weak directions within the given columns, each with as few parts as can be found. Directions without any
    /// information are not among them.
    pub fn weak_directions(&self, columns: &[usize]) -> Vec<WeakDirection> {
        let (_, determined) = self.null_space_shadow(columns);
        let covariance = self.scaled_covariance(columns);
        let size = determined.len();
        let within = Mat::from_fn(size, size, |i, j| form(&covariance, &determined[i], &determined[j]));
        // No decomposition, no direction: the numbers are not finite then, and told elsewhere.
        let Ok(eigen) = within.self_adjoint_eigen(faer::Side::Lower) else { return Vec::new() };
        let variances: Vec<f64> = eigen.S().column_vector().iter().copied().collect();
        let Some(median) = variances.get(size.saturating_sub(1) / 2).copied() else { return Vec::new() };
        let weak: Vec<Vec<f64>> = (0..size)
            .filter(|k| variances[*k] > WEAK * WEAK * median)
            .map(|k| combine(&determined, eigen.U().col(k).iter().copied(), columns.len()))
            .collect();
        sparse_basis(&weak, READABLE)
            .into_iter()
            .map(|direction| {
                let length = direction.iter().map(|c| c * c).sum::<f64>();
                let times_worse = (form(&covariance, &direction, &direction) / length / median).sqrt();
                WeakDirection { step: self.unscale_within(columns, &direction), times_worse }
            })
            .collect()
    }

    /// Steps by some columns, in their units, as the sparsest easily found basis of their span.
    pub(crate) fn sparse(&self, columns: &[usize], steps: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let scaled = |step: &Vec<f64>| step.iter().zip(columns).map(|(c, j)| c * self.column_scales[*j]).collect();
        self.readable(columns, &steps.iter().map(scaled).collect::<Vec<_>>())
    }

    fn readable(&self, columns: &[usize], scaled: &[Vec<f64>]) -> Vec<Vec<f64>> {
        sparse_basis(scaled, READABLE).iter().map(|direction| self.unscale_within(columns, direction)).collect()
    }

    fn unscale_within(&self, columns: &[usize], direction: &[f64]) -> Vec<f64> {
        direction.iter().zip(columns).map(|(c, j)| c / self.column_scales[*j]).collect()
    }

    /// Covariance of some columns in scaled coordinates.
    fn scaled_covariance(&self, columns: &[usize]) -> Vec<Vec<f64>> {
        let covariance = self.covariance();
        let scaled = |i: usize, j: usize| self.column_scales[i] * self.column_scales[j] * covariance.at(i, j);
        columns.iter().map(|i| columns.iter().map(|j| scaled(*i, *j)).collect()).collect()
    }

    /// Covariance `(JᵀJ)⁺` over the determined directions, with J as the rank analysis decomposed it: with every factor's
    /// loss. It is the covariance of the estimate where there is no loss.
    pub fn covariance(&self) -> Covariance {
        let (size, directions) = (self.scales.len(), self.determined_directions());
        let directions = Mat::from_fn(size, directions.len(), |column, k| directions[k][column]);
        let mut lower = Mat::zeros(size, size);
        let (half, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        matmul(&mut lower, half, Accum::Replace, &directions, full, directions.transpose(), full, 1.0, Par::Seq);
        let mut tangent = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                (tangent[i * size + j], tangent[j * size + i]) = (lower[(i, j)], lower[(i, j)]);
            }
        }
        self.over_all_columns(Covariance::new(tangent, size))
    }

    /// A covariance of the shared columns with what eliminated ones, if any, make of it.
    pub(crate) fn over_all_columns(&self, shared: Covariance) -> Covariance {
        if self.has_eliminated() { shared.with_eliminated(Arc::clone(&self.eliminated)) } else { shared }
    }

    /// What a linear function of columns is made of after elimination.
    pub(crate) fn reduce(&self, function: impl IntoIterator<Item = (usize, f64)>) -> Reduced {
        self.eliminated.reduce(function)
    }

    /// Linear functions of all columns as functions of the shared ones, which eliminated columns follow.
    pub(crate) fn on_shared(&self, functions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        self.eliminated.on_shared(functions)
    }

    /// Whether the problem has eliminated blocks.
    pub(crate) fn has_eliminated(&self) -> bool {
        self.eliminated.count() > 0
    }

    /// Steps by the shared columns along the determined directions, each of which moves the whitened residuals by a unit
    /// vector, perpendicular to those of the others.
    pub(crate) fn determined_directions(&self) -> Vec<Vec<f64>> {
        let along = self.directions[..self.rank].iter().zip(&self.singular_values);
        along.map(|(v, s)| self.unscale(v).iter().map(|c| c / s).collect()).collect()
    }

    /// A step by the shared columns without what it moves along directions that the data do not determine.
    pub(crate) fn determined_part(&self, step: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = step.iter().zip(&self.scales).map(|(c, scale)| c * scale).collect();
        let dot = |v: &[f64]| v.iter().zip(&scaled).map(|(v, s)| v * s).sum::<f64>();
        let determined = &self.directions[..self.rank];
        self.unscale(&combine(determined, determined.iter().map(|v| dot(v)), step.len()))
    }

    /// Sum of squares of each row of the scaled Jacobian's projector: how many of the fitted parameters each row of `problem` takes up at
    /// `values`, where this is its analysis. They sum to the rank. Beside them the rows' whitened residuals.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn leverages(&self, problem: &Problem, values: &Values) -> Result<(Vec<f64>, Vec<f64>), EvaluateError> {
        let directions = ByColumn::of(&self.determined_directions(), self.scales.len());
        problem.made_of_rows(values, 1, |row, residual, leverage| {
            let reduced = self.eliminated.reduce(row.iter().copied());
            let mut along = vec![0.0; directions.count()];
            let square = directions.along(reduced.shared.iter().copied(), &mut along);
            leverage[0] = square + reduced.own_covariance(&reduced);
            residual
        })
    }

    /// The rows of `problem` in an orthonormal basis of what its columns span.
    ///
    /// # Errors
    /// As [`RankAnalysis::leverages`].
    pub(crate) fn basis_rows(&self, problem: &Problem, values: &Values) -> Result<BasisRows, EvaluateError> {
        let directions = ByColumn::of(&self.determined_directions(), self.scales.len());
        let has_eliminated = self.has_eliminated();
        let (shared, others) = problem.made_of_rows(values, directions.count(), |row, residual, along| {
            if !has_eliminated {
                directions.along(row.iter().copied(), along);
                return (Vec::new(), residual);
            }
            let reduced = self.eliminated.reduce(row.iter().copied());
            directions.along(reduced.shared.iter().copied(), along);
            (self.eliminated.own_entries(&reduced), residual)
        })?;
        let (eliminated, residuals): (Vec<_>, Vec<f64>) = others.into_iter().unzip();
        Ok(BasisRows {
            rank: directions.count(),
            shared,
            eliminated: if has_eliminated { eliminated } else { Vec::new() },
            own: self.eliminated.count(),
            residuals,
        })
    }

    fn unscale(&self, direction: &[f64]) -> Vec<f64> {
        direction.iter().zip(&self.scales).map(|(v, scale)| v / scale).collect()
    }
}

/// Rows in an orthonormal basis.
#[derive(Debug)]
pub(crate) struct BasisRows {
    /// Directions of the shared columns.
    pub rank: usize,
    /// So many entries a row.
    pub shared: Vec<f64>,
    /// By row, place and entry of the own directions of eliminated columns; empty where there are none.
    pub eliminated: Vec<Vec<(usize, f64)>>,
    /// How many of these there are.
    pub own: usize,
    /// Whitened residuals.
    pub residuals: Vec<f64>,
}

/// `aᵀ M b`.
fn form(matrix: &[Vec<f64>], a: &[f64], b: &[f64]) -> f64 {
    let times = |row: &Vec<f64>| row.iter().zip(b).map(|(m, b)| m * b).sum::<f64>();
    matrix.iter().zip(a).map(|(row, a)| a * times(row)).sum()
}

/// `Σ weight · vector` of vectors of `size` numbers.
fn combine(vectors: &[Vec<f64>], weights: impl Iterator<Item = f64>, size: usize) -> Vec<f64> {
    let mut sum = vec![0.0; size];
    for (vector, weight) in vectors.iter().zip(weights) {
        sum.iter_mut().zip(vector).for_each(|(sum, v)| *sum += weight * v);
    }
    sum
}
