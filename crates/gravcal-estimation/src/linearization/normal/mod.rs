//! Normal equations `JᵀJ δ = −Jᵀr`, summed over the factors in compact batches, after elimination.
//!
//! Rows of factors of one shape touch the same columns: 64 of them at a time make one small matrix product over those
//! columns alone. With component `e` of eliminated columns and shared columns `s`, `H = JᵀJ + λ D²`,
//!
//! ```text
//!     S = H_ss − Σ_e H_se H_ee⁻¹ H_es,      S δ_s = −(g_s − Σ_e H_se H_ee⁻¹ g_e),      δ_e = −H_ee⁻¹ (g_e + H_es δ_s)
//! ```
//!
//! (Triggs and others, *Bundle adjustment: a modern synthesis*, 2000, section 6.1.) Components whose eliminated columns are known by rows of their
//! own, as errors of single readings are, are batched and keep nothing in memory: see [`alike`]. Squaring the condition costs digits:
//! where a pivot of a Cholesky factor, its columns scaled to 1, falls below [`LEAST_PIVOT`](pivots::LEAST_PIVOT), the step comes from the
//! orthogonal factorization instead.

mod alike;
mod components;
mod group;
mod lanes;
mod pivots;
mod products;
mod sums;

use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::finite::check_finite;
use super::form::{Linearization, StepInfo};
use super::negligible::negligible;
use super::{NormalEquations, Orthogonal};
use crate::problem::{Chunk, Component};
use crate::reference::Pull;
use crate::{EvaluateError, Problem, Values};
pub(crate) use alike::Alike;
use alike::{EliminatedSums, runs_among};
use components::{COMPONENTS_PER_BATCH, Complement, ComponentSums};
use pivots::{LEAST_DAMPING, keeps_digits};
use sums::{Sums, sum_chunk};

/// Batches of components whose complements are kept apart, so that they can run on any thread.
const MAX_PARTS: usize = 16;

pub(crate) struct Normal<'p> {
    problem: &'p Problem,
    values: Values,
    cost: f64,
    gradient: Vec<f64>,
    column_norms: Vec<f64>,
    /// The same of the factors alone, where the problem has a reference.
    factor_norms: Option<Vec<f64>>,
    pull: Pull,
    /// Lower triangle over the shared columns, and their gradient, of all but the rows of components that are alike.
    hessian: Mat<f64>,
    gradient_of_rest: Vec<f64>,
    /// Squares of the norms of the shared columns, of all factors.
    shared_squares: Vec<f64>,
    /// Of those components that are not alike.
    components: Vec<ComponentSums>,
    /// Columns that count as zeros.
    negligible: Vec<usize>,
    /// Made when the normal equations lost too many digits.
    orthogonal: Option<Orthogonal>,
}

