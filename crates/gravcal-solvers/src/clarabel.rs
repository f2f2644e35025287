//! The constrained method: sequential conic programming, each step solved by Clarabel.
//!
//! At `x`, with the linear model of the residuals, the step is the minimum of
//!
//! ```text
//!     ½ ‖J δ + r‖² + ½ λ ‖D δ‖²     such that every constraint holds at x + δ
//! ```
//!
//! a quadratic function over ranges and second-order cones. All else is
//! [`LevenbergMarquardt`](crate::LevenbergMarquardt)'s: `D`, `λ`, the bound of the first step, and when it ends, with the
//! full step the best of those that obey the constraints. The start obeys them, they are convex, and each step obeys them:
//! so do all points on the way, and the cost alone tells progress. A vector of known length is moved along its tangent
//! plane and scaled back to its length.
//!
//! **Optimality.** It ends where the Lagrangian `½ ‖r‖² − zᵀ s` is stationary, `Jᵀ r = Gᵀ z`, with `s` and `z` in their cones
//! and `zᵀ s = 0` (Karush, Kuhn and Tucker; Nocedal and Wright, *Numerical optimization*, 2006, theorem 12.1). The cosine of
//! the trace and of the termination is that of `Jᵀ r − Gᵀ z`, or `zᵀ s / ‖r‖²` where that is larger.
//!
//! **Digits.** Without constraints it is Levenberg-Marquardt; where none of them stops a step, the step is. Else `JᵀJ` is formed: directions that the data hardly determine (singular values below 1e-6 of
//! the largest, columns scaled) are then walked along slowly. The gradient loses no digit by it, and neither does the optimum.
//!
//! **Not taken.** Ranges and cones over blocks of a fixed length: such sets are not convex, and "the nearest point
//! inside" is not one.

mod active;
mod model;
mod programme;
mod refine;
mod rows;
mod start;
mod step;

use gravcal_estimation::{
    BlockId, Constraint, ConstraintKind, Estimate, Problem, SolveContext, SolveError, Solver, Unsupported, Values,
};
use serde::Deserialize;

use crate::damping::{Damping, damped_iteration};
use crate::run::check_start;
use crate::{Descent, LevenbergMarquardt, Move, Point, StoppingRules, minimise};
pub(crate) use active::active_constraints;
pub(crate) use programme::NAME;
pub(crate) use start::settle;
pub(crate) use step::{ConstrainedStep, Optimality};

/// Columns at most: JᵀJ is dense, and its factorization takes time with their cube.
const MAX_COLUMNS: usize = 2000;

/// The method with its options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Clarabel {
    /// When it ends. The cosine is that between the residual and a column of J, the constraints' part taken off.
    pub stopping: StoppingRules,
}

impl Solver for Clarabel {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        let refuse = |reason| Err(Unsupported { solver: NAME, reason });
        let columns = problem.columns().len();
        if columns > MAX_COLUMNS && !problem.constraints().is_empty() {
            return refuse(format!(
                "{columns} unknowns are more than {MAX_COLUMNS}: with constraints their Hessian is stored whole, and \
                 factored in time that grows with their cube"
            ));
        }
        match problem.constraints().iter().find_map(|c| not_convex(problem, c)) {
            Some(reason) => refuse(reason),
            None => Ok(()),
        }
    }

    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        self.check(problem)?;
        check_start(problem, initial)?;
        start::check(problem, initial)?;
        minimise(self, problem, initial, context)
    }

    fn judge(&self) -> Option<Box<dyn Solver>> {
        Some(Box::new(LevenbergMarquardt { stopping: self.stopping }))
    }
}

impl Descent for Clarabel {
    type Memory = Damping;

    fn stopping(&self) -> &StoppingRules {
        &self.stopping
    }

    fn iterate<'p>(&self, damping: &mut Damping, here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        damped_iteration(damping, here, &self.stopping)
    }
}

/// Why the set of values that obey a constraint together with the others is not convex, if it is not.
fn not_convex(problem: &Problem, constraint: &Constraint) -> Option<String> {
    let Constraint { name, kind } = constraint;
    let free = |id: &BlockId| !problem.columns_of(*id).is_empty();
    let curved = |id: &BlockId| free(id) && !problem.block(*id).is_euclidean();
    let manifold = |id: &BlockId| problem.block(*id).manifold().name();
    let of_length = |id: &BlockId, other: &Constraint| {
        matches!(other.kind, ConstraintKind::Length { block, .. } if block == *id) && other != constraint && free(id)
    };
    constraint.blocks().iter().find_map(|id| {
        let block = &problem.block(*id).name;
        match (kind, problem.constraints().iter().find(|other| of_length(id, other))) {
            (ConstraintKind::Length { .. }, _) if curved(id) => Some(format!(
                "`{name}` fixes the length of `{block}`, which is on a manifold ({}): drop one of the two",
                manifold(id)
            )),
            (ConstraintKind::Length { .. }, Some(other)) => {
                Some(format!("`{name}` and `{}` both fix the length of `{block}`: drop one of them", other.name))
            }
            (_, Some(_)) => Some(fixed_length(name, block)),
            _ if curved(id) => Some(format!(
                "`{name}` reads `{block}`, which is on a manifold ({}): what obeys both is not convex; drop the constraint, \
                 or let a residual measure what the manifold fixes",
                manifold(id)
            )),
            _ => None,
        }
    })
}

fn fixed_length(constraint: &str, block: &str) -> String {
    format!(
        "`{constraint}` reads `{block}`, whose length is fixed: what obeys both is not convex; drop the constraint, or let \
         the length be measured by a residual"
    )
}
