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

use std::sync::Arc;

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::Llt;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use rayon::prelude::*;

use super::vector_registers::give_up_upper_halves;
use super::{Linearization, Orthogonal, StepInfo, check_finite, dust};
use crate::problem::{Chunk, Island, Rows};
use crate::{EvaluateError, Problem, Values};

/// Rows of one shape and place that are multiplied at once.
const BATCH: usize = 64;
/// Square of the smallest relative pivot with which a step keeps five digits in its weakest direction.
const LEAST_PIVOT: f64 = 1e-11;
/// Islands whose eliminations are subtracted at once.
const ISLANDS_PER_BATCH: usize = 64;
/// Batches of islands whose complements are kept apart, so that they can run on any thread.
const MAX_PARTS: usize = 16;

pub(crate) struct Normal<'p> {
    problem: &'p Problem,
    values: Values,
    cost: f64,
    gradient: Vec<f64>,
    column_norms: Vec<f64>,
    /// Lower triangle over the shared columns.
    hessian: Mat<f64>,
    islands: Vec<IslandSums>,
    /// Made when the normal equations lost too many digits.
    orthogonal: Option<Orthogonal>,
}

/// Sums over the factors of one island.
struct IslandSums {
    /// Local by local, row-major.
    local: Vec<f64>,
    /// Local by touched shared columns, row-major.
    mixed: Vec<f64>,
    gradient: Vec<f64>,
}

/// Sums over the factors of one chunk.
struct Sums {
    cost: f64,
    hessian: Mat<f64>,
    gradient: Vec<f64>,
    islands: Vec<IslandSums>,
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
            hessian: sums.hessian,
            islands: sums.islands,
            orthogonal: None,
        };
        this.spread(&sums.gradient);
        check_finite(problem, values, [&this.gradient, &this.column_norms])?;
        this.clear_dust();
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

    /// The damped step, unless it would lose too many digits.
    fn reduced_step(&self, lambda: f64, scaling: &[f64], step: &mut [f64]) -> Option<()> {
        let structure = self.problem.structure();
        let damping: Vec<f64> = scaling.iter().map(|d| lambda * d * d).collect();
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
        let mut sum = 0.0;
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
        hessian
    }
}

impl Sums {
    fn new(shared: usize) -> Self {
        Sums { cost: 0.0, hessian: Mat::zeros(shared, shared), gradient: vec![0.0; shared], islands: Vec::new() }
    }

    fn add(&mut self, other: Sums) {
        self.cost += other.cost;
        self.hessian += &other.hessian;
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(sum, part)| *sum += part);
        self.islands.extend(other.islands);
    }
}

/// Compact rows of one shape and place that wait for their product, and the sum of the products so far.
struct Batch<'p> {
    columns: &'p [usize],
    waiting: usize,
    multiplied: bool,
    memory: Memory,
}

/// Room that one batch after another uses.
#[derive(Default)]
struct Memory {
    /// Rows one after another, each its columns and the residual; what lies beyond those that wait is old.
    rows: Vec<f64>,
    /// Lower triangle of the sum, column-major.
    product: Vec<f64>,
}

impl<'p> Batch<'p> {
    fn new(columns: &'p [usize], mut memory: Memory) -> Self {
        let width = columns.len() + 1;
        memory.rows.resize(BATCH * width, 0.0);
        memory.product.resize(width * width, 0.0);
        Batch { columns, waiting: 0, multiplied: false, memory }
    }

    fn width(&self) -> usize {
        self.columns.len() + 1
    }

    /// Room for one more row.
    fn next_row(&mut self) -> &mut [f64] {
        if self.waiting == BATCH {
            self.multiply();
        }
        let width = self.width();
        let start = self.waiting * width;
        self.waiting += 1;
        &mut self.memory.rows[start..start + width]
    }

