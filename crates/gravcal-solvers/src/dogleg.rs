//! Powell's dogleg in a trust region.
//!
//! Each iteration minimises the linear model of the residual within a radius Δ,
//!
//! ```text
//!     ½ ‖J p + r‖²,     ‖D p‖ ≤ Δ
//! ```
//!
//! along the path from the start over the minimum `p_U` along the steepest descent to the full step `p_B` (Nocedal and
//! Wright, *Numerical optimization*, 2nd edition, 2006, eq. 4.15, 4.16, in the coordinates D p):
//!
//! ```text
//!     p(τ) = τ p_U                        0 ≤ τ ≤ 1,        p_U = −(‖D⁻¹g‖² / ‖J D⁻²g‖²) D⁻²g
//!            p_U + (τ − 1)(p_B − p_U)     1 ≤ τ ≤ 2,        J p_B = −r in the sense of least squares
//! ```
//!
//! and lets Δ follow the ratio of actual to predicted reduction as in their algorithm 4.1: a quarter of the step where it
//! is below ¼, twice Δ where it is above ¾ and the step reached the boundary. Along the path both the length grows and the
//! model falls, so the step is its point at the boundary. A step is taken where the cost falls at all (η = 0). One
//! factorization serves every radius of an iteration.
//!
//! D and its update are Moré's (see Levenberg-Marquardt), and so is the first radius: `‖D x‖`, here without his factor of
//! 100, which lets the first step go anywhere. Where J has lost rank, `p_B` is the shortest such step
//! ([`Point::full_step`]).

use gravcal_estimation::{Estimate, Problem, SolveContext, SolveError, Solver, Termination, Unsupported, Values};
use serde::{Deserialize, Serialize};

use crate::point::dot;
use crate::refusal::refuse_constraints;
use crate::{Decision, Descent, LevenbergMarquardt, Move, Point, StoppingRules, VariableProjection, minimise};

pub(crate) const NAME: &str = "dogleg";

/// The method with its options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct Dogleg {
    /// When it ends.
    pub stopping: StoppingRules,
}

impl Solver for Dogleg {
    fn name(&self) -> &'static str {
        NAME
    }

    fn check(&self, problem: &Problem) -> Result<(), Unsupported> {
        refuse_constraints(NAME, problem)
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
        vec![
            Box::new(LevenbergMarquardt { stopping: self.stopping }),
            Box::new(VariableProjection { stopping: self.stopping }),
        ]
    }

    fn judge(&self) -> Option<Box<dyn Solver>> {
        Some(Box::new(LevenbergMarquardt { stopping: self.stopping }))
    }
}

/// Δ; none before the first iteration.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Radius(Option<f64>);

impl Descent for Dogleg {
    type Memory = Radius;

    fn stopping(&self) -> &StoppingRules {
        &self.stopping
    }

    fn iterate<'p>(&self, memory: &mut Radius, here: &mut Point<'p>) -> Result<Move<'p>, SolveError> {
        let path = DoglegPath::new(here);
        let radius = memory.0.get_or_insert_with(|| first_radius(here));
        loop {
            let (step, length) = path.within(*radius);
            let mut trial = here.attempt(&step, here.predicted(&step));
            match here.decide(&mut trial, 0.0, &self.stopping) {
                Decision::Accept(end) => {
                    if trial.ratio() < 0.25 {
                        *radius = 0.25 * length;
                    } else if trial.ratio() > 0.75 && length >= *radius {
                        *radius *= 2.0;
                    }
                    return Ok(Move::To { trial: Box::new(trial), damping: 0.0, end });
                }
                Decision::End(end) => return Ok(Move::Stay(end)),
                // A quarter of zero, of infinity or of what is no number is the same again.
                Decision::Shorten if !(length > 0.0 && length.is_finite()) => {
                    return Ok(Move::Stay(Termination::NoProgress));
                }
                Decision::Shorten => *radius = 0.25 * length,
            }
        }
    }
}

/// `‖D x‖`, or `‖r‖` for a start of zeros, which has no size.
fn first_radius(here: &Point<'_>) -> f64 {
    let size = here.size();
    if size > 0.0 { size } else { (2.0 * here.cost()).sqrt() }
}

