//! The least of a quadratic cost where differences of positions have known lengths.
//!
//! ```text
//!     min ½ xᵀ H x + gᵀ x     with     ‖δ₀ + C x‖ = d
//! ```
//!
//! `C x` is how the difference of two positions changes. With `P = H⁻¹`, `x* = − P g`, `c = δ₀ + C x*` and `M = C P Cᵀ = V D Vᵀ`, the
//! difference costs `½ (δ − c)ᵀ M⁻¹ (δ − c)` more than `x*` does, which is least on the sphere where (Moré and Sorensen, *SIAM J. Scientific
//! and Statistical Computing* 4, 1983)
//!
//! ```text
//!     δ = V (1 + μ D)⁻¹ Vᵀ c,     ‖δ‖ = d,     μ > − 1/max D,          x = x* − μ P Cᵀ δ
//! ```
//!
//! Several lengths are kept one after the other: each leaves of `P` what does not change its own difference.

use faer::linalg::solvers::{Llt, SolveCore};
use faer::{Conj, Mat, MatMut, Side};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};

/// Damping that leaves combinations without information where they are, and little else, column-relative.
pub(in crate::joint) const FAINT_DAMPING: f64 = 1e-9;
/// Square of the smallest relative pivot with which a step keeps enough digits for a cost to be compared.
const LEAST_PIVOT: f64 = 1e-11;

/// What of `M` is less than this share of its largest part stays where it is.
const RIGID: f64 = 1e-12;
/// Share of the length by which a difference of none in the freest direction is taken to differ: to which side is a matter of choice.
const NUDGE: f64 = 1e-9;
/// Bisections; each bracket is half of the one before.
const BISECTIONS: usize = 200;

/// A quadratic cost that was minimised.
pub(in crate::joint) struct Quadratic {
    /// The unit of each column, its norm's inverse; zero where a column is.
    scale: DVector<f64>,
    /// Of `H` in these units.
    factor: Llt<f64>,
    /// What lengths that are kept take of `P`.
    kept: Vec<Kept>,
    /// `x`, where it is least.
    pub step: DVector<f64>,
    /// By how much it is less there than at zero.
    pub reduction: f64,
}

/// `P Cᵀ` and `M⁻¹` of a length that is kept.
struct Kept {
    moved: DMatrix<f64>,
    stiffness: Matrix3<f64>,
}

/// A difference of positions whose length is known.
pub(in crate::joint) struct KnownLength {
    /// `δ₀`, m.
    pub difference: Vector3<f64>,
    /// `C`.
    pub by_step: Matrix3xX<f64>,
    /// `d`, m.
    pub length: f64,
}

