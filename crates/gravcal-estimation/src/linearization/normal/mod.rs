//! Normal equations `JᵀJ δ = −Jᵀr`, summed over the factors in compact batches, local blocks eliminated.
//!
//! Rows of factors of one shape touch the same columns: 64 of them at a time make one small matrix product over those
//! columns alone. With island `e` of local columns and shared columns `s`, `H = JᵀJ + λ D²`,
//!
//! ```text
//!     S = H_ss − Σ_e H_se H_ee⁻¹ H_es,      S δ_s = −(g_s − Σ_e H_se H_ee⁻¹ g_e),      δ_e = −H_ee⁻¹ (g_e + H_es δ_s)
//! ```
//!
//! (Triggs and others, *Bundle adjustment: a modern synthesis*, 2000, section 6.1.) Squaring the condition costs digits:
//! where a pivot of a Cholesky factor, its columns scaled to 1, falls below [`LEAST_PIVOT`], the step comes from the
//! orthogonal factorization instead.

mod islands;
mod sums;

use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use rayon::prelude::*;

use super::{Linearization, NormalEquations, Orthogonal, StepInfo, check_finite, dust};
use crate::problem::{Chunk, Island};
use crate::reference::Pull;
use crate::{EvaluateError, Problem, Values};
use islands::{Complement, ISLANDS_PER_BATCH, IslandSums};
use sums::{Sums, sum_chunk};

/// Square of the smallest relative pivot with which a step keeps five digits in its weakest direction.
const LEAST_PIVOT: f64 = 1e-11;
/// Batches of islands whose complements are kept apart, so that they can run on any thread.
const MAX_PARTS: usize = 16;

