//! The problems of Moré, Garbow and Hillstrom from their standard starts, 10 times and 100 times these, by every solver.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use gravcal_estimation::SolveContext;
use gravcal_estimation::published::{PublishedProblem, Start, more_garbow_hillstrom};
use gravcal_solvers::SolverName;

/// How many of the 35 must be solved from every start from which a published minimum is to be expected.
fn problems_required(solver: SolverName) -> usize {
    if solver == SolverName::LevenbergMarquardt { 35 } else { 15 }
}

/// What kept a run from a published minimum, if anything.
fn failure(solver: SolverName, problem: &PublishedProblem, start: &Start) -> Option<String> {
    let (built, initial) = problem.build(start).unwrap();
    match solver.build().solve(&built, &initial, &mut SolveContext::default()) {
        Ok(estimate) if problem.minimum_at(2.0 * estimate.cost).is_some() => None,
        Ok(estimate) => Some(format!("Σ r² = {:e}, {}", 2.0 * estimate.cost, estimate.termination)),
        Err(error) => Some(error.to_string()),
    }
}

#[test]
fn published_minima_are_reached_from_near_and_far() {
    let problems = more_garbow_hillstrom();
    for solver in SolverName::ALL {
        let (mut all, mut failed) = (BTreeSet::new(), BTreeSet::new());
        let taken = problems.iter().filter(|problem| {
            let (built, _) = problem.build(&problem.starts[0]).unwrap();
            solver.build().check(&built).is_ok()
        });
        for problem in taken {
            all.insert(&problem.source);
            for start in problem.starts.iter().filter(|start| start.unreachable.is_none()) {
                if let Some(failure) = failure(solver, problem, start) {
                    println!("{solver} on {}, {}: {failure}", problem.name, start.name);
                    failed.insert(&problem.source);
                }
            }
        }
        let solved = all.len() - failed.len();
        println!("{solver}: {solved} of {} problems from every start", all.len());
        // Variable projection takes problems with linear parameters only, and none of these says that it has any.
        let required = if all.is_empty() { 0 } else { problems_required(solver) };
        assert!(solved >= required, "{solver} solves only {solved}; not {failed:?}");
    }
}
