//! No method calls converged what is not: places where no step lowers the cost although the Jacobian says that one would.

// clippy.toml allows unwrap in tests, but does not see that a helper of one is part of it.
#![allow(clippy::unwrap_used)]

use gravcal_estimation::{
    Block, BlockId, Constraint, Estimate, EvaluateError, Factor, LocalValues, Noise, Problem, ProblemBuilder, Residual,
    RowsMut, SolveContext, Termination,
};
use gravcal_solvers::SolverName;

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
    let posed = free.chain([under(vec![far.clone()]), under(vec![near.clone()]), under(vec![far, near])]);
    let solve = |(solver, problem): (SolverName, Problem)| {
        let estimate = solver.build().solve(&problem, &initial, &mut SolveContext::default()).unwrap();
        (solver, estimate.values.scalar(x), estimate)
    };
    posed.map(solve).collect()
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
fn iterations_that_run_out_are_told() {
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

#[test]
fn a_cost_that_overflows_is_an_error_under_constraints_too() {
    let mut builder = ProblemBuilder::new();
    let x = builder.add_block(Block::scalar("x", ""), &[1e200]);
    let c = builder.add_block(Block::scalar("c", "").linear(), &[0.0]);
    let curve = Curve { blocks: [x, c], value: |x| Ok(x - 3.0), slope: |_| 1.0 };
    builder.add_factor(Factor::new(curve, Noise::independent(&[1.0; 2]).unwrap()));
    builder.add_constraint(Constraint::bound("x is huge", x, 0, 1e200, 2e200));
    let (problem, initial) = builder.build().unwrap();
    let solved = SolverName::Clarabel.build().solve(&problem, &initial, &mut SolveContext::default());
    assert!(solved.unwrap_err().to_string().starts_with("the start cannot be evaluated: the cost is inf"));
}
