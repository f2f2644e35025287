//! The 35 problems of Moré, Garbow and Hillstrom.
//!
//! *Testing Unconstrained Optimization Software*, ACM Transactions on Mathematical Software 7 (1981), pages 17 to 41,
//! section 3. Minima are quoted with the six digits that are printed: from the paper; those of Chebyquad with 8 rows and
//! 1 parameter from MINPACK's own test runs (Moré, Garbow and Hillstrom, *User Guide for MINPACK-1*, 1980, files 17 and
//! 22 of its examples); the second ones of Jennrich-Sampson and Biggs EXP6 from Kuntsevich and Kappel, *Moré set of test
//! functions* (SolvOpt, 1997), and gonum's `optimize/functions`. Starts are the paper's standard one, 10 times and 100
//! times it; where that is zero, all tens and all hundreds, as in MINPACK's runs. Where no published minimum is to be
//! expected from a start, that is said, and MINPACK reaches none from there either.

mod fits;
mod function;
mod scalable;
mod small;

pub(super) use function::Function;

use super::{Equations, Minimum, PublishedProblem, Start};

/// All problems, those of any number of parameters in the sizes that have published minima.
pub fn more_garbow_hillstrom() -> Vec<PublishedProblem> {
    let mut problems = fixed();
    problems.extend(of_any_size());
    problems
}

fn fixed() -> Vec<PublishedProblem> {
    use Function::*;
    vec![
        problem(Rosenbrock, "Rosenbrock", 2, vec![-1.2, 1.0]).minimum_of(0.0, &[1.0, 1.0]),
        problem(FreudensteinRoth, "Freudenstein-Roth", 2, vec![0.5, -2.0])
            .minimum_of(0.0, &[5.0, 4.0])
            .minimum(48.9842),
        problem(PowellBadlyScaled, "Powell badly scaled", 2, vec![0.0, 1.0])
            .minimum(0.0)
            .unreachable(TEN, "a curved valley, x1 x2 = 1e-4, along which MINPACK, too, creeps until it gives up")
            .unreachable(HUNDRED, "exp(−100): the second parameter has next to no effect"),
        problem(BrownBadlyScaled, "Brown badly scaled", 3, vec![1.0, 1.0]).minimum_of(0.0, &[1e6, 2e-6]),
        problem(Beale, "Beale", 3, vec![1.0, 1.0])
            .minimum_of(0.0, &[3.0, 0.5])
            .unreachable(TEN, INFINITE_BEALE)
            .unreachable(HUNDRED, INFINITE_BEALE),
        problem(JennrichSampson, "Jennrich-Sampson", 10, vec![0.3, 0.4])
            .minimum(124.362)
            .minimum(259.580)
            .unreachable(HUNDRED, "the sum of squares overflows"),
        problem(HelicalValley, "helical valley", 3, vec![-1.0, 0.0, 0.0]).minimum_of(0.0, &[1.0, 0.0, 0.0]),
        problem(Bard, "Bard", 15, vec![1.0; 3]).minimum(8.21487e-3).minimum(17.4286),
        problem(Gaussian, "Gaussian", 15, vec![0.4, 1.0, 0.0]).minimum(1.12793e-8),
        problem(Meyer, "Meyer", 16, vec![0.02, 4000.0, 250.0]).minimum(87.9458),
        problem(Gulf, "Gulf research", 99, vec![5.0, 2.5, 0.15])
            .minimum_of(0.0, &[50.0, 25.0, 1.5])
            .unreachable(HUNDRED, "every derivative underflows to zero"),
        problem(Box3, "Box three-dimensional", 10, vec![0.0, 10.0, 20.0])
            .minimum_of(0.0, &[1.0, 10.0, 1.0])
            .unreachable(TEN, INFINITE_BOX)
            .unreachable(HUNDRED, INFINITE_BOX),
        problem(PowellSingular, "Powell singular", 4, vec![3.0, -1.0, 0.0, 1.0]).minimum_of(0.0, &[0.0; 4]),
        problem(Wood, "Wood", 6, vec![-3.0, -1.0, -3.0, -1.0]).minimum_of(0.0, &[1.0; 4]),
        problem(KowalikOsborne, "Kowalik-Osborne", 11, vec![0.25, 0.39, 0.415, 0.39])
            .minimum(3.07505e-4)
            .minimum(1.02734e-3),
        problem(BrownDennis, "Brown-Dennis", 20, vec![25.0, 5.0, -5.0, -1.0]).minimum(85822.2),
        problem(Osborne1, "Osborne 1", 33, vec![0.5, 1.5, -1.0, 0.01, 0.02]).minimum(5.46489e-5),
        problem(BiggsExp6, "Biggs EXP6", 13, vec![1.0, 2.0, 1.0, 1.0, 1.0, 1.0])
            .minimum_of(0.0, &[1.0, 10.0, 1.0, 5.0, 4.0, 3.0])
            .minimum(5.65565e-3)
            .minimum(0.306367),
        problem(Osborne2, "Osborne 2", 65, vec![1.3, 0.65, 0.65, 0.7, 0.6, 3.0, 5.0, 7.0, 2.0, 4.5, 5.5])
            .minimum(4.01377e-2)
            .unreachable(TEN, LOCAL_OSBORNE)
            .unreachable(HUNDRED, LOCAL_OSBORNE),
    ]
}

