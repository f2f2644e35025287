//! Orthogonal factorization of the whitened Jacobian: no digit is lost to normal equations, and a step at another
//! damping costs only a factorization of the small triangle.
//!
//! An island of local columns `J_e` with shared columns `J_s` is factored first,
//!
//! ```text
//!     [J_e J_s r] = Q [ R_ee  R_es  z_e ]
//!                     [  0    J_s′  r′  ]
//! ```
//!
//! its upper rows determine the local step for any shared one, its lower rows join those of all other factors in one
//! triangle of the shared columns. (Björck, *Numerical methods for least squares problems*, 1996, section 6.3.)

use std::sync::Arc;

use faer::{Mat, MatRef};
use rayon::prelude::*;

use super::dust::dust;
use super::finite::check_finite;
use super::form::{Linearization, StepInfo};
use super::triangle::Triangle;
use crate::local_columns;
use crate::problem::{Chunk, Island, Rows};
use crate::reference::Pull;
use crate::{EvaluateError, Problem, Values};

#[derive(Debug)]
pub(crate) struct Orthogonal {
    shared: Vec<usize>,
    /// `[R r]` of the shared columns, all islands eliminated; at most one row more than columns.
    triangle: Mat<f64>,
    islands: Vec<Eliminated>,
    cost: f64,
    gradient: Vec<f64>,
    column_norms: Vec<f64>,
}

/// The upper rows of a factored island.
#[derive(Debug)]
struct Eliminated {
    columns: Vec<usize>,
    /// Indices among the shared columns.
    shared: Arc<[usize]>,
    /// `[R_ee R_es z_e]`, row-major, one row a local column.
    rows: Vec<f64>,
}

/// What one chunk of factors gives.
struct Part {
    cost: f64,
    triangle: Triangle,
    islands: Vec<Eliminated>,
}