impl Quadratic {
    /// Minimises it with damping, relative to its columns; nothing where `H` is then not positive definite to the last digit. `hessian`: its
    /// lower triangle, by row and column.
    pub fn minimised(gradient: &[f64], hessian: impl Fn(usize, usize) -> f64, damping: f64) -> Option<Quadratic> {
        let columns = gradient.len();
        let unit = |square: f64| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 };
        let scale = DVector::from_fn(columns, |i, _| unit(hessian(i, i)));
        let damped = Mat::from_fn(columns, columns, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 1.0 + damping,
            std::cmp::Ordering::Greater => hessian(i, j) * scale[i] * scale[j],
        });
        let factor = Llt::new(damped.as_ref(), Side::Lower).ok()?;
        let gradient = DVector::from_column_slice(gradient);
        let none = Quadratic { scale, factor, kept: Vec::new(), step: DVector::zeros(columns), reduction: 0.0 };
        let step = -none.moved_by(DMatrix::from_column_slice(columns, 1, gradient.as_slice())).column(0);
        let size: f64 = step.iter().zip(&none.scale).filter(|(_, s)| **s > 0.0).map(|(x, s)| (x / s).powi(2)).sum();
        // −gᵀx − ½ xᵀHx with (H + λ) x = −g.
        let reduction = -0.5 * gradient.dot(&step) + 0.5 * damping * size;
        Some(Quadratic { step, reduction, ..none })
    }

    /// Whether no column is so much like others that its cost could not be compared.
    pub fn keeps_digits(&self) -> bool {
        let pivots = self.factor.L();
        (0..pivots.nrows()).all(|i| pivots[(i, i)].powi(2) > LEAST_PIVOT)
    }

    /// The same where one more length is kept; as it is where nothing can change that.
    #[must_use]
    pub fn keeping(mut self, known: &KnownLength) -> Quadratic {
        let columns = self.scale.len();
        let moved = self.moved_by(DMatrix::from_fn(columns, 3, |i, axis| known.by_step[(axis, i)]));
        let spread: Matrix3<f64> = (&known.by_step * &moved).fixed_view::<3, 3>(0, 0).into_owned();
        let center = known.difference + &known.by_step * &self.step;
        let Some(Nearest { difference, multiplier, growth }) = nearest(spread, center, known.length) else {
            return self;
        };
        self.step -= &moved * (multiplier * difference);
        self.reduction -= growth;
        if let Ok(stiffness) = spread.pseudo_inverse(RIGID * spread.norm()) {
            self.kept.push(Kept { moved, stiffness });
        }
        self
    }

    /// `P` times these columns.
    fn moved_by(&self, columns: DMatrix<f64>) -> DMatrix<f64> {
        let by_scale = |mut columns: DMatrix<f64>| {
            columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.scale));
            columns
        };
        let (rows, count) = columns.shape();
        let mut moved = by_scale(columns.clone());
        let in_place = MatMut::from_column_major_slice_mut(moved.as_mut_slice(), rows, count);
        self.factor.solve_in_place_with_conj(Conj::No, in_place);
        let mut moved = by_scale(moved);
        for Kept { moved: kept, stiffness } in &self.kept {
            moved -= kept * (stiffness * (kept.transpose() * &columns));
        }
        moved
    }
}

/// Where the cost of a difference is least on a sphere.
struct Nearest {
    /// `δ`.
    difference: Vector3<f64>,
    /// `μ`.
    multiplier: f64,
    /// What it costs more than `c`.
    growth: f64,
}

