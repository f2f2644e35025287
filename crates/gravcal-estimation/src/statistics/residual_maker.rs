//! The residual maker `M = I − U Uᵀ` of a solved problem: what a fit leaves of anything added to its readings.
//!
//! With `U` an orthonormal basis of what the whitened Jacobian J spans (of its determined directions), errors `e` of the readings leave
//! the residuals `r = M e`, to first order in the errors. A term `z a` that the model lacks changes them by `M z a`; so with `w = M z`
//!
//! ```text
//!     a = −(wᵀ r)/(wᵀ w),      wᵀ r = zᵀ r,      χ² falls by (wᵀ r)²/(wᵀ w)
//! ```
//!
//! if the term were estimated too (Rao's score test; Frisch and Waugh, 1933), without solving again. Eliminated blocks enter by what follows
//! the shared columns and what is their own, so that no matrix of all columns is made. **Assumptions.** No loss.

use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

use super::Solution;
use crate::EvaluateError;

/// Sums of a product.
const SUMS: usize = 8;
/// Rows of `U` that are fetched for all columns.
const FETCHED: usize = 256;
/// Fewer rows are not worth a thread.
const LEAST_ROWS: usize = 1024;

/// `M`, with the residuals that it is judged by.
#[derive(Clone, Debug)]
pub struct ResidualMaker {
    /// Orthonormal directions of the shared columns.
    rank: usize,
    /// Row of `U` over them, for each row of the problem; and [`SUMS`] zeros, so that as many may be read from any entry on.
    shared: Vec<f64>,
    /// Row of `U` over the own columns of components: place and entry. Nothing where the problem has no eliminated blocks.
    eliminated: Vec<Vec<(usize, f64)>>,
    /// How many such columns there are.
    own: usize,
    /// Terms that were added: unit vectors, perpendicular to each other and to `U`.
    added: Vec<Vec<f64>>,
    residuals: Vec<f64>,
}

impl ResidualMaker {
    /// That of a solution.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub fn new(solution: &Solution<'_>) -> Result<ResidualMaker, EvaluateError> {
        let basis = solution.analysis.basis_rows(solution.problem, solution.values)?;
        let mut maker = ResidualMaker {
            rank: basis.rank,
            shared: [basis.shared, vec![0.0; SUMS]].concat(),
            eliminated: basis.eliminated,
            own: basis.own,
            added: Vec::new(),
            residuals: basis.residuals,
        };
        // Where a solver stopped, or the reference pulled, a little is left along the Jacobian.
        let mut cleared = [maker.residuals.clone()];
        maker.apply(&mut cleared);
        [maker.residuals] = cleared;
        Ok(maker)
    }

    /// `r`, one entry a row of the problem, in standard deviations.
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Turns each column `z` into `M z`: together, as each asks for all of `U`, and more time is spent on fetching that than on what is done
    /// with it.
    pub fn apply(&self, columns: &mut [Vec<f64>]) {
        Arch::new().dispatch(Projection { maker: self, columns });
        for unit in &self.added {
            for z in columns.iter_mut() {
                let share = dot(unit, z);
                z.iter_mut().zip(unit).for_each(|(z, u)| *z -= share * u);
            }
        }
    }

    /// Entry of `M`.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        let shared = dot(self.shared_of(i), self.shared_of(j));
        let same = |(place, u): &(usize, f64)| {
            let other = self.eliminated_of(j).iter().filter(move |(other, _)| other == place);
            other.map(|(_, v)| u * v).sum::<f64>()
        };
        let eliminated: f64 = self.eliminated_of(i).iter().map(same).sum();
        let added: f64 = self.added.iter().map(|unit| unit[i] * unit[j]).sum();
        f64::from(i == j) - shared - eliminated - added
    }

    /// Those of its diagonal, row by row.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.residuals.len()).into_par_iter().with_min_len(LEAST_ROWS).map(|row| self.entry(row, row)).collect()
    }

    /// The same where terms are estimated too: unit vectors, perpendicular to each other, that `apply` left.
    #[must_use]
    pub fn with(mut self, terms: &[Vec<f64>]) -> ResidualMaker {
        for term in terms {
            let share = dot(term, &self.residuals);
            self.residuals.iter_mut().zip(term).for_each(|(r, u)| *r -= share * u);
        }
        self.added.extend_from_slice(terms);
        self
    }

    /// Orthonormal directions of the shared columns.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Whether `U` has columns of eliminated blocks.
    pub fn has_eliminated(&self) -> bool {
        self.own > 0
    }

    /// Whether these are all of `U`: no block is eliminated, and no term was added.
    pub fn is_shared_alone(&self) -> bool {
        self.own == 0 && self.added.is_empty()
    }

    /// Row of `U` over the shared columns.
    #[inline(always)]
    pub fn shared_of(&self, row: usize) -> &[f64] {
        &self.shared[row * self.rank..(row + 1) * self.rank]
    }

    /// The same and, behind it, what the terms that were added have in that row.
    pub fn basis_row(&self, row: usize) -> impl Iterator<Item = f64> {
        self.shared_of(row).iter().copied().chain(self.added.iter().map(move |unit| unit[row]))
    }

    #[inline(always)]
    fn eliminated_of(&self, row: usize) -> &[(usize, f64)] {
        self.eliminated.get(row).map_or(&[], Vec::as_slice)
    }
}

