//! Components of eliminated columns: their sums, and what they take away from the shared normal equations.

use std::sync::Arc;

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::Llt;
use faer::{Accum, Mat, MatRef, Par, Side};

use super::pivots::keeps_digits;
use crate::Problem;
use crate::problem::{Component, Rows};

/// Components whose eliminations are subtracted at once.
pub(super) const COMPONENTS_PER_BATCH: usize = 64;

/// Sums over the factors of one component.
pub(super) struct ComponentSums {
    /// Eliminated by local, row-major.
    pub eliminated: Vec<f64>,
    /// Eliminated by touched shared columns, row-major.
    pub mixed: Vec<f64>,
    pub gradient: Vec<f64>,
}

impl ComponentSums {
    pub fn new(component: &Component) -> Self {
        let (eliminated, touched) = (component.columns.len(), component.shared.len());
        ComponentSums {
            eliminated: vec![0.0; eliminated * eliminated],
            mixed: vec![0.0; eliminated * touched],
            gradient: vec![0.0; eliminated],
        }
    }

    /// Adds the rows of one factor. `position`: place among the touched columns of each shared one.
    pub fn add(&mut self, problem: &Problem, rows: &Rows<'_>, factor: usize, position: &[usize]) {
        let eliminated = self.gradient.len();
        let touched = self.mixed.len() / eliminated;
        let mut own: Vec<(usize, f64)> = Vec::new();
        let mut compact = Vec::new();
        for (row, plan) in problem.plans(factor).iter().enumerate() {
            own.clear();
            rows.for_component(factor, row, |index, entry| own.push((index, entry)));
            compact.resize(plan.columns.len() + 1, 0.0);
            rows.gather(plan, row, &mut compact);
            for (i, a) in own.iter().filter(|(_, entry)| *entry != 0.0) {
                own.iter().for_each(|(j, b)| self.eliminated[i * eliminated + j] += a * b);
                let mixed = &mut self.mixed[i * touched..(i + 1) * touched];
                plan.columns.iter().zip(&compact).for_each(|(column, b)| mixed[position[*column]] += a * b);
                self.gradient[*i] += a * rows.residual(row);
            }
        }
    }

    pub fn clear(&mut self, component: &Component, column: usize, shared: &[usize]) {
        let (eliminated, touched) = (component.columns.len(), component.shared.len());
        if let Some(own) = component.columns.iter().position(|c| *c == column) {
            (0..eliminated).for_each(|j| {
                self.eliminated[own * eliminated + j] = 0.0;
                self.eliminated[j * eliminated + own] = 0.0;
            });
            self.mixed[own * touched..(own + 1) * touched].fill(0.0);
            self.gradient[own] = 0.0;
        }
        if let Some(at) = component.shared.iter().position(|index| shared[*index] == column) {
            (0..eliminated).for_each(|i| self.mixed[i * touched + at] = 0.0);
        }
    }

    /// Cholesky factor of the damped eliminated part.
    fn factor(&self, component: &Component, damping: &[f64]) -> Option<Llt<f64>> {
        let eliminated = component.columns.len();
        let matrix = Mat::from_fn(eliminated, eliminated, |i, j| {
            self.eliminated[i * eliminated + j] + if i == j { damping[component.columns[i]] } else { 0.0 }
        });
        let diagonal: Vec<f64> = (0..eliminated).map(|i| matrix[(i, i)]).collect();
        let factor = Llt::new(matrix.as_ref(), Side::Lower).ok()?;
        keeps_digits(&factor, &diagonal).then_some(factor)
    }

    /// `δ_e = −H_ee⁻¹ (g_e + H_es δ_s)`.
    pub fn substitute(&self, component: &Component, damping: &[f64], shared: &[f64]) -> Option<Vec<f64>> {
        let touched = component.shared.len();
        let mut right = Mat::from_fn(component.columns.len(), 1, |i, _| {
            let mixed = &self.mixed[i * touched..(i + 1) * touched];
            -self.gradient[i]
                - mixed.iter().zip(component.shared.iter()).map(|(m, index)| m * shared[*index]).sum::<f64>()
        });
        let factor = self.factor(component, damping)?;
        faer::linalg::solvers::SolveCore::solve_in_place_with_conj(&factor, faer::Conj::No, right.as_mut());
        Some((0..component.columns.len()).map(|i| right[(i, 0)]).collect())
    }

    /// The component's part of `vᵀ H v`.
    pub fn quadratic(&self, component: &Component, shared: &[f64], v: &[f64]) -> f64 {
        let (eliminated, touched) = (component.columns.len(), component.shared.len());
        let row = |i: usize| {
            let own: f64 = (0..eliminated).map(|j| self.eliminated[i * eliminated + j] * v[component.columns[j]]).sum();
            let mixed: f64 = (0..touched).map(|j| self.mixed[i * touched + j] * shared[component.shared[j]]).sum();
            v[component.columns[i]] * (own + 2.0 * mixed)
        };
        (0..eliminated).map(row).sum()
    }
}

/// What some components take away from the shared normal equations.
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

    pub fn take(&mut self, component: &Component, sums: &ComponentSums, damping: &[f64]) -> Option<()> {
        let (eliminated, touched) = (component.columns.len(), component.shared.len());
        let full = self.rows.len() >= COMPONENTS_PER_BATCH * eliminated * (touched + 1);
        if full || !Arc::ptr_eq(&self.touched, &component.shared) {
            self.flush();
            self.touched = Arc::clone(&component.shared);
        }
        let mut block = Mat::from_fn(eliminated, touched + 1, |i, j| {
            if j < touched { sums.mixed[i * touched + j] } else { sums.gradient[i] }
        });
        sums.factor(component, damping)?.L().solve_lower_triangular_in_place(block.as_mut());
        (0..eliminated).for_each(|i| self.rows.extend((0..=touched).map(|j| block[(i, j)])));
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
