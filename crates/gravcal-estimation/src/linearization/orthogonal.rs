//! Orthogonal factorization of the whitened Jacobian: no digit is lost to normal equations, and a step at another
//! damping costs only a factorization of the small triangle.
//!
//! A component of eliminated columns `J_e` with shared columns `J_s` is factored first,
//!
//! ```text
//!     [J_e J_s r] = Q [ R_ee  R_es  z_e ]
//!                     [  0    J_s′  r′  ]
//! ```
//!
//! its upper rows determine the eliminated step for any shared one, its lower rows join those of all other factors in one
//! triangle of the shared columns. (Björck, *Numerical methods for least squares problems*, 1996, section 6.3.)

use std::sync::Arc;

use faer::{Mat, MatRef};
use rayon::prelude::*;

use super::finite::check_finite;
use super::form::{Linearization, StepInfo};
use super::negligible::negligible;
use super::triangle::Triangle;
use crate::eliminated_columns;
use crate::problem::{Chunk, Component, Rows};
use crate::reference::Pull;
use crate::{EvaluateError, Problem, Values};

#[derive(Debug)]
pub(crate) struct Orthogonal {
    shared: Vec<usize>,
    /// `[R r]` of the shared columns, all components eliminated; at most one row more than columns.
    triangle: Mat<f64>,
    components: Vec<Eliminated>,
    cost: f64,
    gradient: Vec<f64>,
    column_norms: Vec<f64>,
}

/// The upper rows of a factored component.
#[derive(Debug)]
struct Eliminated {
    columns: Vec<usize>,
    /// Indices among the shared columns.
    shared: Arc<[usize]>,
    /// `[R_ee R_es z_e]`, row-major, one row an eliminated column.
    rows: Vec<f64>,
}