pub(crate) struct Normal<'p> {
    problem: &'p Problem,
    values: Values,
    cost: f64,
    gradient: Vec<f64>,
    /// With the reference in them, and of the factors alone.
    column_norms: Vec<f64>,
    factor_norms: Vec<f64>,
    pull: Pull,
    /// Lower triangle over the shared columns.
    hessian: Mat<f64>,
    islands: Vec<IslandSums>,
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
            cost: sums.cost,
            gradient: vec![0.0; columns],
            column_norms: vec![0.0; columns],
            factor_norms: Vec::new(),
            pull: Pull::of(problem, values),
            hessian: sums.hessian,
            islands: sums.islands,
            orthogonal: None,
        };
        this.spread(&sums.gradient);
        check_finite(problem, values, [&this.gradient, &this.column_norms])?;
        this.clear_dust();
        this.add_pull();
        Ok(this)
    }

    /// Gradient and norms of all columns from those of the shared ones and of the islands.
    fn spread(&mut self, shared_gradient: &[f64]) {
        let structure = self.problem.structure();
        for (index, column) in structure.shared.iter().enumerate() {
            self.gradient[*column] = shared_gradient[index];
            self.column_norms[*column] = self.hessian[(index, index)].sqrt();
        }
        for (island, sums) in structure.islands.iter().zip(&self.islands) {
            for (index, column) in island.columns.iter().enumerate() {
                self.gradient[*column] = sums.gradient[index];
                self.column_norms[*column] = sums.local[index * (island.columns.len() + 1)].sqrt();
            }
        }
    }

    fn clear_dust(&mut self) {
        let columns = dust(self.problem, &self.values, &self.column_norms);
        let structure = self.problem.structure();
        for column in columns {
            self.gradient[column] = 0.0;
            self.column_norms[column] = 0.0;
            if let Ok(index) = structure.shared.binary_search(&column) {
                self.hessian.col_mut(index).fill(0.0);
                self.hessian.row_mut(index).fill(0.0);
            }
            for (island, sums) in structure.islands.iter().zip(&mut self.islands) {
                sums.clear(island, column, &structure.shared);
            }
        }
    }

    /// Adds the reference to cost, gradient and norms; the Hessian stays that of the factors.
    fn add_pull(&mut self) {
        self.factor_norms = self.column_norms.clone();
        self.cost += self.pull.cost();
        for (column, weight, distance) in &self.pull.entries {
            self.gradient[*column] += weight * distance;
            self.column_norms[*column] = self.column_norms[*column].hypot(*weight);
        }
    }

    /// The damped step, unless it would lose too many digits.
    fn reduced_step(&self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> Option<()> {
        let structure = self.problem.structure();
        let mut damping: Vec<f64> = scaling.iter().map(|d| lambda * d * d).collect();
        self.pull.entries.iter().for_each(|(column, weight, _)| damping[*column] += weight * weight);
        let mut hessian = self.hessian.clone();
        let mut right: Vec<f64> = structure.shared.iter().map(|column| -self.gradient[*column]).collect();
        for (index, column) in structure.shared.iter().enumerate() {
            hessian[(index, index)] += damping[*column];
        }
        let diagonal: Vec<f64> = (0..right.len()).map(|index| hessian[(index, index)]).collect();
        self.eliminate(&damping, &mut hessian, &mut right)?;
        let shared = solve_scaled(hessian, &diagonal, &right)?;
        structure.shared.iter().zip(&shared).for_each(|(column, value)| step[*column] = *value);
        for (island, sums) in structure.islands.iter().zip(&self.islands) {
            let local = sums.substitute(island, &damping, &shared)?;
            island.columns.iter().zip(&local).for_each(|(column, value)| step[*column] = *value);
        }
        Some(())
    }

    /// Subtracts what the islands take away: `H_se H_ee⁻¹ H_es` and `H_se H_ee⁻¹ g_e`.
    fn eliminate(&self, damping: &[f64], hessian: &mut Mat<f64>, right: &mut [f64]) -> Option<()> {
        let islands = &self.problem.structure().islands;
        let length = islands.len().div_ceil(MAX_PARTS).max(ISLANDS_PER_BATCH);
        let pairs: Vec<(&Island, &IslandSums)> = islands.iter().zip(&self.islands).collect();
        let size = right.len();
        let parts: Vec<Option<Complement>> = pairs
            .par_chunks(length)
            .map(|part| {
                let mut complement = Complement::new(size);
                part.iter().try_for_each(|(island, sums)| complement.take(island, sums, damping))?;
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
        if self.orthogonal.is_none() && self.reduced_step(lambda, scaling, step).is_some() {
            let along: f64 = self.gradient.iter().zip(&*step).map(|(g, d)| g * d).sum();
            return StepInfo { predicted_reduction: -along - 0.5 * self.image_norm_squared(step) };
        }
        self.orthogonal_step(lambda, scaling, step).unwrap_or_else(|| {
            step.fill(0.0);
            StepInfo { predicted_reduction: 0.0 }
        })
    }

    fn image_norm_squared(&self, v: &[f64]) -> f64 {
        let structure = self.problem.structure();
        let shared: Vec<f64> = structure.shared.iter().map(|column| v[*column]).collect();
        let mut sum: f64 = self.pull.entries.iter().map(|(column, weight, _)| (weight * v[*column]).powi(2)).sum();
        for (j, own) in shared.iter().enumerate() {
            let column = self.hessian.col_as_slice(j);
            let below: f64 = column[j + 1..].iter().zip(&shared[j + 1..]).map(|(entry, other)| entry * other).sum();
            sum += own * (column[j] * own + 2.0 * below);
        }
        for (island, sums) in structure.islands.iter().zip(&self.islands) {
            sum += sums.quadratic(island, &shared, v);
        }
        sum.max(0.0)
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
        for (island, sums) in structure.islands.iter().zip(&self.islands) {
            let (local, touched) = (island.columns.len(), island.shared.len());
            for (i, a) in island.columns.iter().enumerate() {
                (0..local).for_each(|j| set(*a, island.columns[j], sums.local[i * local + j]));
                (0..touched).for_each(|j| set(*a, structure.shared[island.shared[j]], sums.mixed[i * touched + j]));
            }
        }
        for (column, weight, _) in &self.pull.entries {
            hessian[column * (columns + 1)] += weight * weight;
        }
        hessian
    }

    fn normal_equations(&self) -> Option<NormalEquations> {
        let whole = || NormalEquations::new(self.problem, self.hessian.clone(), self.factor_norms.clone());
        self.islands.is_empty().then(whole)
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

/// Whether every pivot, relative to the diagonal it came from, is large enough.
fn keeps_digits(factor: &Llt<f64>, diagonal: &[f64]) -> bool {
    let triangle = factor.L();
    diagonal.iter().enumerate().all(|(i, d)| {
        let pivot = triangle[(i, i)] * triangle[(i, i)];
        pivot.is_finite() && pivot > LEAST_PIVOT * d
    })
}