fn of_any_size() -> Vec<PublishedProblem> {
    use Function::*;
    let steps = |n: usize| (1..=n).map(move |j| j as f64 / (n + 1) as f64);
    let repeated = |block: &[f64], times: usize| block.repeat(times);
    let grid = |n: usize| steps(n).map(|t| t * (t - 1.0)).collect();
    vec![
        problem(Watson, "Watson, 6", 31, vec![0.0; 6]).minimum(2.28767e-3),
        problem(Watson, "Watson, 9", 31, vec![0.0; 9]).minimum(1.39976e-6),
        problem(Watson, "Watson, 12", 31, vec![0.0; 12]).minimum(4.72238e-10),
        problem(ExtendedRosenbrock, "extended Rosenbrock, 10", 10, repeated(&[-1.2, 1.0], 5))
            .minimum_of(0.0, &[1.0; 10]),
        problem(ExtendedPowellSingular, "extended Powell singular, 12", 12, repeated(&[3.0, -1.0, 0.0, 1.0], 3))
            .minimum_of(0.0, &[0.0; 12]),
        problem(Penalty1, "penalty I, 4", 5, vec![1.0, 2.0, 3.0, 4.0]).minimum(2.24997e-5),
        problem(Penalty1, "penalty I, 10", 11, (1..=10).map(f64::from).collect()).minimum(7.08765e-5),
        problem(Penalty2, "penalty II, 4", 8, vec![0.5; 4]).minimum(9.37629e-6),
        problem(Penalty2, "penalty II, 10", 20, vec![0.5; 10]).minimum(2.93660e-4),
        problem(
            VariablyDimensioned,
            "variably dimensioned, 10",
            12,
            (1..=10).map(|j| 1.0 - 0.1 * f64::from(j)).collect(),
        )
        .minimum_of(0.0, &[1.0; 10]),
        problem(Trigonometric, "trigonometric, 10", 10, vec![0.1; 10]).minimum(0.0).minimum(2.79506e-5),
        problem(BrownAlmostLinear, "Brown almost-linear, 10", 10, vec![0.5; 10])
            .minimum_of(0.0, &[1.0; 10])
            .minimum(1.0),
        problem(BrownAlmostLinear, "Brown almost-linear, 30", 30, vec![0.5; 30])
            .minimum_of(0.0, &[1.0; 30])
            .minimum(1.0),
        problem(BrownAlmostLinear, "Brown almost-linear, 40", 40, vec![0.5; 40])
            .minimum_of(0.0, &[1.0; 40])
            .minimum(1.0),
        problem(DiscreteBoundaryValue, "discrete boundary value, 10", 10, grid(10)).minimum(0.0),
        problem(DiscreteIntegralEquation, "discrete integral equation, 10", 10, grid(10)).minimum(0.0),
        problem(BroydenTridiagonal, "Broyden tridiagonal, 10", 10, vec![-1.0; 10]).minimum(0.0),
        problem(BroydenBanded, "Broyden banded, 10", 10, vec![-1.0; 10]).minimum(0.0),
        problem(LinearFullRank, "linear, full rank, 10 × 5", 10, vec![1.0; 5]).minimum_of(5.0, &[-1.0; 5]),
        problem(LinearFullRank, "linear, full rank, 50 × 5", 50, vec![1.0; 5]).minimum_of(45.0, &[-1.0; 5]),
        problem(LinearRankOne, "linear, rank 1, 10 × 5", 10, vec![1.0; 5]).minimum(15.0 / 7.0),
        problem(LinearRankOne, "linear, rank 1, 50 × 5", 50, vec![1.0; 5]).minimum(1225.0 / 101.0),
        problem(LinearRankOneWithZeros, "linear, rank 1 with zeros, 10 × 5", 10, vec![1.0; 5]).minimum(62.0 / 17.0),
        problem(LinearRankOneWithZeros, "linear, rank 1 with zeros, 50 × 5", 50, vec![1.0; 5]).minimum(1322.0 / 97.0),
        problem(Chebyquad, "Chebyquad, 8 × 1", 8, steps(1).collect()).minimum(3.55789).minimum(3.55039),
        problem(Chebyquad, "Chebyquad, 8 × 8", 8, steps(8).collect())
            .minimum(3.51687e-3)
            .unreachable(TEN, OUTSIDE)
            .unreachable(HUNDRED, OUTSIDE),
        problem(Chebyquad, "Chebyquad, 9 × 9", 9, steps(9).collect())
            .minimum(0.0)
            .unreachable(TEN, OUTSIDE)
            .unreachable(HUNDRED, OUTSIDE),
        problem(Chebyquad, "Chebyquad, 10 × 10", 10, steps(10).collect())
            .minimum(6.50395e-3)
            .unreachable(TEN, OUTSIDE)
            .unreachable(HUNDRED, OUTSIDE),
    ]
}