impl<'p> Normal<'p> {
    /// Linearizes `problem` at `values`.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn new(problem: &'p Problem, values: &Values) -> Result<Self, EvaluateError> {
        let structure = problem.structure();
        let run = |chunk: &Chunk| sum_chunk(problem, values, chunk);
        let parts: Vec<Result<Sums, EvaluateError>> = structure.chunks.par_iter().map(run).collect();
        let mut sums = Sums::new(structure.shared.len());
        for part in parts {
            sums.add(part?);
        }
        let columns = problem.columns().len();
        let mut this = Normal {
            problem,
            values: values.clone(),
            cost: sums.cost + sums.alike.cost,
            gradient: vec![0.0; columns],
            column_norms: vec![0.0; columns],
            factor_norms: None,
            pull: Pull::of(problem, values),
            hessian: sums.hessian,
            gradient_of_rest: sums.gradient,
            shared_squares: vec![0.0; structure.shared.len()],
            components: sums.components,
            negligible: Vec::new(),
            orthogonal: None,
        };
        this.spread(&sums.alike);
        check_finite(problem, values, [&this.gradient, &this.column_norms])?;
        this.clear_negligible();
        this.add_pull();
        Ok(this)
    }

    /// The components that are not alike.
    fn others(problem: &Problem) -> impl Iterator<Item = &Component> {
        let structure = problem.structure();
        structure.components.iter().filter(|component| !structure.kinds[component.kind].reweighed)
    }

    /// Those that are, if there are any.
    fn alike(&self) -> Option<Alike<'_, '_>> {
        let alike = Alike { problem: self.problem, values: &self.values, left_out: &self.negligible };
        alike.any().then_some(alike)
    }

    /// Gradient and norms of all columns from those of the shared ones and of the components.
    fn spread(&mut self, alike: &EliminatedSums) {
        let problem = self.problem;
        let structure = problem.structure();
        for (index, column) in structure.shared.iter().enumerate() {
            let [slope, square] = alike.shared[index];
            self.gradient[*column] = self.gradient_of_rest[index] + slope;
            self.shared_squares[index] = self.hessian[(index, index)] + square;
            self.column_norms[*column] = self.shared_squares[index].sqrt();
        }
        let columns = runs_among(&structure.components, problem).flatten().flat_map(|component| &component.columns);
        for (column, [slope, square]) in columns.zip(&alike.columns) {
            self.gradient[*column] = *slope;
            self.column_norms[*column] = square.sqrt();
        }
        for (component, sums) in Self::others(problem).zip(&self.components) {
            for (index, column) in component.columns.iter().enumerate() {
                self.gradient[*column] = sums.gradient[index];
                self.column_norms[*column] = sums.eliminated[index * (component.columns.len() + 1)].sqrt();
            }
        }
    }

    fn clear_negligible(&mut self) {
        self.negligible = negligible(self.problem, &self.values, &self.column_norms);
        let structure = self.problem.structure();
        for column in self.negligible.iter().copied() {
            self.gradient[column] = 0.0;
            self.column_norms[column] = 0.0;
            if let Ok(index) = structure.shared.binary_search(&column) {
                self.hessian.col_mut(index).fill(0.0);
                self.hessian.row_mut(index).fill(0.0);
                self.gradient_of_rest[index] = 0.0;
                self.shared_squares[index] = 0.0;
            }
            for (component, sums) in Self::others(self.problem).zip(&mut self.components) {
                sums.clear(component, column, &structure.shared);
            }
        }
    }

    /// Adds the reference to cost, gradient and norms; the Hessian stays that of the factors.
    fn add_pull(&mut self) {
        self.factor_norms = (!self.pull.entries.is_empty()).then(|| self.column_norms.clone());
        self.cost += self.pull.cost();
        for (column, weight, distance) in &self.pull.entries {
            self.gradient[*column] += weight * distance;
            if let Ok(index) = self.problem.structure().shared.binary_search(column) {
                self.gradient_of_rest[index] += weight * distance;
            }
            self.column_norms[*column] = self.column_norms[*column].hypot(*weight);
        }
    }

    fn factor_norms(&self) -> &[f64] {
        self.factor_norms.as_ref().unwrap_or(&self.column_norms)
    }

    /// The damped step and `‖J δ‖²` of it, unless it would lose too many digits.
    fn reduced_step(&self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> Option<f64> {
        let structure = self.problem.structure();
        let mut damping: Vec<f64> = scaling.iter().map(|d| lambda * d * d).collect();
        self.pull.entries.iter().for_each(|(column, weight, _)| damping[*column] += weight * weight);
        let mut hessian = self.hessian.clone();
        let mut right: Vec<f64> = self.gradient_of_rest.iter().map(|slope| -slope).collect();
        for (index, column) in structure.shared.iter().enumerate() {
            hessian[(index, index)] += damping[*column];
        }
        let squares = structure.shared.iter().zip(&self.shared_squares);
        let diagonal: Vec<f64> = squares.map(|(column, square)| square + damping[*column]).collect();
        self.eliminate(&damping, &mut hessian, &mut right)?;
        let shared = solve_scaled(hessian, &diagonal, &right)?;
        structure.shared.iter().zip(&shared).for_each(|(column, value)| step[*column] = *value);
        let mut image = self.alike().map_or(Some(0.0), |alike| alike.substitute(&damping, &shared, step))?;
        for (component, sums) in Self::others(self.problem).zip(&self.components) {
            let eliminated = sums.substitute(component, &damping, &shared)?;
            component.columns.iter().zip(&eliminated).for_each(|(column, value)| step[*column] = *value);
        }
        image += self.image_of_rest(step, &shared);
        Some(image)
    }

    /// Subtracts what the components take away: `H_se H_ee⁻¹ H_es` and `H_se H_ee⁻¹ g_e`.
    fn eliminate(&self, damping: &[f64], hessian: &mut Mat<f64>, right: &mut [f64]) -> Option<()> {
        for part in self.alike().map_or(Some(Vec::new()), |alike| alike.eliminate(damping))? {
            *hessian += &part.hessian;
            right.iter_mut().zip(&part.gradient).for_each(|(right, part)| *right -= part);
        }
        let pairs: Vec<(&Component, &ComponentSums)> = Self::others(self.problem).zip(&self.components).collect();
        let length = pairs.len().div_ceil(MAX_PARTS).max(COMPONENTS_PER_BATCH);
        let size = right.len();
        let parts: Vec<Option<Complement>> = pairs
            .par_chunks(length)
            .map(|part| {
                let mut complement = Complement::new(size);
                part.iter().try_for_each(|(component, sums)| complement.take(component, sums, damping))?;
                complement.flush();
                Some(complement)
            })
            .collect();
        for part in parts {
            let part = part?;
            *hessian -= &part.hessian;
            right.iter_mut().zip(&part.right).for_each(|(right, part)| *right += part);
        }
        Some(())
    }

    /// `‖J v‖²` of all but the rows of components that are alike; `shared`: the shared part of `v`.
    fn image_of_rest(&self, v: &[f64], shared: &[f64]) -> f64 {
        let mut sum: f64 = self.pull.entries.iter().map(|(column, weight, _)| (weight * v[*column]).powi(2)).sum();
        for (j, own) in shared.iter().enumerate() {
            let column = self.hessian.col_as_slice(j);
            let below: f64 = column[j + 1..].iter().zip(&shared[j + 1..]).map(|(entry, other)| entry * other).sum();
            sum += own * (column[j] * own + 2.0 * below);
        }
        for (component, sums) in Self::others(self.problem).zip(&self.components) {
            sum += sums.quadratic(component, shared, v);
        }
        sum.max(0.0)
    }

    fn orthogonal_step(&mut self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> Option<StepInfo> {
        if self.orthogonal.is_none() {
            self.orthogonal = Orthogonal::new(self.problem, &self.values).ok();
        }
        self.orthogonal.as_mut().map(|orthogonal| orthogonal.damped_step(lambda, scaling, step))
    }
}

impl Linearization for Normal<'_> {
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
        let reduced = || self.reduced_step(lambda, scaling, step);
        if let Some(image) = self.orthogonal.is_none().then(reduced).flatten() {
            let along: f64 = self.gradient.iter().zip(&*step).map(|(g, d)| g * d).sum();
            return StepInfo { predicted_reduction: -along - 0.5 * image };
        }
        self.orthogonal_step(lambda, scaling, step).unwrap_or_else(|| {
            step.fill(0.0);
            StepInfo { predicted_reduction: 0.0 }
        })
    }

    fn least_damping(&self) -> f64 {
        self.orthogonal.as_ref().map_or(LEAST_DAMPING, Linearization::least_damping)
    }

    fn image_norm_squared(&self, v: &[f64]) -> f64 {
        let shared: Vec<f64> = self.problem.structure().shared.iter().map(|column| v[*column]).collect();
        self.image_of_rest(v, &shared) + self.alike().map_or(0.0, |alike| alike.image_norm_squared(v, &shared))
    }

    fn hessian(&self) -> Vec<f64> {
        let structure = self.problem.structure();
        let columns = self.gradient.len();
        let mut hessian = vec![0.0; columns * columns];
        let mut set = |a: usize, b: usize, value: f64| {
            hessian[a * columns + b] = value;
            hessian[b * columns + a] = value;
        };
        for (j, b) in structure.shared.iter().enumerate() {
            (j..structure.shared.len()).for_each(|i| set(structure.shared[i], *b, self.hessian[(i, j)]));
        }
        for (component, sums) in Self::others(self.problem).zip(&self.components) {
            let (eliminated, touched) = (component.columns.len(), component.shared.len());
            for (i, a) in component.columns.iter().enumerate() {
                (0..eliminated).for_each(|j| set(*a, component.columns[j], sums.eliminated[i * eliminated + j]));
                (0..touched).for_each(|j| set(*a, structure.shared[component.shared[j]], sums.mixed[i * touched + j]));
            }
        }
        if let Some(alike) = self.alike() {
            let done = alike.for_hessian(|a, b, entry| hessian[a * columns + b] += entry);
            if done.is_err() {
                hessian.fill(f64::NAN); // they were evaluated there before
            }
        }
        for (column, weight, _) in &self.pull.entries {
            hessian[column * (columns + 1)] += weight * weight;
        }
        hessian
    }

    fn normal_equations(&self) -> Option<NormalEquations> {
        let mut hessian = self.hessian.clone();
        let (undamped, mut right) = (vec![0.0; self.gradient.len()], vec![0.0; hessian.nrows()]);
        // Other components are eliminated by subtraction, which loses digits that a judgement needs.
        let done = self.components.is_empty().then(|| self.eliminate(&undamped, &mut hessian, &mut right)).flatten();
        done.map(|()| NormalEquations::new(self.problem, hessian, self.factor_norms().to_vec()))
    }
}

/// Solves `A x = b` by Cholesky after scaling the diagonal (before elimination) to one; of `A` the lower triangle counts.
fn solve_scaled(mut matrix: Mat<f64>, diagonal: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let scale: Vec<f64> = diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect();
    for (j, own) in scale.iter().enumerate() {
        let column = &mut matrix.col_as_slice_mut(j)[j..];
        column.iter_mut().zip(&scale[j..]).for_each(|(entry, other)| *entry *= own * other);
        // Columns of zeros stay where they are.
        if diagonal[j] <= 0.0 {
            column[0] = 1.0;
        }
    }
    let factor = Llt::new(matrix.as_ref(), Side::Lower).ok()?;
    if !keeps_digits(&factor, &vec![1.0; right.len()]) {
        return None;
    }
    let mut solution = Mat::from_fn(right.len(), 1, |i, _| scale[i] * right[i]);
    faer::linalg::solvers::SolveCore::solve_in_place_with_conj(&factor, faer::Conj::No, solution.as_mut());
    Some((0..right.len()).map(|i| scale[i] * solution[(i, 0)]).collect())
}
