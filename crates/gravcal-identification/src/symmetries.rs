//! Discrete symmetries: images of a solution of which the readings say little or nothing.
//!
//! A model may read the same, or all but the same, at values between which no way leads: with all signs turned, with an axis counted from
//! its other end. A fit ends at one of them, by where it started. So the images of its end are followed to their own ends, one symmetry of a
//! list after the other, each from where the one before left off, and with costs or − ln of likelihoods `C` here and `C′` there
//!
//! ```text
//!     C′ < C − 10⁻⁶ C      an image takes the solution's place that explains the readings better,
//!     C′ < C + 10          and one that is as declared, where the solution is not, unless the readings rule it out;
//!     |C′ − C| ≤ 10        where nothing is declared, nothing then tells which of the two is right: that is reported.
//! ```
//!
//! **An image is a solution of the same problem.** That the problem itself may be wrong (two columns exchanged, a sensor that reads the other
//! way than it is said to) is another question: other problems explain the readings by more freedom, so they are weighed by how many were
//! tried, and what is found there is a hint for who stated the problem. It never takes the solution's place.

use crate::environment::SolveEnvironment;
use crate::likeliest::DECISIVE;

/// An image takes the solution's place where it lowers the cost by more than this share: less is where the same solution was found again.
const LOWER: f64 = 1e-6;

/// A map of values to others at which the readings are about the same.
pub trait Symmetry {
    /// Where a fit ends, with all that is known there.
    type Solution;
    /// Where a fit starts.
    type Start;
    /// Why there may be no answer.
    type Error;

    /// In a few words, for who waits.
    fn name(&self) -> &'static str;

