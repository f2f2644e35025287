//! Variable projection: for problems in which some blocks enter linearly.
//!
//! With nonlinear blocks `a` and linear blocks `c` the residual is `r(a, c) = Φ(a) c + y(a)`. At given `a` the best
//! `c*(a)` is a linear least-squares problem, and what is left to minimise is
//!
//! ```text
//!     ½ ‖r(a, c*(a))‖²
//! ```
//!
//! over `a` alone: no start is needed for `c`, and the way is shorter (Golub and Pereyra, *SIAM J. Numer. Anal.* 10, 1973,
//! eq. 1.4). Its Jacobian is taken without the derivative of the projection's inverse (Kaufman, *BIT* 15, 1975). The step
//! with it is that of the full problem with no damping on the linear columns (Ruhe and Wedin, *SIAM Review* 22, 1980,
//! algorithm 2), so each iteration solves
//!
//! ```text
//!     min over δ_a, δ_c   ½ ‖J_a δ_a + Φ δ_c + r‖² + ½ λ ‖D δ_a‖²
//! ```
//!
//! throws δ_c away, and puts `c` to its optimum at `a ⊞ δ_a`. λ follows Nielsen (`damping.rs`), as in Levenberg-Marquardt, but is
//! raised until no nonlinear block moves by more than half of its size: with `c` free to follow, a leap makes two exponentials
//! one and still lowers the cost (NIST's Lanczos from its far start), and there is no way back.
//!
//! The start has `c` at its optimum, too; where every block is linear that is all.
//!
//! **What it is for**: few nonlinear blocks, and linear ones of which nobody has a start. Where there is one for all blocks it is not: `c` at
//! its optimum for rough `a` may lie at another minimum than the one that is near, and an iteration takes several times as long as one of
//! Levenberg-Marquardt, as the linear part is linearized by itself, and freed of damping, which only an orthogonal factorization bears where the
//! data leave something of it open (`benches/README.md`, Speed).
//!
//! Which blocks are linear the problem says ([`Block::linear`](gravcal_estimation::Block::linear)). That is held against the
//! residuals in every linear solve: the cost found must be the cost foretold. Combinations of `c` that the data do not
//! determine stay where they are. Robust losses are refused: with them the linear problem is none.

use gravcal_estimation::{Estimate, Loss, Problem, SolveContext, SolveError, Solver, Termination, Unsupported, Values};
use serde::{Deserialize, Serialize};

use crate::damping::Damping;
use crate::linear_part::{LinearPart, is_linear};
use crate::point::FAINT_DAMPING;
use crate::refusal::refuse_constraints;
use crate::run::check_start;
use crate::{Decision, Descent, Dogleg, LevenbergMarquardt, Move, Point, StoppingRules, minimise};

/// The most by which a nonlinear block moves at once, relative to its size or to the residual, whichever is larger.
const LONGEST_STEP: f64 = 0.5;

pub(crate) const NAME: &str = "variable-projection";

/// The method with its options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct VariableProjection {
    /// When it ends.
    pub stopping: StoppingRules,
}

impl Solver for VariableProjection {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        refuse_constraints(NAME, problem)?;
        match fault(problem) {
            Some(reason) => Err(Unsupported { solver: NAME, reason }),
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
        let projected = LinearPart::new(problem).optimum(initial.clone(), NAME)?;
        minimise(self, problem, projected.as_ref().unwrap_or(initial), context)
    }

    fn companions(&self) -> Vec<Box<dyn Solver>> {
        vec![Box::new(Dogleg { stopping: self.stopping }), Box::new(LevenbergMarquardt { stopping: self.stopping })]
    }

    fn judge(&self) -> Option<Box<dyn Solver>> {
        Some(Box::new(LevenbergMarquardt { stopping: self.stopping }))
    }
}

/// Why there is no linear part to project on, if there is none.
fn fault(problem: &Problem) -> Option<String> {
    let mut linear = problem.block_ids().filter(|id| is_linear(problem, *id)).map(|id| problem.block(id)).peekable();
    if linear.peek().is_none() {
        return Some("no free block is marked as linear: levenberg-marquardt needs no such mark".into());
    }
    if let Some(block) = linear.find(|block| !block.is_euclidean()) {
        let manifold = block.manifold().name();
        return Some(format!("`{}` is marked as linear, but lives on a curved manifold ({manifold})", block.name));
    }
    let robust = problem.factors().iter().any(|factor| factor.loss != Loss::None);
    robust.then(|| "it has robust losses, so that no block is linear: levenberg-marquardt can take them".into())
}

/// What the method remembers.
#[derive(Serialize, Deserialize)]
pub struct Memory {
    damping: Damping,
    /// Made of the problem when it is first needed.
    #[serde(skip)]
    linear: Option<LinearPart>,
}