/// What one chunk of factors gives.
struct Part {
    cost: f64,
    triangle: Triangle,
    components: Vec<Eliminated>,
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
        let mut components = Vec::new();
        let mut cost = 0.0;
        for part in parts {
            let part = part?;
            cost += part.cost;
            all.push(part.triangle.rows());
            components.extend(part.components);
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
            components,
            cost,
            gradient: vec![0.0; columns],
            column_norms: vec![0.0; columns],
        };
        this.measure_columns();
        check_finite(problem, values, [&this.gradient, &this.column_norms])?;
        this.clear_negligible(problem, values);
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
        for component in &self.components {
            let shared = component.shared.iter().map(|index| self.shared[*index]);
            let columns: Vec<usize> = component.columns.iter().copied().chain(shared).collect();
            for row in component.rows.chunks_exact(columns.len() + 1) {
                columns.iter().zip(row).for_each(|(column, entry)| add(*column, *entry, row[columns.len()]));
            }
        }
        self.gradient = gradient;
        self.column_norms = squares.iter().map(|s: &f64| s.sqrt()).collect();
    }

    fn clear_negligible(&mut self, problem: &Problem, values: &Values) {
        let columns = negligible(problem, values, &self.column_norms);
        for column in columns {
            self.gradient[column] = 0.0;
            self.column_norms[column] = 0.0;
            if let Ok(index) = self.shared.binary_search(&column) {
                self.triangle.col_mut(index).fill(0.0);
            }
            for component in &mut self.components {
                component.clear(column, &self.shared);
            }
        }
    }

    /// The triangular factor of the whitened Jacobian's shared columns, after elimination: without eliminated
    /// columns it has the Jacobian's singular values and null space.
    pub fn triangle(&self) -> MatRef<'_, f64> {
        self.triangle.get(.., 0..self.shared.len())
    }

    /// The same with the residual as its last column: `[R z]` of all columns, where none are eliminated.
    pub fn augmented_triangle(&self) -> MatRef<'_, f64> {
        self.triangle.as_ref()
    }

    /// # Errors
    /// Names an eliminated block that its own factors do not determine.
    pub fn check_eliminated_columns(&self, problem: &Problem) -> Result<(), EvaluateError> {
        let components = &self.components;
        components
            .iter()
            .try_for_each(|component| eliminated_columns::check(problem, &component.columns, &component.rows))
    }

    /// Calls `found(entries)` for every row of the factors, over all columns.
    fn for_rows(&self, mut found: impl FnMut(&mut dyn Iterator<Item = (usize, f64)>)) {
        for row in self.triangle.row_iter() {
            found(&mut self.shared.iter().enumerate().map(|(j, column)| (*column, row[j])));
        }
        for component in &self.components {
            for row in component.rows.chunks_exact(component.width()) {
                let shared = component.shared.iter().map(|index| self.shared[*index]);
                let columns = component.columns.iter().copied().chain(shared);
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

    /// `[R_ee R_es z_e]` with `√λ D` below its eliminated columns, factored again: the upper rows, and the lower ones
    /// without the eliminated columns.
    fn damped(&self, root: f64, scaling: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (eliminated, width) = (self.columns.len(), self.width());
        let damping = self.columns.iter().enumerate().flat_map(|(index, column)| {
            (0..width).map(move |j| if j == index { root * scaling[*column] } else { 0.0 })
        });
        let stacked: Vec<f64> = self.rows.iter().copied().chain(damping).collect();
        split(&stacked, eliminated, width)
    }
}

/// Factors rows of `width` numbers; gives the first `eliminated` rows of the triangle, and the rest without the first `eliminated`
/// columns.
fn split(rows: &[f64], eliminated: usize, width: usize) -> (Vec<f64>, Vec<f64>) {
    let factored = MatRef::from_row_major_slice(rows, rows.len() / width, width).qr();
    let r = factored.thin_R();
    let entry = |i: usize, j: usize| if i < r.nrows() && j >= i { r[(i, j)] } else { 0.0 };
    let upper = (0..eliminated).flat_map(|i| (0..width).map(move |j| entry(i, j))).collect();
    let lower = (eliminated..r.nrows()).flat_map(|i| (eliminated..width).map(move |j| entry(i, j))).collect();
    (upper, lower)
}

fn factor_chunk(problem: &Problem, values: &Values, chunk: &Chunk) -> Result<Part, EvaluateError> {
    let structure = problem.structure();
    let mut rows = Rows::new(problem, values);
    let mut part = Part { cost: 0.0, triangle: Triangle::new(structure.shared.len() + 1), components: Vec::new() };
    let components = &structure.components[chunk.components.clone()];
    let mut compact = Vec::new();
    let mut wide = vec![0.0; structure.shared.len() + 1];
    for factor in structure.free_factors(chunk) {
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
    for component in components {
        eliminate(problem, &mut rows, component, &mut part)?;
    }
    part.triangle.factor();
    Ok(part)
}

/// Factors one component: its upper rows are kept, its lower ones join the triangle.
fn eliminate(
    problem: &Problem,
    rows: &mut Rows<'_>,
    component: &Component,
    part: &mut Part,
) -> Result<(), EvaluateError> {
    let (upper, lower) = split_component(problem, rows, component, &mut part.cost)?;
    widen(&lower, component.shared.as_ref(), problem.structure().shared.len(), &mut part.triangle);
    part.components.push(Eliminated {
        columns: component.columns.clone(),
        shared: Arc::clone(&component.shared),
        rows: upper,
    });
    Ok(())
}

/// `[R_ee R_es z_e]` of one component at `values`, with some columns cleared.
///
/// # Errors
/// Where a residual cannot be evaluated there.
pub(crate) fn factor_component(
    problem: &Problem,
    values: &Values,
    component: &Component,
    cleared: &[usize],
) -> Result<Vec<f64>, EvaluateError> {
    let (upper, _) = split_component(problem, &mut Rows::new(problem, values), component, &mut 0.0)?;
    let mut component =
        Eliminated { columns: component.columns.clone(), shared: Arc::clone(&component.shared), rows: upper };
    cleared.iter().for_each(|column| component.clear(*column, &problem.structure().shared));
    Ok(component.rows)
}

/// The rows of a component, its columns eliminated: upper and lower ones. Adds its factors' cost.
fn split_component(
    problem: &Problem,
    rows: &mut Rows<'_>,
    component: &Component,
    cost: &mut f64,
) -> Result<(Vec<f64>, Vec<f64>), EvaluateError> {
    let (eliminated, touched) = (component.columns.len(), component.shared.len());
    let width = eliminated + touched + 1;
    let mut stacked = Vec::new();
    let mut compact = Vec::new();
    for factor in &problem.structure().order[component.factors.clone()] {
        *cost += rows.linearize(*factor, true)?;
        rows.check_jacobian(*factor)?;
        for (row, plan) in problem.plans(*factor).iter().enumerate() {
            let start = stacked.len();
            stacked.resize(start + width, 0.0);
            let out = &mut stacked[start..];
            rows.for_component(*factor, row, |index, entry| out[index] = entry);
            compact.resize(plan.columns.len() + 1, 0.0);
            rows.gather(plan, row, &mut compact);
            for (column, entry) in plan.columns.iter().zip(&compact) {
                if let Ok(at) = component.shared.binary_search(column) {
                    out[eliminated + at] = *entry;
                }
            }
            out[width - 1] = rows.residual(row);
        }
    }
    Ok(split(&stacked, eliminated, width))
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
        // [R | r; √λ D | 0] and what the damped components add: the step without ever squaring the condition.
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
        let components: Vec<(Vec<f64>, Vec<f64>)> =
            self.components.par_iter().map(|component| component.damped(root, scaling)).collect();
        for (component, (_, lower)) in self.components.iter().zip(&components) {
            widen(lower, &component.shared, columns, &mut stacked);
        }
        stacked.factor();
        let shared = solve_triangle(&stacked.matrix(), columns);
        self.shared.iter().zip(&shared).for_each(|(column, value)| step[*column] = *value);
        for (component, (upper, _)) in self.components.iter().zip(&components) {
            component.substitute(upper, &shared, step);
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
    /// The eliminated step that follows from the shared one: `R_ee δ_e = −z_e − R_es δ_s`.
    fn substitute(&self, upper: &[f64], shared: &[f64], step: &mut [f64]) {
        let (eliminated, width) = (self.columns.len(), self.width());
        for i in (0..eliminated).rev() {
            let row = &upper[i * width..(i + 1) * width];
            let by_shared: f64 =
                self.shared.iter().zip(&row[eliminated..]).map(|(index, entry)| entry * shared[*index]).sum();
            let by_eliminated: f64 = (i + 1..eliminated).map(|j| row[j] * step[self.columns[j]]).sum();
            let right = -row[width - 1] - by_shared - by_eliminated;
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
