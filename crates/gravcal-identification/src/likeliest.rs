//! Ends of several starts, compared by their likelihood.
//!
//! ```text
//!     − ln L = ½ χ² + Σ ln σ_i      over the readings, but for what all ends share
//! ```
//!
//! A minimum may be a local one, and noise that was found at a minimum excuses it; so ends are compared with the noise that each of them
//! found. An end that is likelier ([`LIKELIER`]), or converged where the other did not, takes the other's place; what ends elsewhere and is as
//! plausible is kept, as it may be the true one.
//!
//! Why it is so, and what was tried: `docs/decisions/starts-compared.md`.

use gravcal_estimation::{Termination, Values, in_parallel};

use crate::environment::SolveEnvironment;
use crate::fit::FIRST_ITERATIONS;
use crate::nearby::IMPLAUSIBLE;

/// − ln of the likelihood by which one of two must exceed the other to be ruled out: it is then less likely by e¹⁰.
pub const DECISIVE: f64 = 10.0;

/// − ln of the likelihood by which an end must exceed another to take its place: methods that end at one place differ by less.
const LIKELIER: f64 = 0.5;

/// By how much likelier, in − ln L, an end that was followed roughly may be at its last digit.
pub const UNSETTLED: f64 = 0.5;

/// Unknowns of one end are the same to this share, of 1 or of their size.
const SAME: f64 = 1e-5;

/// Where a start led.
#[derive(Clone, Debug)]
pub struct End<S, Start> {
    /// All of it.
    pub solution: S,
    /// Where it is, and how likely.
    pub place: Place<Start>,
    /// Why the solver ended: whether it is a minimum.
    pub termination: Termination,
}

/// Where an end is, and how likely.
#[derive(Clone, Debug)]
pub struct Place<Start> {
    /// `− ln L` of the readings there.
    pub minus_log_likelihood: f64,
    /// The unknowns of the problem that was solved. Another start may have found other unknowns: only those of one problem compare.
    pub values: Values,
    /// What starts a solve there.
    pub start: Start,
}

/// The likeliest end so far.
#[derive(Debug)]
pub struct Likeliest<S, Start> {
    /// The end.
    pub best: End<S, Start>,
    /// Whether it is another than the first.
    pub is_another: bool,
    /// Where all other starts led that converged.
    pub others: Vec<Place<Start>>,
}

impl<S: Send + Sync, Start: Clone + Send + Sync> Likeliest<S, Start> {
    /// The first.
    pub fn first(end: End<S, Start>) -> Likeliest<S, Start> {
        Likeliest { best: end, is_another: false, others: Vec::new() }
    }

    /// The best, and all others that are not implausible beside it, each once.
    pub fn plausible(&self) -> Vec<&Start> {
        let least = self.best.place.minus_log_likelihood;
        let others = self.others.iter().filter(|place| place.minus_log_likelihood < least + IMPLAUSIBLE);
        let mut apart: Vec<&Place<Start>> = Vec::new();
        for place in std::iter::once(&self.best.place).chain(others) {
            if !apart.iter().any(|other| are_same(&other.values, &place.values)) {
                apart.push(place);
            }
        }
        apart.into_iter().map(|place| &place.start).collect()
    }

    /// Or a likelier one from one of these starts. `follow` leads from a start to its end. Ends are only compared at first; what may take the best
    /// one's place is followed to the last digit, the likeliest before all others, unless by `is_another` it is where the best one is. What still creeps after
    /// some iterations is followed on only where that may matter, and not beyond a limit of the method's own. Once someone asks to stop, no further start is
    /// followed.
    pub fn or_from<E: Send>(
        &mut self,
        starts: Vec<Start>,
        follow: impl Fn(Start, &SolveEnvironment<'_>) -> Result<End<S, Start>, E> + Sync,
        is_another: impl Fn(&S, &Place<Start>) -> bool,
        environment: &SolveEnvironment<'_>,
    ) {
        // A start that leads nowhere says nothing of the others.
        let all = |starts: Vec<Start>, environment: &SolveEnvironment<'_>| -> Vec<End<S, Start>> {
            let followed = |start: Start| (!environment.stopped()).then(|| follow(start, environment));
            in_parallel(starts, followed).into_iter().flatten().flatten().collect()
        };
        let mut ends = all(starts, &environment.roughly().within(FIRST_ITERATIONS));
        ends.sort_by(|a, b| a.place.minus_log_likelihood.total_cmp(&b.place.minus_log_likelihood));
        let others = ends.split_off(ends.len().min(1));
        for ends in [ends, others] {
            let (on, there): (Vec<_>, Vec<_>) = ends.into_iter().partition(|end| self.may_matter(end, &is_another));
            let on = all(on.into_iter().map(|end| end.place.start).collect(), environment);
            on.into_iter().chain(there).for_each(|end| self.take_in(end));
        }
    }

