//! Levenberg-Marquardt.
//!
//! Each iteration minimises the damped linear model
//!
//! ```text
//!     ½ ‖J δ + r‖² + ½ λ ‖D δ‖²
//! ```
//!
//! and moves to `x ⊞ δ` if the cost falls. `D` holds the largest norm that each column of J has had so far (Moré,
//! *The Levenberg-Marquardt algorithm: implementation and theory*, 1978, eq. 6.3), so that the path does not
//! depend on units. `λ` follows Nielsen (`damping.rs`). A direction without information is simply not moved along:
//! rank-deficient problems converge to a point of their valley.
//!
//! Left out of the sources: Moré's trust-region radius (λ is damped directly) and geodesic acceleration.

use gravcal_estimation::{Estimate, Problem, SolveContext, SolveError, Solver, Unsupported, Values};
use serde::Deserialize;

use crate::damping::{Damping, damped_iteration};
use crate::refusal::refuse_constraints;
use crate::{Descent, Dogleg, Move, Point, StoppingRules, VariableProjection, minimise};

pub(crate) const NAME: &str = "levenberg-marquardt";

/// The method with its options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct LevenbergMarquardt {
    /// When it ends.
    pub stopping: StoppingRules,
}

impl Solver for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        refuse_constraints(NAME, problem) // fewer rows than unknowns and lost rank are left to the damping
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        minimise(self, problem, initial, context)
    }

    fn companions(&self) -> Vec<Box<dyn Solver>> {
        vec![Box::new(Dogleg { stopping: self.stopping }), Box::new(VariableProjection { stopping: self.stopping })]
    }
}

impl Descent for LevenbergMarquardt {
    type Memory = Damping;

    fn stopping(&self) -> &StoppingRules {
        &self.stopping
    }

    fn iterate<'p>(&self, damping: &mut Damping, here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        damped_iteration(damping, here, &self.stopping)
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Termination;

    use super::*;
    use crate::testing::{DECAY_ROWS, built, decay, far_decay, linear, scalar};

    fn dampings((problem, initial): &(Problem, Values)) -> Vec<f64> {
        let found = LevenbergMarquardt::default().solve(problem, initial, &mut SolveContext::default()).unwrap();
        assert!(found.termination.converged(), "{}", found.termination);
        found.iterations.iter().map(|record| record.damping).collect()
    }

    #[test]
    fn the_first_step_is_hardly_damped_only_where_the_start_is_near() {
        let far = far_decay();
        assert!(dampings(&far)[1] >= 1e-3);
        let end = LevenbergMarquardt::default().solve(&far.0, &far.1, &mut SolveContext::default()).unwrap().values;
        let [rate, amplitude, level] = ["rate", "amplitude", "level"].map(|name| end.scalar(far.0.find(name).unwrap()));
        let near = vec![scalar("rate", 1.001 * rate), linear("amplitude", amplitude), linear("level", level)];
        let near = built(near, DECAY_ROWS, decay);
        assert!(dampings(&near)[1] < 1e-7);
    }

    #[test]
    fn the_offset_that_ends_a_fit_follows_the_cosine_tolerance() {
        let (problem, initial) = far_decay();
        let iterations = [1e-4, 1e-7, 1e-10].map(|cosine_tolerance| {
            let stopping = StoppingRules { cosine_tolerance, ..StoppingRules::default() };
            let found =
                LevenbergMarquardt { stopping }.solve(&problem, &initial, &mut SolveContext::default()).unwrap();
            let (Termination::Offset { offset: last } | Termination::Gradient { cosine: last }) = found.termination
            else {
                panic!("{}", found.termination)
            };
            assert!(last <= (10.0 * cosine_tolerance).min(1e-3), "{}", found.termination);
            found.iterations.len()
        });
        assert!(iterations.is_sorted() && iterations[0] < iterations[2], "{iterations:?}");
    }
}