/// Nothing where no difference of that length can be reached. `spread`: `M`; `center`: `c`.
fn nearest(spread: Matrix3<f64>, center: Vector3<f64>, length: f64) -> Option<Nearest> {
    let eigen = spread.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let freest = eigen.eigenvalues.imax();
    let share = eigen.eigenvalues.map(|d| if d > RIGID * largest { d / largest } else { 0.0 });
    let mut along = eigen.eigenvectors.transpose() * center;
    if !(largest > 0.0 && length > 0.0 && along.iter().all(|c| c.is_finite())) {
        return None;
    }
    if along[freest].abs() < NUDGE * length {
        along[freest] = NUDGE * length;
    }
    // With t = 1 + μ max D, from 0 on; the length falls with t.
    let difference = |t: f64| along.zip_map(&share, |c, d| c / (1.0 + (t - 1.0) * d));
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    while difference(high).norm() > length {
        (low, high) = (high, 2.0 * high);
        if !high.is_finite() {
            return None;
        }
    }
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if difference(middle).norm() > length { low = middle } else { high = middle }
    }
    let (t, difference) = (high, difference(high));
    let multiplier = (t - 1.0) / largest;
    let growth = 0.5 * (multiplier * difference).dot(&(difference.component_mul(&share) * (t - 1.0)));
    Some(Nearest { difference: eigen.eigenvectors * difference, multiplier, growth })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some positive definite matrix, gradient and difference of the first three from the next three unknowns.
    fn problem(seed: usize) -> (DMatrix<f64>, DVector<f64>, KnownLength) {
        let number = |i: usize| (43_758.545 * (12.9898 * (i + 400 * seed + 1) as f64).sin()).fract();
        let root = DMatrix::from_fn(9, 7, |i, j| number(9 * i + j));
        let hessian = root.transpose() * &root;
        let gradient = DVector::from_fn(7, |i, _| number(100 + i));
        let by_step = Matrix3xX::from_fn(7, |i, j| f64::from(u8::from(j == i)) - f64::from(u8::from(j == i + 3)));
        let difference = Vector3::from_fn(|i, _| number(200 + i));
        (hessian, gradient, KnownLength { difference, by_step, length: 0.7 })
    }

    fn minimised(hessian: &DMatrix<f64>, gradient: &DVector<f64>) -> Quadratic {
        Quadratic::minimised(gradient.as_slice(), |i, j| hessian[(i, j)], 0.0).unwrap()
    }

    #[test]
    fn a_column_of_zeros_and_columns_that_are_one_leave_the_cost_finite() {
        let reduction = |gradient: [f64; 2], hessian: [f64; 4]| {
            Quadratic::minimised(&gradient, |i, j| hessian[2 * i + j], FAINT_DAMPING).unwrap().reduction
        };
        assert!((reduction([2.0, 0.0], [4.0, 0.0, 0.0, 0.0]) - 0.5).abs() < 1e-8);
        assert!((reduction([2.0, 2.0], [4.0, 4.0, 4.0, 4.0]) - 0.5).abs() < 1e-8);
    }

    #[test]
    fn the_step_keeps_the_length_and_no_other_that_does_costs_less() {
        for seed in 0..20 {
            let (hessian, gradient, known) = problem(seed);
            let cost = |x: &DVector<f64>| 0.5 * x.dot(&(&hessian * x)) + gradient.dot(x);
            let found = minimised(&hessian, &gradient).keeping(&known);
            let length = |x: &DVector<f64>| (known.difference + &known.by_step * x).norm();
            assert!((length(&found.step) - 0.7).abs() < 1e-9, "{}", length(&found.step));
            assert!((cost(&found.step) + found.reduction).abs() < 1e-8 * (1.0 + found.reduction.abs()));
            // Others of that length, in all directions, with the rest at its best.
            let inverse = hessian.clone().try_inverse().unwrap();
            let free = -(&inverse * &gradient);
            let spread = (&known.by_step * &inverse * known.by_step.transpose()).try_inverse().unwrap();
            for k in 0..500 {
                let (z, turn) = (1.0 - (2 * k + 1) as f64 / 500.0, 2.4 * k as f64);
                let across = (1.0 - z * z).sqrt();
                let other = 0.7 * Vector3::new(across * turn.cos(), across * turn.sin(), z);
                let off = other - known.difference - &known.by_step * &free;
                let x = &free + &inverse * known.by_step.transpose() * (spread * off);
                assert!((length(&x) - 0.7).abs() < 1e-9 && cost(&x) >= cost(&found.step) - 1e-9);
            }
        }
    }

    #[test]
    fn a_second_length_leaves_the_first() {
        let (hessian, gradient, first) = problem(3);
        let by_step = Matrix3xX::from_fn(7, |i, j| f64::from(u8::from(j == i + 3)));
        let second = KnownLength { difference: Vector3::new(0.1, 0.2, 0.3), by_step, length: 1.5 };
        let found = minimised(&hessian, &gradient).keeping(&first).keeping(&second);
        let length = |known: &KnownLength| (known.difference + &known.by_step * &found.step).norm();
        assert!((length(&first) - 0.7).abs() < 1e-9 && (length(&second) - 1.5).abs() < 1e-9);
    }

    #[test]
    fn no_difference_at_all_becomes_one_of_that_length() {
        let spread = Matrix3::from_diagonal(&Vector3::new(1.0, 4.0, 0.0));
        let found = nearest(spread, Vector3::new(0.0, 0.0, 0.3), 0.5).unwrap();
        // What is rigid stays; the freest direction takes the rest.
        assert!((found.difference - Vector3::new(0.0, 0.4, 0.3)).norm() < 1e-6, "{}", found.difference);
        assert!((found.growth - 0.5 * 0.16 / 4.0).abs() < 1e-6);
        assert!(nearest(Matrix3::zeros(), Vector3::x(), 0.5).is_none());
    }
}
