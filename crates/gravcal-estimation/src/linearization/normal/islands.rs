//! Islands of local columns: their sums, and what they take away from the shared normal equations.

use std::sync::Arc;

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::Llt;
use faer::{Accum, Mat, MatRef, Par, Side};

use super::pivots::keeps_digits;
use crate::Problem;
use crate::problem::{Island, Rows};

/// Islands whose eliminations are subtracted at once.
pub(super) const ISLANDS_PER_BATCH: usize = 64;

/// Sums over the factors of one island.
pub(super) struct IslandSums {
    /// Local by local, row-major.
    pub local: Vec<f64>,
    /// Local by touched shared columns, row-major.
    pub mixed: Vec<f64>,
    pub gradient: Vec<f64>,
}

impl IslandSums {
    pub fn new(island: &Island) -> Self {
        let (local, touched) = (island.columns.len(), island.shared.len());
        IslandSums { local: vec![0.0; local * local], mixed: vec![0.0; local * touched], gradient: vec![0.0; local] }
    }

    /// Adds the rows of one factor. `position`: place among the touched columns of each shared one.
    pub fn add(&mut self, problem: &Problem, rows: &Rows<'_>, factor: usize, position: &[usize]) {
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

    pub fn clear(&mut self, island: &Island, column: usize, shared: &[usize]) {
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
    pub fn substitute(&self, island: &Island, damping: &[f64], shared: &[f64]) -> Option<Vec<f64>> {
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
    pub fn quadratic(&self, island: &Island, shared: &[f64], v: &[f64]) -> f64 {
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
pub(super) struct Complement {
    pub hessian: Mat<f64>,
    pub right: Vec<f64>,
    /// Touched columns of the waiting rows.
    touched: Arc<[usize]>,
    /// Rows `L⁻¹ [H_es g_e]` that wait for their product, column-major by (touched, gradient).
    rows: Vec<f64>,
}

impl Complement {
    pub fn new(shared: usize) -> Self {
        Complement {
            hessian: Mat::zeros(shared, shared),
            right: vec![0.0; shared],
            touched: [].into(),
            rows: Vec::new(),
        }
    }

    pub fn take(&mut self, island: &Island, sums: &IslandSums, damping: &[f64]) -> Option<()> {
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
    pub fn flush(&mut self) {
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