    /// Whether what was followed roughly may take the best one's place, or be as plausible, once it is followed to its end.
    fn may_matter(&self, rough: &End<S, Start>, is_another: impl Fn(&S, &Place<Start>) -> bool) -> bool {
        let gain = self.best.place.minus_log_likelihood - rough.place.minus_log_likelihood;
        let needed = if self.best.termination.converged() { LIKELIER } else { 0.0 };
        let by_own_limit =
            matches!(rough.termination, Termination::IterationLimit { limit } if limit < FIRST_ITERATIONS);
        match rough.termination.converged() {
            // At one place the likelihoods of a rough end and of an exact one differ by next to nothing, to either side.
            true => {
                gain > needed - UNSETTLED
                    && (gain > LIKELIER || needed == 0.0 || is_another(&self.best.solution, &rough.place))
            }
            false => gain > -IMPLAUSIBLE && !by_own_limit,
        }
    }

    fn take_in(&mut self, other: End<S, Start>) {
        let gain = self.best.place.minus_log_likelihood - other.place.minus_log_likelihood;
        let converged = [&other, &self.best].map(|end| end.termination.converged());
        if gain > LIKELIER || gain > 0.0 && converged == [true, false] {
            let replaced = std::mem::replace(&mut self.best, other);
            self.others.extend(converged[1].then_some(replaced.place));
            self.is_another = true;
        } else if converged[0] {
            self.others.push(other.place);
        }
    }
}

