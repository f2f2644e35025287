//! A method of one's own: Gauss-Newton steps, damped after Marquardt.
//!
//! ```text
//!     (JᵀJ + λ D²) δ = −Jᵀ r,    D: column norms of J
//! ```

use gravcal::calibration::SolverFactory;
use gravcal::calibration::sensors::{Options, RefusedOption};
use gravcal::estimation::{
    Estimate, IterationRecord, Problem, SolveContext, SolveError, Solver, Termination, Unsupported, Values,
};

const NAME: &str = "marquardt";
const MAX_ITERATIONS: &str = "max_iterations";
const ITERATIONS: usize = 200;
/// Largest cosine between the residual and a column of J at which it has converged.
const COSINE: f64 = 1e-8;
/// Predicted reduction, relative to the cost, that is worth no further step.
const REDUCTION: f64 = 1e-13;
const LARGEST_DAMPING: f64 = 1e12;

/// The method.
#[derive(Debug)]
pub struct Marquardt {
    /// It gives up after so many.
    pub max_iterations: usize,
}

impl Default for Marquardt {
    fn default() -> Self {
        Marquardt { max_iterations: ITERATIONS }
    }
}

/// The method by its name, with its options.
#[derive(Debug)]
pub struct MarquardtFactory;

impl SolverFactory for MarquardtFactory {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "Gauss-Newton steps, damped after Marquardt"
    }

    fn options(&self) -> &[&str] {
        &[MAX_ITERATIONS]
    }

    fn build(&self, options: &Options) -> Result<Box<dyn Solver>, RefusedOption> {
        let Some(written) = options.whole_number(MAX_ITERATIONS)? else { return Ok(Box::new(Marquardt::default())) };
        let max_iterations = usize::try_from(written).ok().filter(|most| *most > 0);
        let refused =
            || RefusedOption::new(MAX_ITERATIONS, format!("expected one iteration at least, found {written}"));
        Ok(Box::new(Marquardt { max_iterations: max_iterations.ok_or_else(refused)? }))
    }
}

impl Solver for Marquardt {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        match problem.constraints() {
            [] => Ok(()),
            _ => Err(Unsupported { solver: NAME, reason: "it knows no constraints".into() }),
        }
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        self.check(problem)?;
        let (mut values, mut damping, mut step_length) = (initial.clone(), 1e-3, 0.0);
        let (mut iterations, mut iterates) = (Vec::new(), Vec::new());
        let (cost, termination) = loop {
            let mut linear = problem.linearize(&values)?;
            let (cost, cosine) = (linear.cost(), linear.largest_cosine());
            let record = IterationRecord { iteration: iterations.len(), cost, cosine, step: step_length, damping };
            context.report(&record);
            iterations.push(record);
            iterates.push(values.clone());
            if cosine <= COSINE {
                break (cost, Termination::Gradient { cosine });
            }
            if context.stopped() {
                break (cost, Termination::Stopped);
            }
            if iterations.len() > self.max_iterations {
                break (cost, Termination::IterationLimit { limit: self.max_iterations });
            }
            let scaling = linear.column_scales();
            let mut step = vec![0.0; scaling.len()];
            let next = loop {
                let predicted = linear.damped_step(damping, &scaling, &mut step).predicted_reduction;
                if predicted <= REDUCTION * cost {
                    break Err(Termination::Cost { relative: predicted / cost });
                }
                let next = problem.retract(&values, &step);
                // Where a residual has no value, a shorter step may have one.
                if problem.cost(&next).is_ok_and(|lower| lower < cost) {
                    break Ok(next);
                }
                damping *= 4.0;
                if damping > LARGEST_DAMPING {
                    break Err(Termination::NoProgress);
                }
            };
            match next {
                Err(termination) => break (cost, termination),
                Ok(next) => values = next,
            }
            step_length = step.iter().map(|s| s * s).sum::<f64>().sqrt();
            damping *= 0.2;
        };
        Ok(Estimate {
            values,
            cost,
            termination,
            iterations,
            iterates,
            active: Vec::new(),
            without_effect: Vec::new(),
            normal_equations: None,
        })
    }
}
