//! Small symmetric matrices, some at once: each number has one lane a matrix.

use super::pivots::LEAST_PIVOT;
use crate::LANES;

pub(super) type Lanes = [f64; LANES];

#[inline(always)]
pub(super) fn lanes(of: impl FnMut(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

/// `sum += a b`.
#[inline(always)]
pub(super) fn add_product(sum: &mut Lanes, a: &Lanes, b: &Lanes) {
    (0..LANES).for_each(|lane| sum[lane] += a[lane] * b[lane]);
}

/// `rest −= a b`.
#[inline(always)]
pub(super) fn take_product(rest: &mut Lanes, a: &Lanes, b: &Lanes) {
    (0..LANES).for_each(|lane| rest[lane] -= a[lane] * b[lane]);
}

/// `L D Lᵀ` of square matrices, of which the lower triangle counts.
pub(super) struct Factored {
    size: usize,
    /// Row-major: `L` below the diagonal, `D` on it.
    entries: Vec<Lanes>,
    /// `1/D`.
    inverse: Vec<Lanes>,
}

impl Factored {
    pub fn new(size: usize) -> Self {
        Factored { size, entries: vec![[0.0; LANES]; size * size], inverse: vec![[0.0; LANES]; size] }
    }

    /// Room for the matrices, row-major.
    pub fn matrix(&mut self) -> &mut [Lanes] {
        &mut self.entries
    }

    /// Factors the matrices. `false` where a pivot is too small beside the diagonal that it came from.
    #[inline(always)]
    pub fn factor(&mut self) -> bool {
        let (size, entries) = (self.size, &mut self.entries);
        let mut sound = true;
        for j in 0..size {
            self.inverse[j] = entries[j * size + j];
        }
        for j in 0..size {
            let (pivot, diagonal) = (entries[j * size + j], self.inverse[j]);
            sound &= (0..LANES).all(|lane| pivot[lane].is_finite() && pivot[lane] > LEAST_PIVOT * diagonal[lane]);
            let inverse = pivot.map(f64::recip);
            self.inverse[j] = inverse;
            // From below, as those above are needed as they stand.
            for i in (j + 1..size).rev() {
                let entry = entries[i * size + j];
                if entry == [0.0; LANES] {
                    continue;
                }
                let factor = lanes(|lane| entry[lane] * inverse[lane]);
                for k in j + 1..i {
                    let other = entries[k * size + j];
                    take_product(&mut entries[i * size + k], &factor, &other);
                }
                take_product(&mut entries[i * size + i], &factor, &entry);
                entries[i * size + j] = factor;
            }
        }
        sound
    }

    pub fn inverse_pivot(&self, row: usize) -> &Lanes {
        &self.inverse[row]
    }

    /// `L`, below its diagonal of ones.
    #[inline(always)]
    pub fn below(&self, row: usize, column: usize) -> &Lanes {
        &self.entries[row * self.size + column]
    }

    /// `v ← L⁻¹ v`.
    #[inline(always)]
    pub fn forward(&self, v: &mut [Lanes]) {
        for i in 1..self.size {
            for j in 0..i {
                let known = v[j];
                take_product(&mut v[i], self.below(i, j), &known);
            }
        }
    }

    /// `v ← (L D Lᵀ)⁻¹ v`.
    #[inline(always)]
    pub fn solve(&self, v: &mut [Lanes]) {
        self.forward(v);
        for i in (0..self.size).rev() {
            v[i] = lanes(|lane| v[i][lane] * self.inverse[i][lane]);
            for j in i + 1..self.size {
                let known = v[j];
                take_product(&mut v[i], self.below(j, i), &known);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `A` of four components: `B Bᵀ + I`.
    fn matrix(i: usize, j: usize, lane: usize) -> f64 {
        let b = |i: usize, k: usize| (1.0 + (3 * i + k) as f64 + 0.7 * lane as f64).sin();
        (0..3).map(|k| b(i, k) * b(j, k)).sum::<f64>() + f64::from(i == j)
    }

    #[test]
    fn solves_each_lane() {
        let mut factored = Factored::new(4);
        for i in 0..4 {
            (0..4).for_each(|j| factored.matrix()[4 * i + j] = lanes(|lane| matrix(i, j, lane)));
        }
        assert!(factored.factor());
        let mut solution: Vec<Lanes> = (0..4).map(|i| [f64::from(i); LANES]).collect();
        factored.solve(&mut solution);
        for (lane, i) in (0..LANES).flat_map(|lane| (0..4).map(move |i| (lane, i))) {
            let product: f64 = solution.iter().enumerate().map(|(j, v)| matrix(i, j, lane) * v[lane]).sum();
            assert!((product - i as f64).abs() < 1e-12, "{lane} {i} {product}");
        }
    }

    #[test]
    fn a_matrix_that_loses_digits_is_reported() {
        for (corner, sound) in [(1.0 + 1e-9, true), (1.0 + 1e-13, false), (f64::NAN, false)] {
            let mut factored = Factored::new(2);
            factored.matrix().fill([1.0; LANES]);
            factored.matrix()[0] = [2.0; LANES];
            factored.matrix()[3] = [2.0; LANES];
            factored.matrix()[0][1] = 1.0;
            factored.matrix()[3][1] = corner;
            assert_eq!(factored.factor(), sound, "{corner}");
        }
    }
}
