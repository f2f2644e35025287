//! One conic programme and its solution by Clarabel (Goulart and Chen, *Clarabel: an interior-point solver for conic
//! programs with quadratic objectives*, 2024).
//!
//! ```text
//!     minimise over w   ½ wᵀ K w + qᵀ w     such that   s = s₀ + G w ∈ K
//!     with duals z:     K w + q − Gᵀ z = 0,   z ∈ K*,   zᵀ s = 0
//! ```
//!
//! Everything is a pure number of the order of one: steps count in units of each column, rows have length one.

use ::clarabel::algebra::CscMatrix;
use ::clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus, SupportedConeT,
    ZeroConeT,
};
use faer::Mat;

use super::refine::refine;
use super::rows::{Cone, Rows};

/// The method's name, which is that of the library that solves its programmes.
pub(crate) const NAME: &str = "clarabel";

/// Tolerance asked of Clarabel.
const TOLERANCE: f64 = 1e-10;
/// Clarabel's own solution, where it cannot be refined, may break rows by this.
const ACCEPTED_EXCESS: f64 = 1e-7;
/// Share of the largest dual of a certificate below which a constraint has no part in the contradiction.
const PART_IN_CONTRADICTION: f64 = 1e-5;

/// The quadratic function.
#[derive(Debug)]
pub(super) struct Quadratic {
    /// K, symmetric, positive definite.
    pub curvature: Mat<f64>,
    /// q.
    pub slope: Vec<f64>,
}

impl Quadratic {
    /// K w + q.
    pub fn gradient(&self, w: &[f64]) -> Vec<f64> {
        let row = |i: usize| w.iter().enumerate().map(|(j, w)| self.curvature[(i, j)] * w).sum::<f64>();
        self.slope.iter().enumerate().map(|(i, q)| row(i) + q).collect()
    }
}

/// A minimum and its duals.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    /// w.
    pub point: Vec<f64>,
    /// z, by rows.
    pub duals: Vec<Vec<f64>>,
}

/// How a programme ends.
#[derive(Debug)]
pub(super) enum Outcome {
    /// At its minimum.
    Solved(Solution),
    /// Nothing obeys the rows; these (by position) contradict each other.
    Contradiction(Vec<usize>),
    /// Without an answer.
    Failed,
}

/// Solves a programme: by Clarabel to find which rows hold with equality, then refined on those to the last digits.
pub(super) fn solve(quadratic: &Quadratic, rows: &[Rows]) -> Outcome {
    let Some(mut solver) = build(quadratic, rows) else { return Outcome::Failed };
    solver.solve();
    let answer = &solver.solution;
    let mut z = answer.z.iter().copied();
    let duals: Vec<Vec<f64>> = rows.iter().map(|r| z.by_ref().take(r.slack.len()).collect()).collect();
    match answer.status {
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
            Outcome::Contradiction(contradicting(&duals))
        }
        _ if answer.x.iter().chain(&answer.z).all(|v| v.is_finite()) => {
            let found = Solution { point: answer.x.clone(), duals };
            match refine(quadratic, rows, &found) {
                Some(refined) => Outcome::Solved(refined),
                None if is_solution(answer.status, rows, &found) => Outcome::Solved(found),
                None => Outcome::Failed,
            }
        }
        _ => Outcome::Failed,
    }
}

fn is_solution(status: SolverStatus, rows: &[Rows], found: &Solution) -> bool {
    let ended =
        matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress);
    ended && rows.iter().all(|r| r.excess(&r.at(&found.point)) <= ACCEPTED_EXCESS)
}

fn build(quadratic: &Quadratic, rows: &[Rows]) -> Option<DefaultSolver<f64>> {
    let columns = quadratic.slope.len();
    let (mut at, mut of, mut entries, mut slack) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for r in rows {
        for (row, s) in r.coefficients.iter().zip(&r.slack) {
            for (column, c) in row {
                at.push(slack.len());
                of.push(*column);
                entries.push(-c);
            }
            slack.push(*s);
        }
    }
    if !slack.iter().chain(&entries).chain(&quadratic.slope).all(|v| v.is_finite()) {
        return None;
    }
    let cones: Vec<SupportedConeT<f64>> = rows.iter().map(cone).collect();
    let constraint = CscMatrix::new_from_triplets(slack.len(), columns, at, of, entries);
    DefaultSolver::new(
        &upper_triangle(&quadratic.curvature)?,
        &quadratic.slope,
        &constraint,
        &slack,
        &cones,
        settings(),
    )
    .ok()
}

fn cone(rows: &Rows) -> SupportedConeT<f64> {
    match rows.cone {
        Cone::Equation => ZeroConeT(1),
        Cone::Nonnegative => NonnegativeConeT(1),
        Cone::SecondOrder => SecondOrderConeT(rows.slack.len()),
    }
}

/// `None` where an entry is not finite.
fn upper_triangle(matrix: &Mat<f64>) -> Option<CscMatrix<f64>> {
    let columns = matrix.ncols();
    let (mut starts, mut at, mut entries) = (vec![0], Vec::new(), Vec::new());
    for column in 0..columns {
        for row in (0..=column).filter(|row| matrix[(*row, column)] != 0.0) {
            at.push(row);
            entries.push(matrix[(row, column)]);
        }
        starts.push(at.len());
    }
    entries.iter().all(|v| v.is_finite()).then(|| CscMatrix::new(columns, columns, starts, at, entries))
}

fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        tol_gap_abs: TOLERANCE,
        tol_gap_rel: TOLERANCE,
        tol_feas: TOLERANCE,
        // Rows keep their places, so that duals are found again.
        presolve_enable: false,
        direct_solve_method: "qdldl".to_owned(),
        ..DefaultSettings::default()
    }
}

/// Rows with a part in the certificate `z ∈ K*, Gᵀ z = 0, s₀ᵀ z < 0`.
fn contradicting(duals: &[Vec<f64>]) -> Vec<usize> {
    let sizes: Vec<f64> = duals.iter().map(|z| z.iter().fold(0.0, |m: f64, v| m.max(v.abs()))).collect();
    let largest = sizes.iter().fold(0.0, |m: f64, v| m.max(*v));
    (0..duals.len()).filter(|i| sizes[*i] > PART_IN_CONTRADICTION * largest).collect()
}