/// Takes off columns what is along `U`.
struct Projection<'a> {
    maker: &'a ResidualMaker,
    columns: &'a mut [Vec<f64>],
}

impl NullaryFnOnce for Projection<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Projection { maker, columns } = self;
        let mut along = vec![vec![[0.0; SUMS]; maker.rank.div_ceil(SUMS)]; columns.len()];
        let mut own = vec![vec![0.0; maker.own]; columns.len()];
        let rows = maker.residuals.len();
        for first in (0..rows).step_by(FETCHED) {
            let fetched = first..rows.min(first + FETCHED);
            for ((along, own), column) in along.iter_mut().zip(&mut own).zip(columns.iter()) {
                let nonzero = || fetched.clone().zip(&column[fetched.clone()]).filter(|(_, z)| **z != 0.0);
                for (block, along) in along.iter_mut().enumerate() {
                    let mut sums = *along;
                    for (row, z) in nonzero() {
                        let u = &maker.shared[row * maker.rank + SUMS * block..][..SUMS];
                        sums.iter_mut().zip(u).for_each(|(sum, u)| *sum += z * u);
                    }
                    *along = sums;
                }
                if maker.own > 0 {
                    nonzero().for_each(|(row, z)| {
                        maker.eliminated_of(row).iter().for_each(|(place, u)| own[*place] += z * u);
                    });
                }
            }
        }
        // Some rows at once, and of each the sums of `dot`.
        let mut tile = vec![[0.0; SUMS]; maker.rank];
        for first in (0..rows).step_by(SUMS) {
            let last = rows.min(first + SUMS);
            for row in first..last {
                tile.iter_mut().zip(maker.shared_of(row)).for_each(|(lanes, u)| lanes[row - first] = *u);
            }
            for ((along, own), column) in along.iter().zip(&own).zip(columns.iter_mut()) {
                let taken = dots(along.as_flattened(), &tile);
                for ((row, z), taken) in (first..last).zip(&mut column[first..last]).zip(taken) {
                    *z -= taken;
                    *z -= maker.eliminated_of(row).iter().map(|(place, u)| own[*place] * u).sum::<f64>();
                }
            }
        }
    }
}