/// The path of one point.
struct DoglegPath {
    scaling: Vec<f64>,
    /// p_U.
    cauchy: Vec<f64>,
    /// p_B.
    newton: Vec<f64>,
}

impl DoglegPath {
    fn new(here: &mut Point<'_>) -> Self {
        let gradient = here.linearization.gradient();
        let descent: Vec<f64> = gradient.iter().zip(&here.scaling).map(|(g, d)| -g / (d * d)).collect();
        let image = here.linearization.image_norm_squared(&descent);
        let share = if image > 0.0 { -dot(gradient, &descent) / image } else { 0.0 };
        let cauchy = descent.iter().map(|p| share * p).collect();
        let (newton, _) = here.full_step();
        DoglegPath { scaling: here.scaling.clone(), cauchy, newton }
    }

    /// The point of the path at the boundary, or its end where that is inside; and its length `‖D p‖`.
    fn within(&self, radius: f64) -> (Vec<f64>, f64) {
        let (cauchy, newton) = (self.length(&self.cauchy), self.length(&self.newton));
        if newton <= radius {
            return (self.newton.clone(), newton);
        }
        if cauchy >= radius {
            return (self.cauchy.iter().map(|p| radius / cauchy * p).collect(), radius);
        }
        let legs = self.cauchy.iter().zip(&self.newton);
        let second: Vec<f64> = legs.map(|(u, b)| b - u).collect();
        let share = self.share_of_second_leg(&second, radius);
        (self.cauchy.iter().zip(&second).map(|(u, leg)| u + share * leg).collect(), radius)
    }

    /// τ − 1 with `‖D (p_U + (τ − 1)(p_B − p_U))‖ = Δ`: the root of `a t² + 2 b t = c` between 0 and 1.
    fn share_of_second_leg(&self, second: &[f64], radius: f64) -> f64 {
        let product = |v: &[f64], w: &[f64]| -> f64 {
            self.scaling.iter().zip(v.iter().zip(w)).map(|(d, (v, w))| d * d * v * w).sum()
        };
        let (a, b) = (product(second, second), product(&self.cauchy, second));
        let c = radius * radius - product(&self.cauchy, &self.cauchy);
        c / (b + (b * b + a * c).sqrt())
    }

    fn length(&self, step: &[f64]) -> f64 {
        self.scaling.iter().zip(step).map(|(d, p)| (d * p).powi(2)).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Block;

    use super::*;
    use crate::testing::built;

    /// The squares of such values have no finite sum, nor have those of the full step of columns that are all but parallel; no step lowers the cost.
    #[test]
    fn a_radius_that_cannot_shrink_ends_the_method() {
        let (problem, start) =
            built(["a", "b"].map(|name| (Block::scalar(name, ""), vec![9e153])).to_vec(), 2, |_, r, j| {
                r.copy_from_slice(&[6e152, 1.2e153]);
                j.copy_from_slice(&[1.0, 1.0, 1.0, 1.0 + 1e-8]);
                Ok(())
            });
        let estimate = Dogleg::default().solve(&problem, &start, &mut SolveContext::default()).unwrap();
        assert!(!estimate.termination.converged(), "{}", estimate.termination);
    }

    fn path() -> DoglegPath {
        DoglegPath { scaling: vec![1.0, 2.0], cauchy: vec![1.0, 0.0], newton: vec![3.0, 2.0] }
    }

    #[test]
    fn the_path_goes_down_the_slope_and_then_to_the_full_step() {
        assert_eq!(path().within(0.5), (vec![0.5, 0.0], 0.5));
        assert_eq!(path().within(9.0), (vec![3.0, 2.0], 5.0));
        let (step, length) = path().within(3.0);
        assert!((path().length(&step) - 3.0).abs() < 1e-14 && length == 3.0);
        // On the second leg both coordinates have gone the same share of (2, 2).
        assert!((step[0] - 1.0 - step[1]).abs() < 1e-14 && step[1] > 0.0 && step[1] < 2.0);
    }
}
