//! No method calls converged what is not: places where no step lowers the cost although the Jacobian says that one would.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use gravcal_estimation::{
    Block, BlockId, Constraint, Estimate, EvaluateError, Factor, LocalValues, Noise, Problem, ProblemBuilder, Residual,
    RowsMut, SolveContext, SolveError, Solver, Termination, Values,
};
use gravcal_solvers::{Clarabel, Dogleg, LevenbergMarquardt, SolverName, StoppingRules};

/// `r = (f(x), c)` with a slope that may be wrong, of the nonlinear x and of the linear c.
#[derive(Debug)]
struct Curve {
    blocks: [BlockId; 2],
    value: fn(f64) -> Result<f64, EvaluateError>,
    slope: fn(f64) -> f64,
}

impl Residual for Curve {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        2
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        (residual[0], residual[1]) = ((self.value)(x.scalar(0))?, x.scalar(1) - 3.0);
        if let Some(mut rows) = jacobian {
            rows.row(0)[0] = (self.slope)(x.scalar(0));
            rows.row(1)[1] = 1.0;
        }
        Ok(())
    }
}

/// The answer of every method from x = `start`; of `clarabel` under constraints, too: a bound that is far away, and one on
/// which c leans.
fn answers(
    start: f64,
    value: fn(f64) -> Result<f64, EvaluateError>,
    slope: fn(f64) -> f64,
) -> Vec<(SolverName, f64, Estimate)> {
    let mut builder = ProblemBuilder::new();
    let x = builder.add_block(Block::scalar("x", ""), &[start]);
    let c = builder.add_block(Block::scalar("c", "").linear(), &[0.0]);
    builder.add_factor(Factor::new(Curve { blocks: [x, c], value, slope }, Noise::independent(&[1.0; 2]).unwrap()));
    let (problem, initial) = builder.build().unwrap();
    let far = Constraint::bound("x is not far away", x, 0, -10.0, 10.0);
    let near = Constraint::bound("c is at most 1", c, 0, f64::NEG_INFINITY, 1.0);
    let under = |constraints: Vec<Constraint>| (SolverName::Clarabel, problem.with_constraints(constraints).unwrap());
    let free = SolverName::ALL.into_iter().map(|solver| (solver, problem.clone()));
    let built = free.chain([under(vec![far.clone()]), under(vec![near.clone()]), under(vec![far, near])]);
    let solve = |(solver, problem): (SolverName, Problem)| {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        (solver, estimate.values.scalar(x), estimate)
    };
    built.map(solve).collect()
}

#[test]
fn the_edge_of_where_the_model_has_values_is_no_minimum() {
    let value = |x: f64| if x < 2.0 { Ok(x - 3.0) } else { Err(EvaluateError("beyond 2".into())) };
    for (solver, x, estimate) in answers(0.0, value, |_| 1.0) {
        assert!((x - 2.0).abs() < 1e-6, "{solver}: {x}");
        assert!(!estimate.termination.converged(), "{solver}: {}", estimate.termination);
    }
}

#[test]
fn a_kink_is_no_minimum_of_the_linear_model() {
    for (solver, x, estimate) in answers(-3.0, |x| Ok(1.0 + x.abs()), f64::signum) {
        assert!(x.abs() < 1e-6, "{solver}: {x}");
        assert!(!estimate.termination.converged(), "{solver}: {}", estimate.termination);
    }
}

#[test]
fn a_derivative_of_the_wrong_sign_leads_nowhere() {
    for (solver, _, estimate) in answers(1.0, |x| Ok(x + 4.0), |_| -1.0) {
        assert!(!estimate.termination.converged(), "{solver}: {}", estimate.termination);
    }
}