fn are_same(a: &Values, b: &Values) -> bool {
    let (a, b) = (a.as_slice(), b.as_slice());
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME * a.abs().max(1.0))
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{
        Automatic, Block, BlockId, Estimate, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, Problem,
        ProblemBuilder, SolveError,
    };

    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

    use gravcal_solvers::{LevenbergMarquardt, StoppingRules};

    use super::*;
    use crate::testing::with_environment;

    /// Readings of `x²` and, roughly, of `x`.
    #[derive(Debug)]
    struct Squared([BlockId; 1]);

    impl Formula for Squared {
        fn blocks(&self) -> &[BlockId] {
            &self.0
        }

        fn len(&self) -> usize {
            2
        }

        fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            let x = p.scalar(0);
            (residual[0], residual[1]) = (x * x - 1.0, x - 1.0);
            Ok(())
        }
    }

    /// `x²` is 1 ± 0.01, `x` 1 ± `rough`: minima near 1 and −1.
    fn problem(rough: f64) -> (Problem, Values, BlockId) {
        let mut builder = ProblemBuilder::new();
        let x = builder.add_block(Block::scalar("x", ""), &[0.0]);
        builder.add_factor(Factor::new(Automatic(Squared([x])), Noise::independent(&[0.01, rough]).unwrap()));
        let (problem, values) = builder.build().unwrap();
        (problem, values, x)
    }

    fn end(solution: Estimate, x: BlockId) -> End<Estimate, f64> {
        let (values, start) = (solution.values.clone(), solution.values.scalar(x));
        let place = Place { minus_log_likelihood: solution.cost, values, start };
        End { place, termination: solution.termination, solution }
    }

    fn is_another(best: &Estimate, place: &Place<f64>, x: BlockId) -> bool {
        (best.values.scalar(x) - place.start).abs() > 0.01
    }

    /// First from −2, then from 3 and −3.
    fn likeliest(rough: f64) -> (f64, Likeliest<Estimate, f64>) {
        let (problem, initial, x) = problem(rough);
        let follow = |start: f64, environment: &SolveEnvironment<'_>| -> Result<End<Estimate, f64>, SolveError> {
            let mut values = initial.clone();
            values.set(x, &[start]);
            Ok(end(environment.solve(&problem, &values)?, x))
        };
        with_environment(|environment| {
            let mut likeliest = Likeliest::first(follow(-2.0, environment).unwrap());
            likeliest.or_from(vec![3.0, -3.0], follow, |best, place| is_another(best, place, x), environment);
            (likeliest.best.place.start, likeliest)
        })
    }

    #[test]
    fn a_likelier_end_takes_the_place_of_the_first_which_is_kept_beside_it() {
        // At −1 the second reading costs 2/rough².
        let (x, likeliest) = likeliest(1.0);
        assert!(likeliest.is_another && (x - 1.0).abs() < 1e-6, "{x}");
        let heights: Vec<f64> = likeliest.others.iter().map(|place| place.minus_log_likelihood).collect();
        assert!(heights.len() == 2 && heights.iter().all(|height| (height - 2.0).abs() < 0.02), "{heights:?}");
    }

    #[test]
    fn an_end_that_is_little_likelier_is_kept_beside_the_first() {
        let (x, likeliest) = likeliest(2.0);
        assert!(!likeliest.is_another && (x + 1.0).abs() < 0.01, "{x}");
        assert!(likeliest.others.iter().any(|place| place.start > 0.99));
    }

    #[test]
    fn an_end_is_plausible_once_and_unless_it_is_ruled_out() {
        let ends = |rough: f64| likeliest(rough).1.plausible().into_iter().copied().collect::<Vec<f64>>();
        let [first, other] = ends(1.0)[..] else { panic!("{:?}", ends(1.0)) };
        assert!((first - 1.0).abs() < 0.01 && (other + 1.0).abs() < 0.01, "{first} {other}");
        assert_eq!(ends(0.2).len(), 1, "the end near −1 costs 50 more");
    }

    #[test]
    fn ends_with_other_unknowns_are_never_the_same() {
        let (_, mut likeliest) = likeliest(1.0);
        let mut builder = ProblemBuilder::new();
        builder.add_block(
            Block::vector("others", "", &["a", "b"]),
            likeliest.best.place.values.as_slice().repeat(2).as_slice(),
        );
        likeliest.best.place.values = builder.initial();
        likeliest.others.retain(|place| place.start < 0.0);
        assert_eq!(likeliest.plausible().len(), 2);
    }

    /// Both starts lead to 1, and seem to be worth it beside −1; once one of them was followed to its end, the other is not.
    #[test]
    fn what_matters_no_more_beside_the_likeliest_is_not_followed_to_its_end() {
        let (problem, initial, x) = problem(0.2);
        let solves = AtomicUsize::new(0);
        let follow = |start: f64, environment: &SolveEnvironment<'_>| -> Result<End<Estimate, f64>, SolveError> {
            solves.fetch_add(1, Ordering::Relaxed);
            let mut values = initial.clone();
            values.set(x, &[start]);
            Ok(end(environment.solve(&problem, &values)?, x))
        };
        with_environment(|environment| {
            let mut likeliest = Likeliest::first(follow(-2.0, environment).unwrap());
            likeliest.or_from(vec![3.0, 4.0], follow, |best, place| is_another(best, place, x), environment);
            assert!(likeliest.is_another && likeliest.others.len() == 2);
        });
        assert_eq!(solves.into_inner(), 4, "the first, two roughly, and the likeliest of these to its end");
    }

    /// A rough end where the best one is may seem a little likelier: it is no other.
    #[test]
    fn what_ends_where_the_best_one_is_is_not_followed_to_its_end() {
        let (problem, initial, x) = problem(0.2);
        let solves = AtomicUsize::new(0);
        let follow = |start: f64, environment: &SolveEnvironment<'_>| -> Result<End<Estimate, f64>, SolveError> {
            let mut values = initial.clone();
            values.set(x, &[start]);
            let mut end = end(environment.solve(&problem, &values)?, x);
            end.place.minus_log_likelihood -= 1e-3 * solves.fetch_add(1, Ordering::Relaxed) as f64;
            Ok(end)
        };
        with_environment(|environment| {
            let mut likeliest = Likeliest::first(follow(2.0, environment).unwrap());
            likeliest.or_from(vec![3.0], follow, |best, place| is_another(best, place, x), environment);
            assert!(!likeliest.is_another && likeliest.others.len() == 1);
            assert_eq!(solves.load(Ordering::Relaxed), 2, "the first, and one roughly");
            likeliest.or_from(vec![3.0], follow, |_, _| true, environment);
        });
        assert_eq!(solves.into_inner(), 4, "and to its end where nobody says that it is the same");
    }

    #[test]
    fn no_start_is_followed_once_someone_asks_to_stop() {
        let stop = AtomicBool::new(false);
        let (problem, initial, x) = problem(0.2);
        let solves = AtomicUsize::new(0);
        let follow = |start: f64, environment: &SolveEnvironment<'_>| -> Result<End<Estimate, f64>, SolveError> {
            solves.fetch_add(1, Ordering::Relaxed);
            let mut values = initial.clone();
            values.set(x, &[start]);
            Ok(end(environment.solve(&problem, &values)?, x))
        };
        with_environment(|environment| {
            let environment = environment.within(100).stopped_by(&stop);
            let mut likeliest = Likeliest::first(follow(-2.0, &environment).unwrap());
            stop.store(true, Ordering::Relaxed);
            likeliest.or_from(vec![3.0, -3.0], follow, |best, place| is_another(best, place, x), &environment);
            assert!(!likeliest.is_another && likeliest.others.is_empty());
        });
        assert_eq!(solves.into_inner(), 1);
    }

    #[test]
    fn a_limit_of_the_method_s_own_is_not_passed() {
        let (problem, initial, x) = problem(0.2);
        let stopping = StoppingRules { max_iterations: 2, ..StoppingRules::default() };
        let solver = LevenbergMarquardt { stopping };
        let environment = SolveEnvironment::new(&solver, &|_: &str| {});
        let solves = AtomicUsize::new(0);
        let follow = |start: f64, environment: &SolveEnvironment<'_>| -> Result<End<Estimate, f64>, SolveError> {
            solves.fetch_add(1, Ordering::Relaxed);
            let mut values = initial.clone();
            values.set(x, &[start]);
            Ok(end(environment.solve(&problem, &values)?, x))
        };
        let mut likeliest = Likeliest::first(follow(-2.0, &environment).unwrap());
        likeliest.or_from(vec![300.0], follow, |best, place| is_another(best, place, x), &environment);
        assert_eq!((solves.into_inner(), likeliest.others.len()), (2, 0));
    }
}
