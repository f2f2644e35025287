//! The fit of a problem: least squares with a reference prior that follows.
//!
//! The reference keeps what the readings do not determine near its nominal values, so that every fit is well posed. What they do
//! determine it pulls by next to nothing, and by nothing in the end: it is moved to where the fit ended, and the fit goes on, until
//! that gains nothing (the proximal point method: Rockafellar, *SIAM J. Control and Optimization* 14, 1976). A pull of κ limits leaves
//! of a bias a tenth a round where a standard deviation is as large as its limit, and less where it is smaller; along a direction
//! without information there is nothing to gain, and nothing moves. Gains that start many times too small need more rounds than that; what
//! the readings hardly say is left near its nominal value, as it would follow the noise to values at which they seem to say more.
//!
//! Why it is so, and what was tried: `docs/decisions/reference-prior.md`.

use gravcal_estimation::{Estimate, IterationRecord, Problem, SolveError, Termination, Values};

use crate::environment::SolveEnvironment;

/// Rounds in which the reference follows, at most; where more fits come, of better known noise, one.
pub const ROUNDS: usize = 5;
/// Iterations of the first fit, whose reference lies at nominal values, at most.
pub const FIRST_ITERATIONS: usize = 200;
/// A round that lowers ½ χ² by less is the last: the next would by a hundredth of it, 4e-4 standard deviations.
const WORTHWHILE: f64 = 1e-5;
/// After the last round others follow while one lowers ½ χ² by more than this, two standard deviations; so many at most, with a reference so
/// many times as firm as before.
const SUPPORTED: f64 = 2.0;
const FURTHER_ROUNDS: usize = 10;
const SOFTER: f64 = 0.3;

/// A problem, solved.
#[derive(Debug)]
pub struct Fit {
    /// The problem with its reference where the fit ended.
    pub problem: Problem,
    /// Its end. The cost is that of readings and knowledge alone.
    pub estimate: Estimate,
}

impl Fit {
    /// A fit that ended here, with the cost of the problem's reference still in that of the estimate.
    #[must_use]
    pub fn ended(problem: Problem, mut estimate: Estimate) -> Fit {
        let Some(reference) = problem.reference().cloned() else { return Fit { problem, estimate } };
        estimate.cost -= reference.cost(&problem, &estimate.values);
        let problem = problem.with_reference(reference.centered_at(&estimate.values));
        Fit { problem, estimate }
    }

    /// Goes on in so many rounds at most, each with the reference where the one before ended. `readings`: how many rows there are whose
    /// noise is about one where the model is right.
    #[must_use]
    pub fn followed(self, readings: usize, rounds: usize, environment: &SolveEnvironment<'_>) -> Fit {
        let Fit { mut problem, mut estimate } = self;
        let Some(reference) = problem.reference().cloned() else { return Fit { problem, estimate } };
        let (mut round, mut firmness, worthwhile) = (0, 1.0, environment.enough().max(WORTHWHILE));
        loop {
            let around = reference.times_as_firm(firmness).centered_at(&estimate.values);
            problem = problem.with_reference(around.clone());
            let given_up = match estimate.termination {
                Termination::Stopped => true,
                Termination::IterationLimit { limit } => limit < FIRST_ITERATIONS, // the solver's own, or hopeless
                _ => false,
            };
            if given_up {
                break;
            }
            // A start that rounding has put outside of a constraint, say, ends the rounds, and not the fit.
            let Ok(mut next) = environment.solve(&problem, &estimate.values) else { break };
            next.cost -= around.cost(&problem, &next.values);
            let gained = estimate.cost - next.cost;
            let (before, after) = (estimate.termination.converged(), next.termination.converged());
            if gained < 0.0 || before && !after {
                break;
            }
            let noise = (2.0 * next.cost / readings.max(1) as f64).max(1.0);
            estimate = behind(estimate, next);
            round += 1;
            let goes_on = match round < rounds {
                true => !after || gained >= worthwhile * noise,
                false => after && gained >= SUPPORTED * noise && round < rounds + FURTHER_ROUNDS,
            };
            if !goes_on {
                break;
            }
            if round >= rounds {
                firmness *= SOFTER;
            }
        }
        problem = problem.with_reference(reference.centered_at(&estimate.values));
        Fit { problem, estimate }
    }
}

/// Minimises what readings and knowledge cost, in [`ROUNDS`]. `readings`: rows whose noise is about one where the model is right.
///
/// # Errors
/// Where the first fit has no answer at all; not converging is a [`Termination`].
pub fn fit(
    problem: &Problem,
    start: &Values,
    readings: usize,
    environment: &SolveEnvironment<'_>,
) -> Result<Fit, SolveError> {
    // Far from nominal values the way is long as long as these pull: it goes on without them.
    let first = environment.within(FIRST_ITERATIONS).solve(problem, start)?;
    Ok(Fit::ended(problem.clone(), first).followed(readings, ROUNDS, environment))
}

/// One estimate behind the other, which began where the first one ended.
fn behind(before: Estimate, after: Estimate) -> Estimate {
    let mut iterations = before.iterations;
    for record in after.iterations.into_iter().skip(1) {
        iterations.push(IterationRecord { iteration: iterations.len(), ..record });
    }
    let iterates = before.iterates.into_iter().chain(after.iterates.into_iter().skip(1)).collect();
    Estimate { iterations, iterates, ..after }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{Loss, Reference};

    use super::*;
    use crate::testing::{line, sensor, with_environment};

    #[test]
    fn a_reference_leaves_what_is_determined_and_keeps_what_is_not() {
        let readings = [(0.0, 1.2, 0.5), (1.0, 2.7, 0.5), (2.0, 5.3, 0.5), (3.0, 6.9, 0.5)];
        let (problem, start, [gain, offset, bias]) = sensor(&readings, [1.0, 0.0, 0.0], &[], Loss::None);
        let reference = Reference::new(start.clone()).with(gain, &[1.0]).with(offset, &[1.0]).with(bias, &[1.0]);
        let problem = problem.with_reference(reference);
        let Fit { problem, estimate } = with_environment(|w| fit(&problem, &start, readings.len(), w)).unwrap();
        let [k, o, b] = [gain, offset, bias].map(|id| estimate.values.scalar(id));
        let (intercept, slope, _) = line(&readings);
        // The pull leaves less than a hundredth of a standard deviation, and is not in the cost.
        assert!((k - slope).abs() < 0.002 && (k * o + b - intercept).abs() < 0.005, "{k} {o} {b}");
        let squares: f64 = readings.iter().map(|(x, y, std)| ((slope * x + intercept - y) / std).powi(2)).sum();
        assert!((estimate.cost - 0.5 * squares).abs() < 1e-4, "{} {squares}", estimate.cost);
        // Offset and bias, which only their sum is known of, share it as their widths say: nobody walks away along the rest.
        assert!(o.abs() < 1.0 && b.abs() < 1.0, "{o} {b}");
        let pull = problem.reference().unwrap().cost(&problem, &estimate.values);
        assert_eq!(pull, 0.0, "the reference lies where the fit ended");
    }

    #[test]
    fn a_problem_without_a_reference_is_solved_once() {
        let readings = [(0.0, 1.0, 0.1), (1.0, 3.0, 0.1), (2.0, 5.0, 0.1)];
        let (problem, start, [gain, ..]) = sensor(&readings, [1.0, 0.0, 0.0], &[1], Loss::None);
        let Fit { estimate, .. } = with_environment(|w| fit(&problem, &start, readings.len(), w)).unwrap();
        assert!(estimate.termination.converged() && (estimate.values.scalar(gain) - 2.0).abs() < 1e-6);
    }
}