    /// Adds the product of the waiting rows, the residual their last column.
    fn multiply(&mut self) {
        let width = self.width();
        let rows = MatRef::from_column_major_slice(&self.memory.rows[..self.waiting * width], width, self.waiting);
        let product = MatMut::from_column_major_slice_mut(&mut self.memory.product, width, width);
        let (lower, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        let accumulate = if self.multiplied { Accum::Add } else { Accum::Replace };
        matmul(product, lower, accumulate, rows, full, rows.transpose(), full, 1.0, Par::Seq);
        give_up_upper_halves();
        self.waiting = 0;
        self.multiplied = true;
    }

    /// Adds the sum of products to its places, and gives its room back.
    fn scatter(mut self, sums: &mut Sums) -> Memory {
        self.multiply();
        for (j, (column, product)) in
            self.columns.iter().zip(self.memory.product.chunks_exact(self.width())).enumerate()
        {
            let sum = sums.hessian.col_as_slice_mut(*column);
            self.columns[j..].iter().zip(&product[j..]).for_each(|(row, entry)| sum[*row] += entry);
            sums.gradient[*column] += product[self.columns.len()];
        }
        self.memory
    }
}

/// Sums one chunk of factors.
fn sum_chunk(problem: &Problem, values: &Values, chunk: &Chunk) -> Result<Sums, EvaluateError> {
    let structure = problem.structure();
    // The step before was found by faer, too.
    give_up_upper_halves();
    let mut rows = Rows::new(problem, values);
    let mut sums = Sums::new(structure.shared.len());
    let mut batches: Vec<Vec<Batch<'_>>> = structure.shapes.iter().map(|_| Vec::new()).collect();
    let islands = &structure.islands[chunk.islands.clone()];
    let free_end = islands.first().map_or(chunk.factors.end, |first| first.factors.start);
    let mut shape = None;
    let mut spare = Vec::new();
    for factor in &structure.order[chunk.factors.start..free_end] {
        sums.cost += rows.linearize(*factor, true)?;
        // One shape after another, so that few batches are alive and stay in cache.
        let before = shape.replace(structure.shape_of[*factor]);
        if let Some(before) = before.filter(|before| Some(*before) != shape) {
            spare.extend(batches[before].drain(..).map(|batch| batch.scatter(&mut sums)));
        }
        collect(problem, &rows, *factor, &mut batches, &mut spare);
    }
    let mut position = vec![0; structure.shared.len()];
    for island in islands {
        island.shared.iter().enumerate().for_each(|(at, index)| position[*index] = at);
        let mut own = IslandSums::new(island);
        for factor in &structure.order[island.factors.clone()] {
            sums.cost += rows.linearize(*factor, true)?;
            own.add(problem, &rows, *factor, &position);
            collect(problem, &rows, *factor, &mut batches, &mut spare);
        }
        sums.islands.push(own);
    }
    batches.into_iter().flatten().for_each(|batch| drop(batch.scatter(&mut sums)));
    Ok(sums)
}

/// Puts the rows of a factor into the batches of its shape.
fn collect<'p>(
    problem: &'p Problem,
    rows: &Rows<'_>,
    factor: usize,
    batches: &mut [Vec<Batch<'p>>],
    spare: &mut Vec<Memory>,
) {
    let plans = problem.plans(factor);
    let own = &mut batches[problem.structure().shape_of[factor]];
    if own.is_empty() {
        own.extend(plans.iter().map(|plan| Batch::new(&plan.columns, spare.pop().unwrap_or_default())));
    }
    plans.iter().zip(own).enumerate().for_each(|(row, (plan, batch))| rows.gather(plan, row, batch.next_row()));
}

impl IslandSums {
    fn new(island: &Island) -> Self {
        let (local, touched) = (island.columns.len(), island.shared.len());
        IslandSums { local: vec![0.0; local * local], mixed: vec![0.0; local * touched], gradient: vec![0.0; local] }
    }

    /// Adds the rows of one factor. `position`: place among the touched columns of each shared one.
    fn add(&mut self, problem: &Problem, rows: &Rows<'_>, factor: usize, position: &[usize]) {
        let local = self.gradient.len();
        let touched = self.mixed.len() / local;
        let mut own: Vec<(usize, f64)> = Vec::new();
        let mut compact = Vec::new();
        for (row, plan) in problem.plans(factor).iter().enumerate() {
            own.clear();
            rows.for_island(factor, row, |index, entry| own.push((index, entry)));
            compact.resize(plan.columns.len() + 1, 0.0);
            rows.gather(plan, row, &mut compact);
            for (i, a) in own.iter().filter(|(_, entry)| *entry != 0.0) {
                own.iter().for_each(|(j, b)| self.local[i * local + j] += a * b);
                let mixed = &mut self.mixed[i * touched..(i + 1) * touched];
                plan.columns.iter().zip(&compact).for_each(|(column, b)| mixed[position[*column]] += a * b);
                self.gradient[*i] += a * rows.residual(row);
            }
        }
    }

