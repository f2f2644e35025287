//! Starts and constraints that are refused, and in which words.

use gravcal_estimation::{Affine, Block, BlockId, Constraint, ProblemBuilder, SolveError, Solver, Sphere};
use gravcal_solvers::{Clarabel, LevenbergMarquardt};

use crate::build::{block, readings, solve};

/// Two blocks, read as (5, 5, 5) and (5, 5), and their constraints.
fn outcome(
    start: [f64; 5],
    constraints: impl FnOnce(BlockId, BlockId) -> Vec<Constraint>,
) -> Result<Vec<f64>, SolveError> {
    let mut builder = ProblemBuilder::new();
    let a = builder.add_block(block("a", 3), &start[..3]);
    let b = builder.add_block(block("b", 2), &start[3..]);
    readings(&mut builder, a, &[5.0; 3]);
    readings(&mut builder, b, &[5.0; 2]);
    constraints(a, b).into_iter().for_each(|c| builder.add_constraint(c));
    let (problem, initial) = builder.build().unwrap();
    solve(&problem, &initial).map(|estimate| estimate.values.as_slice().to_vec())
}

fn message(start: [f64; 5], constraints: impl FnOnce(BlockId, BlockId) -> Vec<Constraint>) -> String {
    outcome(start, constraints).unwrap_err().to_string()
}

fn below(name: &str, id: BlockId, component: usize, limit: f64) -> Constraint {
    Constraint::bound(name, id, component, f64::NEG_INFINITY, limit)
}

fn above(name: &str, id: BlockId, component: usize, limit: f64) -> Constraint {
    Constraint::bound(name, id, component, limit, f64::INFINITY)
}

#[test]
fn a_start_outside_is_reported_with_the_nearest_inside() {
    assert_eq!(
        message([1.0; 5], |a, _| vec![above("low", a, 1, 2.0), below("high", a, 2, 3.0)]),
        "the start breaks `low` (is 1, must be at least 2); nearest to it, no constraint is broken by a.1 = 2.000000000"
    );
    assert_eq!(
        message([3.0, 4.0, 0.0, 1.0, 1.0], |a, b| vec![
            Constraint::ball("ball", a, &[0.0; 3], 2.5),
            Constraint::bound("sum", b, 0, 1.5, 1.5),
        ]),
        "the start breaks `ball` (has length 5, must be at most 2.5), `sum` (is 1, must be 1.5); nearest to it, no \
         constraint is broken by a.0 = 1.500000000, a.1 = 2.000000000, b.0 = 1.500000000"
    );
    assert_eq!(
        message([3.0, 4.0, 0.0, 1.0, 1.0], |a, _| vec![Constraint::length("length", a, 10.0)]),
        "the start breaks `length` (has length 5, must be 10); nearest to it, no constraint is broken by a.0 = \
         6.000000000, a.1 = 8.000000000"
    );
    assert_eq!(
        message([0.0; 5], |a, _| vec![Constraint::length("length", a, 10.0)]),
        "the start breaks `length` (has length 0, must be 10); nearest to it, no constraint is broken by a.0 = \
         10.000000000"
    );
}

#[test]
fn a_start_outside_by_rounding_is_taken() {
    let limit = 1.0 + 1e-12;
    let found =
        outcome([1.0; 5], |a, _| vec![above("low", a, 0, limit), Constraint::length("l", a, 3f64.sqrt() - 1e-12)]);
    assert!(matches!(found, Err(SolveError::Unsupported(_))), "{found:?}");
    let found =
        outcome([1.0; 5], |a, b| vec![above("low", a, 0, limit), Constraint::length("l", b, 2f64.sqrt() - 1e-12)]);
    assert!(found.unwrap()[..3].iter().all(|v| (v - 5.0).abs() < 1e-9));
}

#[test]
fn constraints_that_contradict_each_other_are_named() {
    let contradicting = message([1.0; 5], |a, b| {
        vec![
            above("first", a, 0, 2.0),
            below("of no concern", a, 1, 3.0),
            below("second", b, 1, 3.0),
            Constraint::range("third", Affine::component(a, 0).plus(b, 1, -1.0), f64::NEG_INFINITY, -1.5),
        ]
    });
    assert_eq!(
        contradicting,
        "no values obey all constraints; these contradict each other: `first`, `second`, `third`"
    );
    let balls = message([1.0; 5], |a, _| {
        let ball = |name: &str, centre: f64| Constraint::ball(name, a, &[centre, 0.0, 0.0], 1.0);
        vec![ball("left", -3.0), ball("right", 3.0), below("of no concern", a, 2, 3.0)]
    });
    assert_eq!(balls, "no values obey all constraints; these contradict each other: `left`, `right`");
}

