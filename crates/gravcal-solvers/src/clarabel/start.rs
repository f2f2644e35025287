//! Whether a start obeys its constraints, and what would.
//!
//! A start outside is refused with the nearest values that obey, those of
//!
//! ```text
//!     minimise over δ   Σ_blocks ‖δ‖² / ‖x‖²     such that   s(δ) = s₀ + G δ ∈ K
//! ```
//!
//! (a block of zeros counts in its unit). If there are none, the certificate of that (`z ∈ K*` with `Gᵀ z = 0` and
//! `s₀ᵀ z < 0`) tells constraints that contradict each other; of these, the ones are left out without which the others still
//! do (deletion filter: Chinneck and Dravnieks, *Locating minimal infeasible constraint sets in linear programs*, 1991).

use faer::Mat;
use gravcal_estimation::{Constraint, ConstraintKind, Problem, SolveError, Values};

use super::programme::{NAME, Outcome, Quadratic, solve};
use super::rows::{Rows, norm, rows};

/// # Errors
/// Where `initial` breaks a constraint.
pub(super) fn check(problem: &Problem, initial: &Values) -> Result<(), SolveError> {
    let broken: Vec<&Constraint> = problem.constraints().iter().filter(|c| !c.is_obeyed_by(initial)).collect();
    if broken.is_empty() {
        return Ok(());
    }
    if let Some(constraint) = broken.iter().find(|c| reads_nothing_free(problem, c)) {
        return Err(SolveError::HeldOutside(constraint.complaint(initial)));
    }
    let complaints: Vec<String> = broken.iter().map(|c| c.complaint(initial)).collect();
    let nearest = nearest(problem, initial)?;
    let mut advice: Vec<String> = Vec::new();
    for constraint in broken {
        for id in constraint.blocks() {
            let (block, old, new) = (problem.block(id), initial.get(id), nearest.get(id));
            let moved = (0..block.len()).filter(|i| old[*i] != new[*i]);
            let reported = moved.map(|i| format!("{} = {:.9}", block.component_name(i), new[i]));
            reported.for_each(|reported| {
                if !advice.contains(&reported) {
                    advice.push(reported)
                }
            });
        }
    }
    Err(SolveError::StartOutside { broken: complaints, nearest: advice })
}

fn reads_nothing_free(problem: &Problem, constraint: &Constraint) -> bool {
    constraint.blocks().iter().all(|id| problem.columns_of(*id).is_empty())
}

fn nearest(problem: &Problem, initial: &Values) -> Result<Values, SolveError> {
    let mut nearest = initial.clone();
    let is_length = |r: &Rows| matches!(problem.constraints()[r.constraint].kind, ConstraintKind::Length { .. });
    let convex: Vec<Rows> = rows(problem, initial).into_iter().filter(|r| !is_length(r)).collect();
    if !convex.is_empty() {
        nearest = problem.retract(&nearest, &projection(problem, initial, &convex)?);
    }
    scale_to_length(problem, &mut nearest);
    leave_zero(problem, &mut nearest);
    Ok(nearest)
}

/// To a vector of zeros every one of its length is equally near: the first axis.
fn leave_zero(problem: &Problem, values: &mut Values) {
    for constraint in problem.constraints() {
        if let ConstraintKind::Length { block, length } = &constraint.kind
            && norm(values.get(*block)) == 0.0
            && !problem.columns_of(*block).is_empty()
        {
            let mut vector = vec![0.0; values.get(*block).len()];
            vector[0] = *length;
            values.set(*block, &vector);
        }
    }
}

fn projection(problem: &Problem, initial: &Values, rows: &[Rows]) -> Result<Vec<f64>, SolveError> {
    let units: Vec<f64> = problem
        .block_ids()
        .filter(|id| !problem.columns_of(*id).is_empty())
        .flat_map(|id| {
            let size = norm(initial.get(id));
            problem.columns_of(id).map(move |_| if size > 0.0 { size } else { 1.0 })
        })
        .collect();
    let columns = units.len();
    let distance = Quadratic { curvature: Mat::identity(columns, columns), slope: vec![0.0; columns] };
    let rows: Vec<Rows> = rows.iter().map(|r| r.in_units(&units)).collect();
    match solve(&distance, &rows) {
        Outcome::Solved(solution) => Ok(solution.point.iter().zip(&units).map(|(w, unit)| w * unit).collect()),
        Outcome::Contradiction(positions) => {
            let contradicting = positions.into_iter().map(|i| rows[i].clone()).collect();
            let mut names: Vec<String> = irreducible(&distance, contradicting)
                .iter()
                .map(|r| format!("`{}`", problem.constraints()[r.constraint].name))
                .collect();
            names.dedup();
            Err(SolveError::Contradiction(names))
        }
        Outcome::Failed => {
            let reason = "the start breaks constraints, and the nearest that breaks none cannot be found".to_owned();
            Err(SolveError::Failed { solver: NAME, reason })
        }
    }
}

/// Frees values of rounding errors: vectors of known length have it, bounds hold to the last bit.
pub(crate) fn settle(problem: &Problem, values: &mut Values) {
    scale_to_length(problem, values);
    for constraint in problem.constraints() {
        if let ConstraintKind::Range { function, lower, upper } = &constraint.kind
            && let [(id, component, 1.0)] = function.terms[..]
            && !problem.columns_of(id).is_empty()
        {
            let mut block = values.get(id).to_vec();
            block[component] = block[component].max(lower - function.constant).min(upper - function.constant);
            values.set(id, &block);
        }
    }
}

/// Rows of a contradiction, each of which it needs.
fn irreducible(quadratic: &Quadratic, mut rows: Vec<Rows>) -> Vec<Rows> {
    let mut at = 0;
    while at < rows.len() {
        let left_out = rows.remove(at);
        if !matches!(solve(quadratic, &rows), Outcome::Contradiction(_)) {
            rows.insert(at, left_out);
            at += 1;
        }
    }
    rows
}

/// Brings every vector of known length to its length.
fn scale_to_length(problem: &Problem, values: &mut Values) {
    for constraint in problem.constraints() {
        if let ConstraintKind::Length { block, length } = &constraint.kind {
            let size = norm(values.get(*block));
            if size > 0.0 && !problem.columns_of(*block).is_empty() {
                let scaled: Vec<f64> = values.get(*block).iter().map(|x| length * x / size).collect();
                values.set(*block, &scaled);
            }
        }
    }
}