impl Orthogonal {
    /// Linearizes `problem` at `values`.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn new(problem: &Problem, values: &Values) -> Result<Self, EvaluateError> {
        let structure = problem.structure();
        let run = |chunk: &Chunk| factor_chunk(problem, values, chunk);
        let parts: Vec<Result<Part, EvaluateError>> = structure.chunks.par_iter().map(run).collect();
        let mut all = Triangle::new(structure.shared.len() + 1);
        let mut islands = Vec::new();
        let mut cost = 0.0;
        for part in parts {
            let part = part?;
            cost += part.cost;
            all.push(part.triangle.rows());
            islands.extend(part.islands);
        }
        let pull = Pull::of(problem, values);
        cost += pull.cost();
        let mut row = vec![0.0; structure.shared.len() + 1];
        for (column, weight, distance) in &pull.entries {
            // Only shared columns have one.
            if let Ok(index) = structure.shared.binary_search(column) {
                row.fill(0.0);
                (row[index], row[structure.shared.len()]) = (*weight, *distance);
                all.push(&row);
            }
        }
        all.factor();
        let columns = problem.columns().len();
        let mut this = Orthogonal {
            shared: structure.shared.clone(),
            triangle: all.matrix(),
            islands,
            cost,
            gradient: vec![0.0; columns],
            column_norms: vec![0.0; columns],
        };
        this.measure_columns();
        check_finite(problem, values, [&this.gradient, &this.column_norms])?;
        this.clear_dust(problem, values);
        Ok(this)
    }

    /// Gradient and column norms, from the factors: their products are those of J.
    fn measure_columns(&mut self) {
        let mut squares = vec![0.0; self.column_norms.len()];
        let mut gradient = std::mem::take(&mut self.gradient);
        let mut add = |column: usize, entry: f64, residual: f64| {
            squares[column] += entry * entry;
            gradient[column] += entry * residual;
        };
        let width = self.shared.len();
        for row in self.triangle.row_iter() {
            self.shared.iter().enumerate().for_each(|(j, column)| add(*column, row[j], row[width]));
        }
        for island in &self.islands {
            let shared = island.shared.iter().map(|index| self.shared[*index]);
            let columns: Vec<usize> = island.columns.iter().copied().chain(shared).collect();
            for row in island.rows.chunks_exact(columns.len() + 1) {
                columns.iter().zip(row).for_each(|(column, entry)| add(*column, *entry, row[columns.len()]));
            }
        }
        self.gradient = gradient;
        self.column_norms = squares.iter().map(|s: &f64| s.sqrt()).collect();
    }

    fn clear_dust(&mut self, problem: &Problem, values: &Values) {
        let columns = dust(problem, values, &self.column_norms);
        for column in columns {
            self.gradient[column] = 0.0;
            self.column_norms[column] = 0.0;
            if let Ok(index) = self.shared.binary_search(&column) {
                self.triangle.col_mut(index).fill(0.0);
            }
            for island in &mut self.islands {
                island.clear(column, &self.shared);
            }
        }
    }

    /// The triangular factor of the whitened Jacobian's shared columns, with all local ones eliminated: without local
    /// columns it has the Jacobian's singular values and null space.
    pub fn triangle(&self) -> MatRef<'_, f64> {
        self.triangle.get(.., 0..self.shared.len())
    }

    /// The same with the residual as its last column: `[R z]` of all columns, where none are local.
    pub fn augmented_triangle(&self) -> MatRef<'_, f64> {
        self.triangle.as_ref()
    }

    /// # Errors
    /// Names a local block that its own factors do not determine.
    pub fn check_local_columns(&self, problem: &Problem) -> Result<(), EvaluateError> {
        let islands = &self.islands;
        islands.iter().try_for_each(|island| local_columns::check(problem, &island.columns, &island.rows))
    }

    /// Calls `found(entries)` for every row of the factors, over all columns.
    fn for_rows(&self, mut found: impl FnMut(&mut dyn Iterator<Item = (usize, f64)>)) {
        for row in self.triangle.row_iter() {
            found(&mut self.shared.iter().enumerate().map(|(j, column)| (*column, row[j])));
        }
        for island in &self.islands {
            for row in island.rows.chunks_exact(island.width()) {
                let shared = island.shared.iter().map(|index| self.shared[*index]);
                let columns = island.columns.iter().copied().chain(shared);
                found(&mut columns.zip(row.iter().copied()));
            }
        }
    }
}

impl Eliminated {
    fn width(&self) -> usize {
        self.columns.len() + self.shared.len() + 1
    }

    fn clear(&mut self, column: usize, shared: &[usize]) {
        let width = self.width();
        let own = self.columns.iter().position(|c| *c == column);
        let other = self.shared.iter().position(|index| shared[*index] == column);
        if let Some(at) = own.or(other.map(|at| self.columns.len() + at)) {
            self.rows.chunks_exact_mut(width).for_each(|row| row[at] = 0.0);
        }
    }

    /// `[R_ee R_es z_e]` with `√λ D` below its local columns, factored again: the upper rows, and the lower ones
    /// without the local columns.
    fn damped(&self, root: f64, scaling: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (local, width) = (self.columns.len(), self.width());
        let damping = self.columns.iter().enumerate().flat_map(|(index, column)| {
            (0..width).map(move |j| if j == index { root * scaling[*column] } else { 0.0 })
        });
        let stacked: Vec<f64> = self.rows.iter().copied().chain(damping).collect();
        split(&stacked, local, width)
    }
}

/// Factors rows of `width` numbers; gives the first `local` rows of the triangle, and the rest without the first `local`
/// columns.
fn split(rows: &[f64], local: usize, width: usize) -> (Vec<f64>, Vec<f64>) {
    let factored = MatRef::from_row_major_slice(rows, rows.len() / width, width).qr();
    let r = factored.thin_R();
    let entry = |i: usize, j: usize| if i < r.nrows() && j >= i { r[(i, j)] } else { 0.0 };
    let upper = (0..local).flat_map(|i| (0..width).map(move |j| entry(i, j))).collect();
    let lower = (local..r.nrows()).flat_map(|i| (local..width).map(move |j| entry(i, j))).collect();
    (upper, lower)
}