    /// The images of a solution that are to be followed; none where it has none, or where a glance at them suffices.
    ///
    /// # Errors
    /// Where one cannot be looked at.
    fn images(
        &self,
        solution: &Self::Solution,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Vec<Self::Start>, Self::Error>;

    /// Where the fit from an image of a solution ends; nothing where that may not take the solution's place.
    ///
    /// # Errors
    /// Where there is no answer for a reason that concerns the solution, too.
    fn follow(
        &self,
        image: Self::Start,
        solution: &Self::Solution,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Self::Solution>, Self::Error>;

    /// Cost or − ln of the likelihood, by which ends are compared.
    fn height(&self, solution: &Self::Solution) -> f64;

    /// Whether its images are as declared where a solution is not.
    fn is_declared(&self) -> bool {
        false
    }

    /// Whether the end of an image is another solution, and not the first one found again.
    fn is_another(&self, _end: &Self::Solution, _solution: &Self::Solution) -> bool {
        true
    }

    /// The end of an image in the place of the solution.
    ///
    /// # Errors
    /// Where it has to be solved again, and there is no answer.
    fn replaced(
        &self,
        _solution: Self::Solution,
        end: Self::Solution,
        _environment: &SolveEnvironment<'_>,
    ) -> Result<Self::Solution, Self::Error> {
        Ok(end)
    }

    /// A solution that has images of which none takes its place.
    ///
    /// # Errors
    /// Where it cannot be looked at.
    fn kept(
        &self,
        solution: Self::Solution,
        _environment: &SolveEnvironment<'_>,
    ) -> Result<Self::Solution, Self::Error> {
        Ok(solution)
    }
}

/// What is left when all symmetries were tried.
#[derive(Debug)]
pub struct Settled<S> {
    /// The solution, or the image in its place.
    pub solution: S,
    /// Names of the symmetries of which nothing tells whether it or its image is right.
    pub undecided: Vec<&'static str>,
}

/// Follows the images of a solution, and takes those that are better. The symmetries are tried in their order, each on what the one before
/// left.
///
/// # Errors
/// Where an image cannot be looked at, or followed.
pub fn settle<S, V, E>(
    solution: S,
    symmetries: &[&dyn Symmetry<Solution = S, Start = V, Error = E>],
    environment: &SolveEnvironment<'_>,
) -> Result<Settled<S>, E> {
    let mut settled = Settled { solution, undecided: Vec::new() };
    for symmetry in symmetries {
        let images = symmetry.images(&settled.solution, environment)?;
        if images.is_empty() {
            continue;
        }
        environment.report(symmetry.name());
        let end = lowest(*symmetry, images, &settled.solution, environment)?;
        let gain = |end: &S| symmetry.height(&settled.solution) - symmetry.height(end);
        let undecided = |end: &S| {
            !symmetry.is_declared() && symmetry.is_another(end, &settled.solution) && gain(end).abs() <= DECISIVE
        };
        if end.as_ref().is_some_and(undecided) {
            settled.undecided.push(symmetry.name());
        }
        let least = if symmetry.is_declared() { -DECISIVE } else { LOWER * symmetry.height(&settled.solution).abs() };
        settled.solution = match end.filter(|end| gain(end) > least) {
            Some(end) => symmetry.replaced(settled.solution, end, environment)?,
            None => symmetry.kept(settled.solution, environment)?,
        };
    }
    Ok(settled)
}

/// The lowest of the ends of some images, the first of those that are equally low.
fn lowest<S, V, E>(
    symmetry: &dyn Symmetry<Solution = S, Start = V, Error = E>,
    images: Vec<V>,
    solution: &S,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<S>, E> {
    let mut lowest: Option<S> = None;
    for image in images {
        let end = symmetry.follow(image, solution, environment)?;
        let is_lower = |end: &S| lowest.as_ref().is_none_or(|best| symmetry.height(end) < symmetry.height(best));
        lowest = end.filter(is_lower).or(lowest);
    }
    Ok(lowest)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use gravcal_estimation::{
        Automatic, Block, BlockId, Estimate, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, Problem,
        ProblemBuilder, SolveError, Values,
    };

    use super::*;
    use crate::testing::with_environment;

    /// Readings of `x²` and `y²`, and, roughly, of `x` and `y`.
    #[derive(Debug)]
    struct Squares([BlockId; 2]);

    impl Formula for Squares {
        fn blocks(&self) -> &[BlockId] {
            &self.0
        }

        fn len(&self) -> usize {
            4
        }

        fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            let (x, y) = (p.scalar(0), p.scalar(1));
            (residual[0], residual[1]) = (x * x - 1.0, x - 1.0);
            (residual[2], residual[3]) = (y * y - 4.0, y - 2.0);
            Ok(())
        }
    }

    /// `x² = 1` and `y² = 4`, each ± 0.01; `x = 1` and `y = 2`, each by its `rough`.
    struct Toy {
        problem: Problem,
        initial: Values,
        blocks: [BlockId; 2],
    }

    impl Toy {
        fn new(rough: [f64; 2]) -> Toy {
            let mut builder = ProblemBuilder::new();
            let blocks = ["x", "y"].map(|name| builder.add_block(Block::scalar(name, ""), &[1.0]));
            let noise = Noise::independent(&[0.01, rough[0], 0.01, rough[1]]).unwrap();
            builder.add_factor(Factor::new(Automatic(Squares(blocks)), noise));
            let (problem, initial) = builder.build().unwrap();
            Toy { problem, initial, blocks }
        }

        fn solve(&self, start: [f64; 2], environment: &SolveEnvironment<'_>) -> Result<Estimate, SolveError> {
            let mut values = self.initial.clone();
            self.blocks.iter().zip(start).for_each(|(id, value)| values.set(*id, &[value]));
            environment.solve(&self.problem, &values)
        }

        fn at(&self, estimate: &Estimate) -> [f64; 2] {
            self.blocks.map(|id| estimate.values.scalar(id))
        }
    }

    /// One of both numbers negative.
    struct Negative<'a> {
        toy: &'a Toy,
        name: &'static str,
        index: usize,
        /// Whether the number is declared to be positive.
        declared: bool,
        /// What was done.
        log: &'a RefCell<Vec<&'static str>>,
    }

    impl Symmetry for Negative<'_> {
        type Solution = Estimate;
        type Start = [f64; 2];
        type Error = SolveError;

        fn name(&self) -> &'static str {
            self.name
        }

        fn images(&self, solution: &Estimate, _: &SolveEnvironment<'_>) -> Result<Vec<[f64; 2]>, SolveError> {
            let mut image = self.toy.at(solution);
            let as_it_should_be = self.declared && image[self.index] > 0.0;
            image[self.index] *= -1.0;
            Ok(if as_it_should_be { Vec::new() } else { vec![image] })
        }

        fn follow(
            &self,
            image: [f64; 2],
            _: &Estimate,
            environment: &SolveEnvironment<'_>,
        ) -> Result<Option<Estimate>, SolveError> {
            self.log.borrow_mut().push("followed");
            self.toy.solve(image, environment).map(Some)
        }

