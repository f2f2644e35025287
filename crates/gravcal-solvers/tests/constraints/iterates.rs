//! What happens on the way to a solution.

use std::sync::atomic::{AtomicBool, Ordering};

use gravcal_estimation::{
    Block, BlockId, Constraint, EvaluateError, Factor, IterationRecord, LocalValues, Noise, Problem, ProblemBuilder,
    Residual, RowsMut, SolveContext, Solver, Termination, Values,
};
use gravcal_solvers::{Clarabel, StoppingRules};

/// `√x − reading`, which no negative x has; `asked_outside` tells whether one was tried.
#[derive(Debug)]
struct Root {
    block: BlockId,
    reading: f64,
    asked_outside: &'static AtomicBool,
}

impl Residual for Root {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.block)
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let root = x.scalar(0).sqrt();
        if root.is_nan() {
            self.asked_outside.store(true, Ordering::Relaxed);
            return Err(EvaluateError("the root of a negative number".into()));
        }
        residual[0] = root - self.reading;
        if let Some(mut rows) = jacobian {
            rows.row(0)[0] = 0.5 / root;
        }
        Ok(())
    }
}

/// From 9, with x ≥ 0.01: the optimum of a reading of −1 is there, and a free step would go to −15.
fn root(asked_outside: &'static AtomicBool) -> (Problem, Values) {
    let mut builder = ProblemBuilder::new();
    let block = builder.add_block(Block::scalar("x", ""), &[9.0]);
    let residual = Root { block, reading: -1.0, asked_outside };
    builder.add_factor(Factor::new(residual, Noise::independent(&[1.0]).unwrap()));
    builder.add_constraint(Constraint::bound("x", block, 0, 0.01, f64::INFINITY));
    builder.build().unwrap()
}

/// At x = 0.01 the residual is 1.1 and its slope 5: the cost falls by 5.5 for each unit.
#[test]
fn no_point_outside_is_ever_evaluated() {
    static ASKED_OUTSIDE: AtomicBool = AtomicBool::new(false);
    let (problem, initial) = root(&ASKED_OUTSIDE);
    let mut reported: Vec<IterationRecord> = Vec::new();
    let mut observer = |record: &IterationRecord| reported.push(*record);
    let mut context = SolveContext { observer: Some(&mut observer), ..SolveContext::default() };
    let estimate = Clarabel::default().solve(&problem, &initial, &mut context).unwrap();
    let x = estimate.values.as_slice()[0];
    assert!((0.01..0.01 + 1e-15).contains(&x), "{x}");
    assert!((estimate.active[0].multiplier - 5.5).abs() < 1e-9, "{:?}", estimate.active);
    assert!(!ASKED_OUTSIDE.load(Ordering::Relaxed));
    assert_eq!(reported, estimate.iterations);
    assert!(reported.windows(2).all(|pair| pair[1].cost < pair[0].cost));
}

#[test]
fn it_stops_when_asked_to() {
    static ASKED_OUTSIDE: AtomicBool = AtomicBool::new(false);
    let (problem, initial) = root(&ASKED_OUTSIDE);
    let stop = AtomicBool::new(true);
    let mut context = SolveContext { stop: Some(&stop), ..SolveContext::default() };
    let estimate = Clarabel::default().solve(&problem, &initial, &mut context).unwrap();
    assert_eq!((estimate.termination, estimate.values), (Termination::Stopped, initial.clone()));
    let one = Clarabel { stopping: StoppingRules { max_iterations: 1, ..StoppingRules::default() } };
    let estimate = one.solve(&problem, &initial, &mut SolveContext::default()).unwrap();
    assert_eq!((estimate.termination, estimate.iterations.len()), (Termination::IterationLimit { limit: 1 }, 2));
}