fn factor_chunk(problem: &Problem, values: &Values, chunk: &Chunk) -> Result<Part, EvaluateError> {
    let structure = problem.structure();
    let mut rows = Rows::new(problem, values);
    let mut part = Part { cost: 0.0, triangle: Triangle::new(structure.shared.len() + 1), islands: Vec::new() };
    let islands = &structure.islands[chunk.islands.clone()];
    let free_end = islands.first().map_or(chunk.factors.end, |first| first.factors.start);
    let mut compact = Vec::new();
    let mut wide = vec![0.0; structure.shared.len() + 1];
    for factor in &structure.order[chunk.factors.start..free_end] {
        part.cost += rows.linearize(*factor, true)?;
        rows.check_jacobian(*factor)?;
        for (row, plan) in problem.plans(*factor).iter().enumerate() {
            compact.resize(plan.columns.len() + 1, 0.0);
            rows.gather(plan, row, &mut compact);
            wide.fill(0.0);
            plan.columns.iter().zip(&compact).for_each(|(column, entry)| wide[*column] = *entry);
            wide[structure.shared.len()] = rows.residual(row);
            part.triangle.push(&wide);
        }
    }
    for island in islands {
        eliminate(problem, &mut rows, island, &mut part)?;
    }
    part.triangle.factor();
    Ok(part)
}

/// Factors one island: its upper rows are kept, its lower ones join the triangle.
fn eliminate(problem: &Problem, rows: &mut Rows<'_>, island: &Island, part: &mut Part) -> Result<(), EvaluateError> {
    let (upper, lower) = split_island(problem, rows, island, &mut part.cost)?;
    widen(&lower, island.shared.as_ref(), problem.structure().shared.len(), &mut part.triangle);
    part.islands.push(Eliminated { columns: island.columns.clone(), shared: Arc::clone(&island.shared), rows: upper });
    Ok(())
}

/// `[R_ee R_es z_e]` of one island at `values`, with some columns cleared.
///
/// # Errors
/// Where a residual cannot be evaluated there.
pub(crate) fn factor_island(
    problem: &Problem,
    values: &Values,
    island: &Island,
    cleared: &[usize],
) -> Result<Vec<f64>, EvaluateError> {
    let (upper, _) = split_island(problem, &mut Rows::new(problem, values), island, &mut 0.0)?;
    let mut island = Eliminated { columns: island.columns.clone(), shared: Arc::clone(&island.shared), rows: upper };
    cleared.iter().for_each(|column| island.clear(*column, &problem.structure().shared));
    Ok(island.rows)
}

/// The rows of an island, its local columns eliminated: upper and lower ones. Adds its factors' cost.
fn split_island(
    problem: &Problem,
    rows: &mut Rows<'_>,
    island: &Island,
    cost: &mut f64,
) -> Result<(Vec<f64>, Vec<f64>), EvaluateError> {
    let (local, touched) = (island.columns.len(), island.shared.len());
    let width = local + touched + 1;
    let mut stacked = Vec::new();
    let mut compact = Vec::new();
    for factor in &problem.structure().order[island.factors.clone()] {
        *cost += rows.linearize(*factor, true)?;
        rows.check_jacobian(*factor)?;
        for (row, plan) in problem.plans(*factor).iter().enumerate() {
            let start = stacked.len();
            stacked.resize(start + width, 0.0);
            let out = &mut stacked[start..];
            rows.for_island(*factor, row, |index, entry| out[index] = entry);
            compact.resize(plan.columns.len() + 1, 0.0);
            rows.gather(plan, row, &mut compact);
            for (column, entry) in plan.columns.iter().zip(&compact) {
                if let Ok(at) = island.shared.binary_search(column) {
                    out[local + at] = *entry;
                }
            }
            out[width - 1] = rows.residual(row);
        }
    }
    Ok(split(&stacked, local, width))
}

