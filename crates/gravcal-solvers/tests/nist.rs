//! Certified regressions of NIST, from both starts, by every solver.
//!
//! How many digits must be right is said at [`CertifiedProblem::reached`].

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use gravcal_estimation::published::nist::{self, CertifiedProblem};
use gravcal_estimation::published::{PublishedProblem, Start};
use gravcal_estimation::{Constraint, Estimate, SolveContext, SolveError, Solver};
use gravcal_solvers::{Clarabel, SolverName};

/// How many of the 54 runs fail, as the README's table says. Variable projection takes 50 of them: Chwirut's model has no linear parameter.
fn failures(solver: SolverName) -> usize {
    match solver {
        SolverName::LevenbergMarquardt | SolverName::Clarabel | SolverName::VariableProjection => 0,
        SolverName::GaussNewton => 3,
        SolverName::Dogleg => 1,
    }
}

fn data_sets() -> Option<Vec<CertifiedProblem>> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from).join("nist_strd");
    if !folder.is_dir() {
        eprintln!("SKIPPED: no data sets at {}; set GRAVCAL_SHARED_DATA to the folder above", folder.display());
        return None;
    }
    Some(nist::read(&folder).unwrap())
}

fn solve(solver: &dyn Solver, problem: &PublishedProblem, start: &Start) -> Result<Estimate, SolveError> {
    let (built, initial) = problem.build(start).unwrap();
    solver.solve(&built, &initial, &mut SolveContext::default())
}

#[test]
fn certified_values_are_reached_from_both_starts() {
    let Some(data_sets) = data_sets() else { return };
    for name in SolverName::ALL {
        let solver = name.build();
        let mut failed = Vec::new();
        for (certified, start) in data_sets.iter().flat_map(|c| c.problem.starts.iter().map(move |s| (c, s))) {
            let problem = &certified.problem;
            let (built, initial) = problem.build(start).unwrap();
            if let Err(refusal) = solver.check(&built) {
                println!("{name} on {}, {}: not applicable: {refusal}", problem.name, start.name);
                continue;
            }
            match solver.solve(&built, &initial, &mut SolveContext::default()) {
                Ok(estimate) => {
                    let digits = certified.digits(&built, &estimate.values).unwrap();
                    if !certified.reached(digits) {
                        failed.push(format!("{}, {}: {}, {digits:?}", problem.name, start.name, estimate.termination));
                    }
                }
                Err(error) => failed.push(format!("{}, {}: {error}", problem.name, start.name)),
            }
        }
        println!("{name}: {} of 54 runs failed\n  {}", failed.len(), failed.join("\n  "));
        assert_eq!(failed.len(), failures(name), "{name} fails on:\n  {}", failed.join("\n  "));
    }
}

/// A restart that goes lower than this share of the sum of squares shows that the first run had not converged.
const LOWER: f64 = 1e-6;

/// Sums of squares below this are rounding errors of residuals near one (Lanczos1).
const ROUNDING: f64 = 1e-20;

/// The point where a run ended, and the same point with every parameter moved by a part in a million of itself, or of one
/// for all, up and down in turn: a method that stopped because of what it remembered (damping, scaling, a trust region), on
/// a ridge, or where a parameter that is zero seemed to have no effect, goes on.
fn restarts(end: &[f64]) -> [Start; 3] {
    let moved = |by: fn(f64) -> f64| {
        end.iter().enumerate().map(|(k, v)| if k % 2 == 0 { v + by(*v) } else { v - by(*v) }).collect()
    };
    [("end", end.to_vec()), ("end, scaled", moved(|v| 1e-6 * v)), ("end, nudged", moved(|_| 1e-6))]
        .map(|(name, values)| Start { name: name.to_owned(), values, unreachable: None })
}

#[test]
fn what_is_called_converged_is_not_lowered_by_a_restart() {
    let Some(data_sets) = data_sets() else { return };
    for name in SolverName::ALL {
        let solver = name.build();
        for (problem, start) in data_sets.iter().flat_map(|c| c.problem.starts.iter().map(|s| (&c.problem, s))) {
            let Ok(first) = solve(&*solver, problem, start) else { continue };
            if !first.termination.converged() {
                continue;
            }
            for restart in restarts(first.values.as_slice()) {
                let again = solve(&*solver, problem, &restart).unwrap();
                assert!(
                    again.cost >= (1.0 - LOWER) * first.cost - ROUNDING,
                    "{name} on {}, {}: {} at {:e}, but a restart from its {} ends at {:e}",
                    problem.name,
                    start.name,
                    first.termination,
                    first.cost,
                    restart.name,
                    again.cost
                );
            }
        }
    }
}

#[test]
fn a_bound_that_is_inactive_costs_no_certified_value() {
    let Some(data_sets) = data_sets() else { return };
    for (certified, start) in data_sets.iter().flat_map(|c| c.problem.starts.iter().map(move |s| (c, s))) {
        let (built, initial) = certified.problem.build(start).unwrap();
        let first = built.block_ids().next().unwrap();
        let inactive = Constraint::bound("far away", first, 0, -1e9, 1e9);
        let bounded = built.with_constraints(vec![inactive]).unwrap();
        let estimate = Clarabel::default().solve(&bounded, &initial, &mut SolveContext::default()).unwrap();
        let digits = certified.digits(&bounded, &estimate.values).unwrap();
        let reported = format!("{}, {}: {}, {digits:?}", certified.problem.name, start.name, estimate.termination);
        assert!(certified.reached(digits) && estimate.active.is_empty(), "{reported}");
    }
}
