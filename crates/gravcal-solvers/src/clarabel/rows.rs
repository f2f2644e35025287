//! Constraints as rows of a conic programme.
//!
//! At values x every constraint demands of a step δ of the columns that
//!
//! ```text
//!     s(δ) = s₀ + G δ ∈ K
//! ```
//!
//! | constraint | s | K |
//! |---|---|---|
//! | f = value | f − value | {0} |
//! | f ≥ lower | f − lower | ℝ₊ |
//! | f ≤ upper | upper − f | ℝ₊ |
//! | ‖u‖ ≤ t | (t, u) | second-order cone |
//! | ‖block‖ = length | (‖x‖² − length²) / (2 length), to first order | {0} |
//!
//! All but the last are exact: `f`, `t` and `u` are affine, and the blocks they read are stored as they step
//! ([`Clarabel`](super::Clarabel) refuses others).

use gravcal_estimation::{Affine, ConstraintKind, Problem, Values};

/// A value beyond its cone by no more than this share of the numbers it is made of is there by rounding.
const ROUNDING: f64 = 1e-13;

/// Where `s` must lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cone {
    /// At zero.
    Equation,
    /// Not below zero; one row.
    Nonnegative,
    /// The first component at least the length of the others.
    SecondOrder,
}

/// The rows of one constraint, or of one of its two sides.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Which of the problem's constraints.
    pub constraint: usize,
    /// Position among the rows of the problem, the same wherever they are taken.
    pub place: usize,
    pub cone: Cone,
    /// G, by row: column and coefficient.
    pub coefficients: Vec<Vec<(usize, f64)>>,
    /// s₀.
    pub slack: Vec<f64>,
    /// By what the rows have been multiplied.
    pub scale: f64,
}

/// The rows of all constraints that read a free block.
pub(super) fn rows(problem: &Problem, values: &Values) -> Vec<Rows> {
    let all = problem.constraints().iter().enumerate().flat_map(|(index, constraint)| {
        let of =
            |cone, coefficients, slack| Rows { constraint: index, place: 0, cone, coefficients, slack, scale: 1.0 };
        match &constraint.kind {
            ConstraintKind::Range { function, lower, upper } => {
                let (row, value) = (row(problem, function), function.at(values));
                if lower == upper {
                    return vec![of(Cone::Equation, vec![row], vec![value - lower])];
                }
                let below = lower.is_finite().then(|| of(Cone::Nonnegative, vec![row.clone()], vec![value - lower]));
                let negative = row.iter().map(|(column, c)| (*column, -c)).collect();
                let above = upper.is_finite().then(|| of(Cone::Nonnegative, vec![negative], vec![upper - value]));
                below.into_iter().chain(above).collect()
            }
            ConstraintKind::Cone { norm_of, at_most } => {
                let functions = || std::iter::once(at_most).chain(norm_of);
                let coefficients = functions().map(|f| row(problem, f)).collect();
                vec![of(Cone::SecondOrder, coefficients, functions().map(|f| f.at(values)).collect())]
            }
            ConstraintKind::Length { block, length } => {
                let x = values.get(*block);
                let row = problem.columns_of(*block).zip(x).map(|(column, x)| (column, x / length)).collect();
                let square: f64 = x.iter().map(|x| x * x).sum();
                vec![of(Cone::Equation, vec![row], vec![(square - length * length) / (2.0 * length)])]
            }
        }
    });
    let free = all.filter(|rows| rows.coefficients.iter().any(|row| !row.is_empty()));
    free.enumerate().map(|(place, rows)| Rows { place, ..rows }).collect()
}

/// The coefficients of a function by column, each column once.
fn row(problem: &Problem, function: &Affine) -> Vec<(usize, f64)> {
    let mut terms: Vec<(usize, f64)> = function
        .terms
        .iter()
        .filter_map(|(block, component, c)| Some((problem.columns_of(*block).nth(*component)?, *c)))
        .collect();
    terms.sort_by_key(|(column, _)| *column);
    terms.dedup_by(|later, first| {
        let same = later.0 == first.0;
        if same {
            first.1 += later.1;
        }
        same
    });
    terms
}

impl Rows {
    /// The same with limits that are where the values are, if the values are beyond them by a rounding error: then no
    /// step has to give up cost in order to mend it.
    pub fn relaxed(mut self) -> Rows {
        match self.cone {
            Cone::Equation => self.slack[0] = 0.0,
            Cone::Nonnegative => self.slack[0] = self.slack[0].max(0.0),
            Cone::SecondOrder => self.slack[0] = self.slack[0].max(norm(&self.slack[1..])),
        }
        self
    }

    /// The same for steps counted in `units` of each column, brought to length one (all rows together).
    pub fn in_units(&self, units: &[f64]) -> Rows {
        let mut rows = self.clone();
        rows.coefficients.iter_mut().flatten().for_each(|(column, c)| *c *= units[*column]);
        let length = norm(&rows.coefficients.iter().flatten().map(|(_, c)| *c).collect::<Vec<f64>>());
        let scale = if length > 0.0 { 1.0 / length } else { 1.0 };
        rows.coefficients.iter_mut().flatten().for_each(|(_, c)| *c *= scale);
        rows.slack.iter_mut().for_each(|s| *s *= scale);
        Rows { scale: rows.scale * scale, ..rows }
    }

    /// s(δ).
    pub fn at(&self, step: &[f64]) -> Vec<f64> {
        let value = |(row, s): (&Vec<(usize, f64)>, &f64)| s + row.iter().map(|(j, c)| c * step[*j]).sum::<f64>();
        self.coefficients.iter().zip(&self.slack).map(value).collect()
    }

    /// Whether a step ends where the rows want it, up to rounding.
    pub fn obeyed_by(&self, step: &[f64]) -> bool {
        let moved: f64 = self.coefficients.iter().flatten().map(|(j, c)| (c * step[*j]).abs()).sum();
        let size = moved + self.slack.iter().map(|s| s.abs()).sum::<f64>();
        self.excess(&self.at(step)) <= ROUNDING * size
    }

    /// By how much `s` is outside of its cone; zero or less inside.
    pub fn excess(&self, s: &[f64]) -> f64 {
        match self.cone {
            Cone::Equation => s[0].abs(),
            Cone::Nonnegative => -s[0],
            Cone::SecondOrder => norm(&s[1..]) - s[0],
        }
    }

    /// Adds `factor Gᵀ z` to `sum`.
    pub fn add_transposed(&self, factor: f64, z: &[f64], sum: &mut [f64]) {
        for (row, z) in self.coefficients.iter().zip(z) {
            row.iter().for_each(|(j, c)| sum[*j] += factor * c * z);
        }
    }
}

pub(super) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
