//! A solver of one's own: Gauss-Newton with steps that are halved until the cost falls. Whatever takes a `&dyn Solver` takes it.
//!
//! ```sh
//! cargo run --release -p gravcal --example own_solver
//! ```

mod common;

use std::error::Error;

use gravcal::calibration::{EstimatorName, SolveEnvironment, calibrate};
use gravcal::estimation::{Estimate, Problem, SolveContext, SolveError, Solver, Unsupported, Values};
use gravcal::solvers::{Decision, Descent, Move, Point, StoppingRules, minimise, refuse_constraints};

#[derive(Clone, Debug, Default)]
struct HalvedGaussNewton {
    stopping: StoppingRules,
}

impl Solver for HalvedGaussNewton {
    fn name(&self) -> &'static str {
        "halved-gauss-newton"
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        refuse_constraints(self.name(), problem)
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        minimise(self, problem, initial, context)
    }
}

impl Descent for HalvedGaussNewton {
    type Memory = (); // a damping or a radius would stand here

    fn stopping(&self) -> &StoppingRules {
        &self.stopping
    }

    fn iterate<'p>(&self, (): &mut (), here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        let (mut step, _) = here.full_step();
        loop {
            let mut trial = here.attempt(&step, here.predicted(&step));
            match here.decide(&mut trial, 0.0, &self.stopping) {
                Decision::Accept(end) => return Ok(Move::To { trial: Box::new(trial), damping: 0.0, end }),
                Decision::End(end) => return Ok(Move::Stay(end)),
                Decision::Shorten => step.iter_mut().for_each(|component| *component *= 0.5),
            }
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let session = common::simulation()?.session(0);
    let solver = HalvedGaussNewton::default();
    let results = calibrate(&session, &[EstimatorName::Joint], &SolveEnvironment::new(&solver, &|_stage| {}));
    let result = results.first().ok_or("no estimator ran")?;
    println!("{}: {} after {} iterations", solver.name(), result.termination, result.iterations);
    let gain = result.parameter("joint2.torque_gain").and_then(|gain| gain.value).ok_or("not determined")?;
    println!("joint2.torque_gain {gain:.4}");
    assert!((gain - 1.08).abs() < 0.005);
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::main().unwrap();
    }
}