/// [`dot`] of a vector and each lane of a tile.
#[inline(always)]
fn dots(a: &[f64], tile: &[[f64; SUMS]]) -> [f64; SUMS] {
    let (first, rest) = tile.as_chunks::<SUMS>();
    let mut sums = [[0.0; SUMS]; SUMS];
    for (a, tile) in a.as_chunks::<SUMS>().0.iter().zip(first) {
        for ((sum, a), lanes) in sums.iter_mut().zip(a).zip(tile) {
            sum.iter_mut().zip(lanes).for_each(|(sum, u)| *sum += a * u);
        }
    }
    let added = |mut sum: [f64; SUMS], lanes: [f64; SUMS]| {
        sum.iter_mut().zip(lanes).for_each(|(sum, own)| *sum += own);
        sum
    };
    let products = rest.iter().zip(&a[SUMS * first.len()..]).map(|(lanes, a)| lanes.map(|u| a * u));
    added(sums.into_iter().fold([0.0; SUMS], added), products.fold([0.0; SUMS], added))
}

/// In several sums, which a processor adds to at once.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((first, rest_a), (second, rest_b)) = (a.as_chunks::<SUMS>(), b.as_chunks::<SUMS>());
    let mut sums = [0.0; SUMS];
    for (a, b) in first.iter().zip(second) {
        sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linearization::tests::problem;
    use crate::testing::{Line, add, fit, line};
    use crate::{Block, RankAnalysis};

    const Y: [f64; 6] = [0.1, 1.3, 1.8, 3.4, 3.9, 5.6];

    fn maker(solution: &Solution<'_>) -> ResidualMaker {
        ResidualMaker::new(solution).unwrap()
    }

    /// By how much χ² falls, and the coefficient, are those of the fit with the column.
    #[test]
    fn an_added_column_is_that_of_the_larger_fit() {
        let square = |t: usize| (t * t) as f64;
        let without = fit(line(&Y));
        let maker = maker(&without.solution());
        let mut columns = [(0..Y.len()).map(square).collect()];
        maker.apply(&mut columns);
        let [w] = columns;
        let (along, length) = (dot(&w, maker.residuals()), dot(&w, &w));

        let mut builder = crate::ProblemBuilder::new();
        let ids = ["a", "b", "c"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        for (t, y) in Y.iter().enumerate() {
            add(&mut builder, Line::new(&ids, &[1.0, t as f64, square(t)], *y));
        }
        let with = fit(builder);
        let chi = |solution: &Solution<'_>| {
            solution.problem.residuals(solution.values).unwrap().iter().map(|r| r * r).sum::<f64>()
        };
        let fallen = chi(&without.solution()) - chi(&with.solution());
        assert!((along * along / length / fallen - 1.0).abs() < 1e-9);
        assert!((-along / length - with.values.as_slice()[2]).abs() < 1e-9);

        let unit: Vec<f64> = w.iter().map(|w| w / length.sqrt()).collect();
        let larger = maker.clone().with(&[unit]);
        let expected = with.solution().problem.residuals(with.solution().values).unwrap();
        assert!(larger.residuals().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9));
        let trace: f64 = (0..Y.len()).map(|i| larger.entry(i, i)).sum();
        assert!((trace - 3.0).abs() < 1e-9, "{trace}");
    }

    #[test]
    fn eliminated_blocks_are_as_good_as_kept() {
        let ((plain, values), (eliminated, _)) = (problem(40, false), problem(40, true));
        let spectra = [RankAnalysis::new(&plain, &values).unwrap(), RankAnalysis::new(&eliminated, &values).unwrap()];
        let [a, b] = [(&plain, &spectra[0]), (&eliminated, &spectra[1])]
            .map(|(problem, analysis)| maker(&Solution { problem, values: &values, analysis }));
        let mut z = [(0..plain.rows()).map(|i| ((i * i * 31 + 7 * i) % 97) as f64 - 48.0).collect::<Vec<f64>>()];
        let mut other = z.clone();
        a.apply(&mut z);
        b.apply(&mut other);
        assert!(z[0].iter().zip(&other[0]).all(|(a, b)| (a - b).abs() < 1e-6), "{z:?} {other:?}");
        let entries = (0..plain.rows()).map(|i| (i, (7 * i + 3) % plain.rows()));
        assert!(entries.into_iter().all(|(i, j)| (a.entry(i, j) - b.entry(i, j)).abs() < 1e-9));
    }
}