    fn clear(&mut self, island: &Island, column: usize, shared: &[usize]) {
        let (local, touched) = (island.columns.len(), island.shared.len());
        if let Some(own) = island.columns.iter().position(|c| *c == column) {
            (0..local).for_each(|j| {
                self.local[own * local + j] = 0.0;
                self.local[j * local + own] = 0.0;
            });
            self.mixed[own * touched..(own + 1) * touched].fill(0.0);
            self.gradient[own] = 0.0;
        }
        if let Some(at) = island.shared.iter().position(|index| shared[*index] == column) {
            (0..local).for_each(|i| self.mixed[i * touched + at] = 0.0);
        }
    }

    /// Cholesky factor of the damped local part.
    fn factor(&self, island: &Island, damping: &[f64]) -> Option<Llt<f64>> {
        let local = island.columns.len();
        let matrix = Mat::from_fn(local, local, |i, j| {
            self.local[i * local + j] + if i == j { damping[island.columns[i]] } else { 0.0 }
        });
        let diagonal: Vec<f64> = (0..local).map(|i| matrix[(i, i)]).collect();
        let factor = Llt::new(matrix.as_ref(), Side::Lower).ok()?;
        keeps_digits(&factor, &diagonal).then_some(factor)
    }

    /// `δ_e = −H_ee⁻¹ (g_e + H_es δ_s)`.
    fn substitute(&self, island: &Island, damping: &[f64], shared: &[f64]) -> Option<Vec<f64>> {
        let touched = island.shared.len();
        let mut right = Mat::from_fn(island.columns.len(), 1, |i, _| {
            let mixed = &self.mixed[i * touched..(i + 1) * touched];
            -self.gradient[i] - mixed.iter().zip(island.shared.iter()).map(|(m, index)| m * shared[*index]).sum::<f64>()
        });
        let factor = self.factor(island, damping)?;
        faer::linalg::solvers::SolveCore::solve_in_place_with_conj(&factor, faer::Conj::No, right.as_mut());
        Some((0..island.columns.len()).map(|i| right[(i, 0)]).collect())
    }

    /// The island's part of `vᵀ H v`.
    fn quadratic(&self, island: &Island, shared: &[f64], v: &[f64]) -> f64 {
        let (local, touched) = (island.columns.len(), island.shared.len());
        let row = |i: usize| {
            let own: f64 = (0..local).map(|j| self.local[i * local + j] * v[island.columns[j]]).sum();
            let mixed: f64 = (0..touched).map(|j| self.mixed[i * touched + j] * shared[island.shared[j]]).sum();
            v[island.columns[i]] * (own + 2.0 * mixed)
        };
        (0..local).map(row).sum()
    }
}

/// What some islands take away from the shared normal equations.
struct Complement {
    hessian: Mat<f64>,
    right: Vec<f64>,
    /// Touched columns of the waiting rows.
    touched: Arc<[usize]>,
    /// Rows `L⁻¹ [H_es g_e]` that wait for their product, column-major by (touched, gradient).
    rows: Vec<f64>,
}

impl Complement {
    fn new(shared: usize) -> Self {
        Complement {
            hessian: Mat::zeros(shared, shared),
            right: vec![0.0; shared],
            touched: [].into(),
            rows: Vec::new(),
        }
    }

    fn take(&mut self, island: &Island, sums: &IslandSums, damping: &[f64]) -> Option<()> {
        let (local, touched) = (island.columns.len(), island.shared.len());
        let full = self.rows.len() >= ISLANDS_PER_BATCH * local * (touched + 1);
        if full || !Arc::ptr_eq(&self.touched, &island.shared) {
            self.flush();
            self.touched = Arc::clone(&island.shared);
        }
        let mut block =
            Mat::from_fn(
                local,
                touched + 1,
                |i, j| {
                    if j < touched { sums.mixed[i * touched + j] } else { sums.gradient[i] }
                },
            );
        sums.factor(island, damping)?.L().solve_lower_triangular_in_place(block.as_mut());
        (0..local).for_each(|i| self.rows.extend((0..=touched).map(|j| block[(i, j)])));
        Some(())
    }

    /// Adds the product of the waiting rows.
    fn flush(&mut self) {
        let width = self.touched.len() + 1;
        if self.rows.is_empty() {
            return;
        }
        let rows = MatRef::from_column_major_slice(&self.rows, width, self.rows.len() / width);
        let mut product = Mat::zeros(width, width);
        let (lower, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        matmul(&mut product, lower, Accum::Replace, rows, full, rows.transpose(), full, 1.0, Par::Seq);
        for (j, column) in self.touched.iter().enumerate() {
            (j..width - 1).for_each(|i| self.hessian[(self.touched[i], *column)] += product[(i, j)]);
            self.right[*column] += product[(width - 1, j)];
        }
        self.rows.clear();
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