impl Default for Memory {
    // Less damping at the start (1e-6) leads it past certified values of NIST (`tests/nist.rs`).
    fn default() -> Self {
        Memory { damping: Damping::from_afar(), linear: None }
    }
}

impl Descent for VariableProjection {
    type Memory = Memory;

    fn stopping(&self) -> &StoppingRules {
        &self.stopping
    }

    fn iterate<'p>(&self, memory: &mut Memory, here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        let linear = memory.linear.get_or_insert_with(|| LinearPart::new(here.problem));
        if linear.is_all_of(here.problem) {
            self.project(linear, here)
        } else {
            self.step(&mut memory.damping, linear, here)
        }
    }
}

impl VariableProjection {
    /// Puts the linear blocks to their optimum once more: rounding may have left something.
    fn project<'p>(&self, linear: &LinearPart, here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        let mut step = vec![0.0; here.scaling.len()];
        let there = linear.follow(here, &mut step, NAME)?;
        let mut trial = here.attempt_at(there, &step, here.predicted(&step));
        Ok(match here.decide(&mut trial, 0.0, &self.stopping) {
            Decision::Accept(end) => Move::To { trial: Box::new(trial), damping: 0.0, end },
            Decision::End(end) => Move::Stay(end),
            Decision::Shorten if here.at_model_minimum() => Move::Stay(Termination::Step { relative: trial.length }),
            Decision::Shorten => Move::Stay(Termination::NoProgress),
        })
    }

    /// Moves the nonlinear blocks, with growing damping until the cost falls, and the linear ones after them.
    fn step<'p>(
        &self,
        damping: &mut Damping,
        linear: &LinearPart,
        here: &mut Point<'p>,
    ) -> Result<Move<'p>, SolveError> {
        loop {
            let lambda = damping.lambda();
            let scaling = scaling(linear, here, lambda);
            let mut step = vec![0.0; scaling.len()];
            let info = here.linearization.damped_step(lambda, &scaling, &mut step);
            linear.columns().for_each(|column| step[column] = 0.0);
            if here.relative_length(&step) > LONGEST_STEP && damping.raise() {
                continue;
            }
            let there = linear.follow(here, &mut step, NAME)?;
            let mut trial = here.attempt_at(there, &step, info.predicted_reduction);
            match here.decide(&mut trial, 0.0, &self.stopping) {
                Decision::Accept(end) => {
                    damping.accept(trial.ratio());
                    return Ok(Move::To { trial: Box::new(trial), damping: lambda, end });
                }
                Decision::End(end) => return Ok(Move::Stay(end)),
                Decision::Shorten if damping.reject() => {}
                Decision::Shorten => return Ok(Move::Stay(Termination::NoProgress)),
            }
        }
    }
}