        fn height(&self, solution: &Estimate) -> f64 {
            solution.cost
        }

        fn is_declared(&self) -> bool {
            self.declared
        }

        fn is_another(&self, end: &Estimate, solution: &Estimate) -> bool {
            self.toy.at(end)[self.index] * self.toy.at(solution)[self.index] < 0.0
        }

        fn kept(&self, solution: Estimate, _: &SolveEnvironment<'_>) -> Result<Estimate, SolveError> {
            self.log.borrow_mut().push("kept");
            Ok(solution)
        }
    }

    /// Where the solution near a start is led, which symmetries are undecided, and what was done.
    fn settled(rough: [f64; 2], start: [f64; 2], declared: bool) -> ([f64; 2], Vec<&'static str>, Vec<&'static str>) {
        let (toy, log) = (Toy::new(rough), RefCell::default());
        let [x, y] = [("x", 0), ("y", 1)].map(|(name, index)| Negative { toy: &toy, name, index, declared, log: &log });
        let Settled { solution, undecided } = with_environment(|environment| {
            let solution = toy.solve(start, environment)?;
            settle(solution, &[&x, &y], environment)
        })
        .unwrap();
        let at = toy.at(&solution).map(f64::round);
        (at, undecided, log.into_inner())
    }

    #[test]
    fn an_image_that_explains_the_readings_better_is_taken_and_the_next_is_that_of_it() {
        let (at, undecided, log) = settled([0.1, 0.1], [-1.5, -2.5], false);
        assert_eq!((at, undecided), ([1.0, 2.0], vec![]));
        assert_eq!(log, ["followed"; 2]);
    }

    #[test]
    fn of_an_image_that_explains_them_as_well_nothing_tells_which_is_right() {
        // From −1 to 1 the cost falls by ½ (2/3)², from −2 to 2 by ½ (4/0.1)².
        let (at, undecided, _) = settled([3.0, 0.1], [-1.5, -2.5], false);
        assert_eq!((at, undecided), ([1.0, 2.0], vec!["x"]));
        let (at, undecided, log) = settled([3.0, 0.1], [1.5, 2.5], false);
        assert_eq!((at, undecided), ([1.0, 2.0], vec!["x"]));
        assert_eq!(log, ["followed", "kept", "followed", "kept"]);
    }

    #[test]
    fn an_image_that_is_as_declared_is_taken_where_nothing_tells_and_is_not_undecided() {
        let toy = |sign: f64| ([3.0, 3.0], [1.5 * sign, 2.5 * sign]);
        let (rough, start) = toy(-1.0);
        assert_eq!(settled(rough, start, true), ([1.0, 2.0], vec![], vec!["followed"; 2]));
        let (rough, start) = toy(1.0);
        assert_eq!(settled(rough, start, true), ([1.0, 2.0], vec![], vec![]), "it is as declared");
    }

    /// `x` is declared to be positive, and is read to be −1.
    #[test]
    fn readings_may_rule_out_what_is_declared() {
        let mut builder = ProblemBuilder::new();
        let blocks = ["x", "y"].map(|name| builder.add_block(Block::scalar(name, ""), &[1.0]));
        let noise = Noise::independent(&[0.01, 1.0, 0.01, 1.0]).unwrap();
        builder.add_factor(Factor::new(Automatic(Squares(blocks)), noise.clone()));
        builder.add_factor(Factor::new(Automatic(ReadNegative([blocks[0]])), Noise::independent(&[0.1]).unwrap()));
        let (problem, initial) = builder.build().unwrap();
        let (toy, log) = (Toy { problem, initial, blocks }, RefCell::default());
        let x = Negative { toy: &toy, name: "x", index: 0, declared: true, log: &log };
        let settled = with_environment(|w| settle(toy.solve([-1.5, 2.5], w)?, &[&x], w)).unwrap();
        assert_eq!((toy.at(&settled.solution)[0].round(), settled.undecided), (-1.0, vec![]));
        assert_eq!(log.into_inner(), ["followed", "kept"]);
    }

    /// `x + 1`.
    #[derive(Debug)]
    struct ReadNegative([BlockId; 1]);

    impl Formula for ReadNegative {
        fn blocks(&self) -> &[BlockId] {
            &self.0
        }

        fn len(&self) -> usize {
            1
        }

        fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            residual[0] = p.scalar(0) + 1.0;
            Ok(())
        }
    }
}