/// Positions of the far starts.
const TEN: usize = 1;
const HUNDRED: usize = 2;

const INFINITE_BEALE: &str = "a valley to infinity, x1 (1 − x2) constant, along which Σ r² falls towards 0.452009";
const INFINITE_BOX: &str = "exp(−0.1 x2) vanishes: the way down leads to infinity, where Σ r² is 0.0755887";
const LOCAL_OSBORNE: &str = "the way down leads to a local minimum that is in no list, Σ r² = 1.78981";
const OUTSIDE: &str = "polynomials of high degree far outside of their interval: Σ r² from 1e22 on";

/// A problem of the collection, still without its minima.
fn problem(function: Function, name: &str, rows: usize, standard: Vec<f64>) -> PublishedProblem {
    let starts = [("standard", 1.0), ("10 ×", 10.0), ("100 ×", 100.0)];
    PublishedProblem {
        name: name.to_owned(),
        source: format!("Moré, Garbow and Hillstrom (1981), problem {}", function as usize),
        parameters: (1..=standard.len()).map(|k| format!("x{k}")).collect(),
        linear: Vec::new(),
        rows,
        starts: starts.into_iter().map(|(name, factor)| start(name, factor, &standard)).collect(),
        minima: Vec::new(),
        equations: Equations::MoreGarbowHillstrom(function),
    }
}

fn start(name: &str, factor: f64, standard: &[f64]) -> Start {
    let zero = standard.iter().all(|v| *v == 0.0);
    let far = |v: &f64| if zero && factor > 1.0 { factor } else { factor * v };
    Start { name: name.to_owned(), values: standard.iter().map(far).collect(), unreachable: None }
}

impl PublishedProblem {
    fn minimum(mut self, sum_of_squares: f64) -> Self {
        self.minima.push(Minimum { sum_of_squares, parameters: None });
        self
    }

    fn unreachable(mut self, start: usize, reason: &'static str) -> Self {
        self.starts[start].unreachable = Some(reason);
        self
    }

    fn minimum_of(mut self, sum_of_squares: f64, parameters: &[f64]) -> Self {
        self.minima.push(Minimum { sum_of_squares, parameters: Some(parameters.to_vec()) });
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_derivatives;

    #[test]
    fn all_35_are_there_with_three_starts_and_a_minimum() {
        let problems = more_garbow_hillstrom();
        for number in 1..=35 {
            let source = format!("Moré, Garbow and Hillstrom (1981), problem {number}");
            assert!(problems.iter().any(|p| p.source == source), "{source}");
        }
        assert!(problems.iter().all(|p| p.starts.len() == 3 && !p.minima.is_empty()));
    }

    #[test]
    fn the_published_parameters_give_the_published_minima() {
        let mut compared = 0;
        for problem in more_garbow_hillstrom() {
            for minimum in &problem.minima {
                let Some(parameters) = &minimum.parameters else { continue };
                let at = Start { name: "minimum".into(), values: parameters.clone(), unreachable: None };
                let (built, values) = problem.build(&at).unwrap();
                let found = 2.0 * built.cost(&values).unwrap();
                assert_eq!(problem.minimum_at(found), Some(minimum), "{}: {found:e}", problem.name);
                compared += 1;
            }
        }
        assert!(compared >= 18);
    }

    #[test]
    fn rows_are_differentiable_at_the_standard_starts() {
        for problem in more_garbow_hillstrom() {
            let (built, start) = problem.build(&problem.starts[0]).unwrap();
            let lengths = vec![1; start.as_slice().len()];
            let residual = &*built.factors()[0].residual;
            // Differences are no better where a thousandth is a large step (Osborne 1).
            check_derivatives(residual, &lengths, start.as_slice(), 1e-4)
                .unwrap_or_else(|e| panic!("{}: {e}", problem.name));
        }
    }

    #[test]
    fn a_point_nobody_publishes_is_no_minimum() {
        let rosenbrock = &more_garbow_hillstrom()[0];
        assert!(rosenbrock.minimum_at(24.2).is_none());
        assert!(rosenbrock.minimum_at(f64::NAN).is_none());
    }
}