/// D for the nonlinear columns; for the linear ones what makes of λ next to no damping.
fn scaling(linear: &LinearPart, here: &Point<'_>, lambda: f64) -> Vec<f64> {
    let scales = here.linearization.column_scales();
    let faint = (FAINT_DAMPING / lambda).sqrt();
    let mut scaling = here.scaling.clone();
    linear.columns().for_each(|column| scaling[column] = faint * scales[column]);
    scaling
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{Block, EvaluateError, Factor, Sphere};

    use super::*;
    use crate::LevenbergMarquardt;
    use crate::testing::{DECAY_ROWS, builder, built, decay, far_decay, linear, scalar};

    fn solve(solver: &dyn Solver, (problem, initial): &(Problem, Values)) -> Estimate {
        solver.solve(problem, initial, &mut SolveContext::default()).unwrap()
    }

    fn refusal((problem, initial): &(Problem, Values)) -> String {
        let solved = VariableProjection::default().solve(problem, initial, &mut SolveContext::default());
        solved.unwrap_err().to_string()
    }

    #[test]
    fn linear_blocks_need_no_start_and_the_way_is_shorter() {
        let found = solve(&VariableProjection::default(), &far_decay());
        let damped = solve(&LevenbergMarquardt::default(), &far_decay());
        assert!(found.termination.converged() && (found.cost / damped.cost - 1.0).abs() < 1e-12);
        let (short, long) = (found.iterations.len() - 1, damped.iterations.len() - 1);
        assert!(short < long, "{short} iterations, {long} by levenberg-marquardt");

        let elsewhere = vec![scalar("rate", 2.0), linear("amplitude", 1e6), linear("level", -1e5)];
        let same = solve(&VariableProjection::default(), &built(elsewhere, DECAY_ROWS, decay));
        assert_eq!(same.iterations.len(), found.iterations.len());
        assert!(same.values.as_slice().iter().zip(found.values.as_slice()).all(|(a, b)| (a / b - 1.0).abs() < 1e-9));
    }

    /// `a t + c` at t = 0, 1, 2, 3 through 1, 3, 5, 8: a = 2.3, c = 0.8, Σ r² = 0.3.
    fn line(x: &[f64], r: &mut [f64], j: &mut [f64]) -> Result<(), EvaluateError> {
        for (i, y) in [1.0, 3.0, 5.0, 8.0].into_iter().enumerate() {
            r[i] = x[0] * i as f64 + x[1] - y;
            j[2 * i..2 * i + 2].copy_from_slice(&[i as f64, 1.0]);
        }
        Ok(())
    }

    #[test]
    fn a_linear_problem_is_solved_at_its_start() {
        let found = solve(&VariableProjection::default(), &built(vec![linear("a", 9.0), linear("c", -7.0)], 4, line));
        assert!(found.termination.converged() && (2.0 * found.iterations[0].cost - 0.3).abs() < 1e-12);
        assert!(found.values.as_slice().iter().zip([2.3, 0.8]).all(|(found, true_)| (found - true_).abs() < 1e-10));
    }

    #[test]
    fn combinations_without_effect_stay_where_they_are() {
        let twice = |x: &[f64], r: &mut [f64], j: &mut [f64]| {
            let shape = x[0].exp();
            r.copy_from_slice(&[shape * (x[1] + x[2]) - 2.0, 2.0 * (x[1] + x[2]) - 2.0, shape - 1.1]);
            j.copy_from_slice(&[shape * (x[1] + x[2]), shape, shape, 0.0, 2.0, 2.0, shape, 0.0, 0.0]);
            Ok(())
        };
        let found = solve(
            &VariableProjection::default(),
            &built(vec![scalar("s", 0.5), linear("a", 5.0), linear("b", 1.0)], 3, twice),
        );
        let values = found.values.as_slice();
        assert!(found.termination.converged() && (values[1] - values[2] - 4.0).abs() < 1e-9, "{values:?}");
    }

    #[test]
    fn what_has_no_linear_part_is_refused_in_words() {
        let unmarked = built(vec![scalar("a", 9.0), scalar("c", -7.0)], 4, line);
        assert!(
            refusal(&unmarked).ends_with("no free block is marked as linear: levenberg-marquardt needs no such mark")
        );
        let (held, start) = linear("a", 9.0);
        let held = built(vec![(held.fixed("known"), start), scalar("c", -7.0)], 4, line);
        assert!(refusal(&held).contains("no free block is marked as linear"));

        let on_sphere = Block::vector("g", "", &["x", "y", "z"]).on(Sphere { radius: 1.0 }).linear();
        let curved = built(vec![(on_sphere, vec![0.0, 0.0, 1.0])], 1, |x, r, j| {
            r[0] = x[0] - 1.0;
            j[0] = 1.0;
            Ok(())
        });
        assert!(refusal(&curved).contains("`g` is marked as linear, but lives on a curved manifold (sphere)"));
    }

    #[test]
    fn robust_losses_are_refused() {
        let (builder, _) = builder(vec![linear("a", 9.0), linear("c", -7.0)], 4, line);
        let (problem, initial) = builder.build().unwrap();
        let mut robust = gravcal_estimation::ProblemBuilder::new();
        problem.blocks().iter().zip(initial.as_slice()).for_each(|(block, value)| {
            robust.add_block(block.clone(), &[*value]);
        });
        let factor: Factor = problem.factors()[0].clone();
        robust.add_factor(factor.with_loss(Loss::Huber(1.5)));
        assert!(refusal(&robust.build().unwrap()).contains("it has robust losses"));
    }

    #[test]
    fn a_block_that_is_not_linear_is_named() {
        // All of the decay marked: the rate is none, whatever stands before or after it.
        let marked = [("rate", 3.0), ("amplitude", -20.0), ("level", 50.0)].map(|(name, start)| linear(name, start));
        let reported = refusal(&built(marked.to_vec(), DECAY_ROWS, decay));
        assert!(
            reported.contains("the residuals are not affine in `rate`, which is marked as linear: remove the mark")
        );

        // Each linear alone, but not together.
        let product = |x: &[f64], r: &mut [f64], j: &mut [f64]| {
            r.copy_from_slice(&[x[0] * x[1] - 6.0, x[0] - 1.0, x[1] - 1.0]);
            j.copy_from_slice(&[x[1], x[0], 1.0, 0.0, 0.0, 1.0]);
            Ok(())
        };
        let reported = refusal(&built(vec![linear("a", 2.0), linear("b", 7.0)], 3, product));
        assert!(reported.contains("not affine in `b`"), "{reported}");
    }
}