/// Pushes rows over some shared columns (and the residual) as rows over all of them.
fn widen(rows: &[f64], touched: &[usize], shared: usize, triangle: &mut Triangle) {
    let mut wide = vec![0.0; shared + 1];
    for row in rows.chunks_exact(touched.len() + 1) {
        touched.iter().zip(row).for_each(|(index, entry)| wide[*index] = *entry);
        wide[shared] = row[touched.len()];
        triangle.push(&wide);
    }
}

impl Linearization for Orthogonal {
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
        let (root, columns) = (lambda.sqrt(), self.shared.len());
        // [R | r; √λ D | 0] and what the damped islands add: the step without ever squaring the condition.
        let mut stacked = Triangle::new(columns + 1);
        let mut row = vec![0.0; columns + 1];
        for given in self.triangle.row_iter() {
            row.iter_mut().zip(given.iter()).for_each(|(entry, value)| *entry = *value);
            stacked.push(&row);
        }
        row.fill(0.0);
        for (index, column) in self.shared.iter().enumerate() {
            row[index] = root * scaling[*column];
            stacked.push(&row);
            row[index] = 0.0;
        }
        let islands: Vec<(Vec<f64>, Vec<f64>)> =
            self.islands.par_iter().map(|island| island.damped(root, scaling)).collect();
        for (island, (_, lower)) in self.islands.iter().zip(&islands) {
            widen(lower, &island.shared, columns, &mut stacked);
        }
        stacked.factor();
        let shared = solve_triangle(&stacked.matrix(), columns);
        self.shared.iter().zip(&shared).for_each(|(column, value)| step[*column] = *value);
        for (island, (upper, _)) in self.islands.iter().zip(&islands) {
            island.substitute(upper, &shared, step);
        }
        let along: f64 = self.gradient.iter().zip(&*step).map(|(g, d)| g * d).sum();
        StepInfo { predicted_reduction: -along - 0.5 * self.image_norm_squared(step) }
    }

    fn image_norm_squared(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        self.for_rows(|row| sum += row.map(|(column, entry)| entry * v[column]).sum::<f64>().powi(2));
        sum
    }

    fn hessian(&self) -> Vec<f64> {
        let columns = self.column_norms.len();
        let mut hessian = vec![0.0; columns * columns];
        self.for_rows(|row| {
            let row: Vec<(usize, f64)> = row.filter(|(_, entry)| *entry != 0.0).collect();
            for (i, a) in &row {
                row.iter().for_each(|(j, b)| hessian[i * columns + j] += a * b);
            }
        });
        hessian
    }
}

impl Eliminated {
    /// The local step that follows from the shared one: `R_ee δ_e = −z_e − R_es δ_s`.
    fn substitute(&self, upper: &[f64], shared: &[f64], step: &mut [f64]) {
        let (local, width) = (self.columns.len(), self.width());
        for i in (0..local).rev() {
            let row = &upper[i * width..(i + 1) * width];
            let by_shared: f64 =
                self.shared.iter().zip(&row[local..]).map(|(index, entry)| entry * shared[*index]).sum();
            let by_local: f64 = (i + 1..local).map(|j| row[j] * step[self.columns[j]]).sum();
            let right = -row[width - 1] - by_shared - by_local;
            step[self.columns[i]] = if row[i] == 0.0 { 0.0 } else { right / row[i] };
        }
    }
}

/// Solves `R δ = −z` for `[R z]`; a row without a diagonal (no information, no damping) leaves its unknown at zero.
fn solve_triangle(triangle: &Mat<f64>, columns: usize) -> Vec<f64> {
    let mut solution = vec![0.0; columns];
    for i in (0..columns.min(triangle.nrows())).rev() {
        let known: f64 = (i + 1..columns).map(|j| triangle[(i, j)] * solution[j]).sum();
        let right = -triangle[(i, columns)] - known;
        solution[i] = if triangle[(i, i)] == 0.0 { 0.0 } else { right / triangle[(i, i)] };
    }
    solution
}