#[test]
fn iterations_that_run_out_are_reported() {
    for solver in SolverName::ALL {
        let mut builder = ProblemBuilder::new();
        let x = builder.add_block(Block::scalar("x", ""), &[30.0]);
        let c = builder.add_block(Block::scalar("c", "").linear(), &[0.0]);
        let curve = Curve { blocks: [x, c], value: |x| Ok(x.exp()), slope: f64::exp };
        builder.add_factor(Factor::new(curve, Noise::independent(&[1.0; 2]).unwrap()));
        let (problem, initial) = builder.build().unwrap();
        let two = solver.with_options(&mut serde_json::Deserializer::from_str(r#"{ "max_iterations": 2 }"#)).unwrap();
        let estimate = two.solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        assert_eq!(estimate.termination, Termination::IterationLimit { limit: 2 }, "{solver}");
        assert_eq!(estimate.iterations.len(), 3, "{solver}");
    }
}

/// What every method (of `clarabel` also under a bound that is far away) says to `r = (f(x), c − 3)` from x = `start`.
fn reported(
    start: f64,
    value: fn(f64) -> Result<f64, EvaluateError>,
    slope: fn(f64) -> f64,
) -> Vec<(String, Reported)> {
    let mut builder = ProblemBuilder::new();
    let x = builder.add_block(Block::scalar("x", ""), &[start]);
    let c = builder.add_block(Block::scalar("c", "").linear(), &[3.0]);
    builder.add_factor(Factor::new(Curve { blocks: [x, c], value, slope }, Noise::independent(&[1.0; 2]).unwrap()));
    let (problem, initial) = builder.build().unwrap();
    reported_of(&problem, x, &initial)
}

type Reported = Result<Estimate, SolveError>;

fn reported_of(problem: &Problem, x: BlockId, initial: &Values) -> Vec<(String, Reported)> {
    let far = Constraint::bound("x is not far away", x, 0, -1e300, 1e300);
    let bounded = problem.with_constraints(vec![far]).unwrap();
    let free = SolverName::ALL.into_iter().map(|solver| (solver.to_string(), solver, problem));
    let all = free.chain([("clarabel under a bound".to_owned(), SolverName::Clarabel, &bounded)]);
    all.map(|(name, solver, p)| (name, solver.build().solve(p, initial, &mut SolveContext::default()))).collect()
}

#[test]
fn a_sum_of_squares_that_overflows_or_underflows_is_an_error_with_the_factor() {
    for (name, solved) in reported(1e200, |x| Ok(x - 3.0), |_| 1.0) {
        let error = solved.unwrap_err().to_string();
        let expected =
            ["the start cannot be evaluated: the cost is inf", "1e200 standard deviations, is of factor 0 at x ="];
        assert!(expected.iter().all(|text| error.contains(text)), "{name}: {error}");
    }
    for (name, solved) in reported(0.0, |x| Ok(x - 1e-170), |_| 1.0) {
        let error = solved.unwrap_err().to_string();
        assert!(error.contains("the cost is 0, as squares of residuals leave the range of numbers"), "{name}: {error}");
    }
    for (name, solved) in reported(1e-160, |x| Ok(1e160 * x - 3.0), |_| 1e160) {
        let error = solved.unwrap_err().to_string();
        assert!(error.contains("the squares of the residuals' derivatives overflow"), "{name}: {error}");
    }
}

#[test]
fn a_jacobian_that_was_not_written_is_not_converged() {
    #[derive(Debug)]
    struct Forgotten(BlockId);
    impl Residual for Forgotten {
        fn blocks(&self) -> &[BlockId] {
            std::slice::from_ref(&self.0)
        }

        fn len(&self) -> usize {
            1
        }

        fn evaluate(&self, x: LocalValues<'_>, r: &mut [f64], _: Option<RowsMut<'_>>) -> Result<(), EvaluateError> {
            r[0] = x.scalar(0) - 3.0;
            Ok(())
        }
    }
    let mut builder = ProblemBuilder::new();
    let x = builder.add_block(Block::scalar("x", ""), &[1.0]);
    builder.add_factor(Factor::new(Forgotten(x), Noise::independent(&[1.0]).unwrap()));
    let (problem, initial) = builder.build().unwrap();
    for (name, solved) in
        reported_of(&problem, x, &initial).into_iter().filter(|(name, _)| name != "variable-projection")
    {
        let estimate = solved.unwrap();
        assert_eq!((estimate.termination, estimate.without_effect.len()), (Termination::NoEffect, 1), "{name}");
        assert!(!estimate.termination.converged());
    }
    // One unknown of two: the other is solved for, and this one is told.
    for (name, solved) in reported(1.0, |x| Ok(x - 3.0), |_| 0.0) {
        let without_effect = solved.unwrap().without_effect;
        assert_eq!(without_effect.iter().map(|column| column.block).collect::<Vec<_>>(), [x], "{name}");
    }
}

#[test]
fn what_cannot_be_solved_is_an_error_with_a_word() {
    let build = |blocks: usize| {
        let mut builder = ProblemBuilder::new();
        let x = builder.add_block(Block::scalar("x", ""), &[1.0]);
        let c = builder.add_block(Block::scalar("c", "").linear(), &[0.0]);
        let curve = Curve { blocks: [x, c], value: |x| Ok(x - 3.0), slope: |_| 1.0 };
        builder.add_factor(Factor::new(curve, Noise::independent(&[1.0; 2]).unwrap()));
        (2..blocks).for_each(|k| _ = builder.add_block(Block::scalar(format!("k{k}"), "").fixed("known"), &[0.0]));
        (builder.build().unwrap(), x)
    };
    let ((problem, initial), x) = build(3);
    for blocks in [2, 4] {
        for (name, solved) in reported_of(&problem, x, &build(blocks).0.1) {
            assert_eq!(solved.unwrap_err(), SolveError::ForeignStart, "{name}");
        }
    }
    let held = problem.with_fixed(&problem.block_ids().collect::<Vec<_>>(), "all is known");
    for (name, solved) in reported_of(&held, x, &initial).into_iter().filter(|(name, _)| name != "variable-projection")
    {
        assert_eq!(solved.unwrap_err(), SolveError::NoUnknowns, "{name}");
    }
    for (stopping, expected) in [
        (StoppingRules { max_iterations: 0, ..StoppingRules::default() }, "max_iterations is 0, and must be a whole"),
        (StoppingRules { step_tolerance: -1.0, ..StoppingRules::default() }, "step_tolerance is -1, and must be a"),
        (StoppingRules { cosine_tolerance: f64::NAN, ..StoppingRules::default() }, "cosine_tolerance is NaN, and"),
    ] {
        for solver in [&LevenbergMarquardt { stopping } as &dyn Solver, &Clarabel { stopping }, &Dogleg { stopping }] {
            let error = solver.solve(&problem, &initial, &mut SolveContext::default()).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{}: {expected}", solver.name())), "{error}");
        }
    }
}