#[test]
fn crossed_bounds_are_refused_before_anything_runs() {
    let mut builder = ProblemBuilder::new();
    let id = builder.add_block(block("a", 2), &[0.0; 2]);
    readings(&mut builder, id, &[1.0; 2]);
    builder.add_constraint(Constraint::bound("mass", id, 0, 2.0, 1.0));
    let error = builder.build().unwrap_err();
    assert_eq!(error.to_string(), "constraint `mass`: its lower bound 2 exceeds its upper bound 1");
}

#[test]
fn held_values_that_break_a_constraint_are_reported() {
    let mut builder = ProblemBuilder::new();
    let held = builder.add_block(Block::scalar("gain", "").fixed("given"), &[0.0]);
    let free = builder.add_block(block("a", 1), &[1.0]);
    readings(&mut builder, free, &[1.0]);
    builder.add_constraint(above("gain is positive", held, 0, 0.5));
    let (problem, initial) = builder.build().unwrap();
    assert_eq!(
        solve(&problem, &initial).unwrap_err().to_string(),
        "fixed values break `gain is positive` (is 0, must be at least 0.5): fix them elsewhere, or drop the constraint"
    );
}

#[test]
fn a_held_value_in_a_constraint_is_a_number() {
    let mut builder = ProblemBuilder::new();
    let held = builder.add_block(Block::scalar("limit", "").fixed("given"), &[0.5]);
    let free = builder.add_block(block("a", 1), &[0.0]);
    readings(&mut builder, free, &[1.0]);
    let less = Affine::component(free, 0).plus(held, 0, -1.0);
    builder.add_constraint(Constraint::range("less", less, f64::NEG_INFINITY, 0.0));
    let (problem, initial) = builder.build().unwrap();
    let estimate = solve(&problem, &initial).unwrap();
    assert!((estimate.values.scalar(free) - 0.5).abs() < 1e-14);
    assert!((estimate.active[0].multiplier - 0.5).abs() < 1e-14);
}

#[test]
fn what_is_not_convex_is_refused_in_words() {
    let mut builder = ProblemBuilder::new();
    let sphere = Block::vector("g", "", &["x", "y", "z"]).on(Sphere { radius: 1.0 });
    let id = builder.add_block(sphere, &[0.0, 0.0, 1.0]);
    readings(&mut builder, id, &[1.0; 3]);
    let with = |constraint: Constraint| {
        let mut builder = ProblemBuilder::new();
        let sphere = Block::vector("g", "", &["x", "y", "z"]).on(Sphere { radius: 1.0 });
        let id = builder.add_block(sphere, &[0.0, 0.0, 1.0]);
        readings(&mut builder, id, &[1.0; 3]);
        builder.add_constraint(constraint);
        let (problem, _) = builder.build().unwrap();
        Clarabel::default().check(&problem).unwrap_err().to_string()
    };
    assert_eq!(
        with(above("upwards", id, 2, 0.0)),
        "clarabel cannot take this problem: `upwards` reads `g`, which is on a manifold (sphere): what obeys both is not \
         convex; drop the constraint, or let a residual measure what the manifold fixes"
    );
    assert_eq!(
        with(Constraint::length("unit", id, 1.0)),
        "clarabel cannot take this problem: `unit` fixes the length of `g`, which is on a manifold (sphere): drop one of the \
         two"
    );
    let twice = message([1.0; 5], |a, _| {
        vec![Constraint::length("one", a, 3f64.sqrt()), Constraint::length("two", a, 3f64.sqrt())]
    });
    assert!(twice.ends_with("`one` and `two` both fix the length of `a`: drop one of them"), "{twice}");
}

#[test]
fn methods_without_constraints_refuse_them() {
    let mut builder = ProblemBuilder::new();
    let id = builder.add_block(block("a", 2), &[0.0; 2]);
    readings(&mut builder, id, &[1.0; 2]);
    builder.add_constraint(below("half", id, 0, 0.5));
    let (problem, _) = builder.build().unwrap();
    let refused = LevenbergMarquardt::default().check(&problem).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "levenberg-marquardt cannot take this problem: it has a constraint (`half`): clarabel can take them"
    );
}
