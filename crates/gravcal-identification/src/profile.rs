//! How well parameters are known where the problem is not linear over their errors.
//!
//! ½ χ² with one parameter fixed `d` from its estimate, and all others where they then explain the readings best, is its profile. Where the
//! problem is linear that grows by `½ (d/σ)²`, 2 at two standard deviations. An arc of a few degrees looks bent at an estimate
//! that noise has moved, and is no more than that where the others follow: then it grows by less, and
//!
//! ```text
//!     ½ χ²(x̂ ± d) − ½ χ²(x̂) = ½ h²      tells a standard deviation of d/h,     2 ≤ h ≤ 4
//! ```
//!
//! to that side and at that height at which it is largest (Bates and Watts, *Nonlinear Regression Analysis and Its Applications*, 1988,
//! section 6.1). A valley that is steep at first and flat beyond is as wide as it is there. The others follow in steps, each from where the
//! linear model of the last one leads. A reference keeps some of them plausible, which counts: a sensor whose gain is zero tells
//! nothing any more, and any constant explains its readings. What is known many times better than it needs to be is not looked at.
//!
//! Where much is open there are many such valleys, and who follows one of them does not see the next. There the parameter is also moved by four
//! standard deviations while the others begin elsewhere, as at declared values; what explains the readings tells as above.
//!
//! Why it is so, and what was tried: `docs/decisions/profiles.md`.

use gravcal_estimation::{EvaluateError, Problem, RankAnalysis, Reference, Values, in_parallel};

use crate::environment::SolveEnvironment;
use crate::nearby::{BASELESS, MOST_COLUMNS};

/// Standard deviations at which the profile is looked at, and its growth there in a linear problem.
const AWAY: f64 = 2.0;
const GROWTH: f64 = 0.5 * AWAY * AWAY;
/// A profile that grows by this share of it, or that share of this, is as wide as the linear model says.
const LINEAR: f64 = 0.8;
/// √ of the growth at two standard deviations, in that of a linear problem, that is no farther from one than this: at four it is then about as
/// far within [`LINEAR`].
const STRAIGHT: f64 = 0.02;
/// √ of the growth, in that at two standard deviations, up to which the profile is followed: four.
const HIGHEST: f64 = 2.0;
/// A step over which √ of the growth rises by so much more than in a linear problem, and by so much of what it is at two standard
/// deviations, is too long for the others to follow. It is followed by one of a quarter, and each other by one longer by half.
const STEEP: f64 = 1.25;
const RISE: f64 = 0.25;
const LONGER: f64 = 1.5;
/// Standard deviations over which the others can follow where those of the linear model have a basis.
const LEAST: f64 = 0.02;
/// Share of that growth to which the cost is known where the others follow.
const KNOWN: f64 = 1e-4;
/// Iterations in which the others follow, and in which they find the way from elsewhere.
const ITERATIONS: usize = 30;
const FROM_ELSEWHERE: usize = 300;
/// Where the cost has grown by so many times that growth, and that after so many iterations, the others have not followed, or found no way.
const LOST: f64 = 100.0;
const LOST_AFTER: usize = 10;
const LOST_ELSEWHERE: usize = 60;

/// An estimate whose profiles are looked at.
pub struct Profiled<'a> {
    /// The problem as it is judged: along its active constraints.
    pub problem: &'a Problem,
    /// The estimate.
    pub values: &'a Values,
    /// What the linear model says there.
    pub analysis: &'a RankAnalysis,
    /// Of the other parameters: what keeps them plausible while they follow.
    pub reference: Option<&'a Reference>,
    /// Share of its limit of use that a standard deviation makes up at least whose profile is looked at
    /// ([`share_that_matters`](crate::share_that_matters)).
    pub matters: f64,
    /// Where else the other parameters may begin.
    pub starts: &'a [Values],
}

impl Profiled<'_> {
    /// Columns and standard deviations that their profiles tell, where these are larger than those of the linear model. `reported`: columns and
    /// limits of use of parameters of one number each.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated.
    pub fn wider(
        &self,
        reported: &[(usize, f64)],
        environment: &SolveEnvironment<'_>,
    ) -> Result<Vec<(usize, f64)>, EvaluateError> {
        if self.problem.columns().len() > MOST_COLUMNS {
            return Ok(Vec::new());
        }
        let freedom = self.problem.rows().saturating_sub(self.analysis.rank()).max(1) as f64;
        let noise = (2.0 * self.problem.without_reference().cost(self.values)? / freedom).max(1.0);
        let wider = |(column, limit): &(usize, f64)| self.of_column(*column, *limit, noise, environment);
        let found: Vec<Vec<_>> = in_parallel(reported, wider).into_iter().collect::<Result<_, _>>()?;
        Ok(found.concat())
    }

    fn of_column(
        &self,
        column: usize,
        limit: f64,
        noise: f64,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Vec<(usize, f64)>, EvaluateError> {
        let std = self.analysis.covariance().std(column);
        if std < self.matters * limit || std > limit {
            return Ok(Vec::new());
        }
        let profile = Profile { of: self, column, std, limit, noise };
        let mut found = Vec::new();
        let Some(start) = profile.at(1.0, 0.0, &profile.estimate(), environment)? else { return Ok(found) };
        for side in [1.0, -1.0] {
            let std = profile.wider(side, &start, environment)?.unwrap_or(std);
            let std = profile.begun_elsewhere(side, std, start.cost, environment)?;
            found.push((column, std));
            if std > limit {
                break;
            }
        }
        found.retain(|(_, wider)| *wider > std / LINEAR);
        Ok(found)
    }
}

/// Of one parameter.
struct Profile<'a> {
    of: &'a Profiled<'a>,
    column: usize,
    /// By the linear model.
    std: f64,
    /// Beyond which it is of no use.
    limit: f64,
    /// Of the readings, as a square, where they are explained worse than their stated noise says.
    noise: f64,
}

impl Profile<'_> {
    /// The standard deviation that the profile tells to one side, where it is larger than that of the linear model. `start`: where the others
    /// are with the parameter at its estimate.
    fn wider(
        &self,
        side: f64,
        start: &Point,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<f64>, EvaluateError> {
        let mut before = start.clone();
        let (whole, lowest) = (AWAY * self.std, before.cost);
        let (mut step, mut height, mut std) = (whole, 0.0, self.std);
        while height < HIGHEST && std <= self.limit && before.distance <= AWAY * self.limit {
            let Some(point) = self.at(side, before.distance + step, &before, environment)? else { break };
            let risen = ((point.cost - lowest) / self.noise / GROWTH).max(0.0).sqrt();
            if before.distance == 0.0 && step == whole && (risen - 1.0).abs() < STRAIGHT {
                return Ok(None);
            }
            let is_linear = (LINEAR..1.0 / LINEAR).contains(&(risen - height).powi(2)) && step == whole;
            if !is_linear && risen - height > (STEEP * step / whole).max(RISE) {
                step /= 4.0;
                if step < LEAST * self.std {
                    std = std.max(BASELESS * self.std);
                    break;
                }
                continue;
            }
            if height < 1.0 && risen >= 1.0 {
                // √ of the growth is nearly straight.
                std = std.max((before.distance + (1.0 - height) / (risen - height) * step) / AWAY);
            }
            if risen >= 1.0 {
                std = std.max(point.distance / risen / AWAY);
            }
            (before, height) = (point, risen);
            step *= if is_linear { 1.0 } else { LONGER };
        }
        if height < 1.0 {
            std = std.max(before.distance / AWAY);
        }
        Ok((std > self.std / LINEAR).then_some(std))
    }

    /// The same from other starts of the others, where that is still larger than `told`.
    fn begun_elsewhere(
        &self,
        side: f64,
        told: f64,
        lowest: f64,
        environment: &SolveEnvironment<'_>,
    ) -> Result<f64, EvaluateError> {
        let mut std = told;
        while std <= self.limit {
            let distance = 2.0 * AWAY * std;
            let within = environment.within(FROM_ELSEWHERE).unless_above(self.lost(lowest), LOST_ELSEWHERE);
            let starts = self.of.starts.iter().map(|start| self.solved(side * distance, start, &within));
            let costs = starts.filter_map(|there| there.map(|there| there.0));
            let growth = costs.fold(f64::INFINITY, f64::min) - lowest;
            let deviations = (2.0 * growth / self.noise).max(0.0).sqrt().max(AWAY);
            if distance / deviations <= std / LINEAR {
                break;
            }
            std = distance / deviations;
            if deviations > AWAY {
                break;
            }
        }
        Ok(std)
    }

    fn estimate(&self) -> Point {
        Point { distance: 0.0, cost: 0.0, values: self.of.values.clone() }
    }

    /// Where the others are with the parameter fixed so far away. Nothing where they cannot be solved for.
    fn at(
        &self,
        side: f64,
        distance: f64,
        before: &Point,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Point>, EvaluateError> {
        let start = self.led_by(side * (distance - before.distance), before)?;
        let within = environment.within(ITERATIONS);
        let at_estimate = before.distance == 0.0 && distance == 0.0;
        let within = if at_estimate { within } else { within.unless_above(self.lost(before.cost), LOST_AFTER) };
        let there = self.solved(side * distance, &start, &within);
        Ok(there.map(|(cost, values)| Point { distance, cost, values }))
    }

    /// What no profile costs that is followed from a point of this cost.
    fn lost(&self, cost: f64) -> f64 {
        cost + LOST * GROWTH * self.noise
    }

    /// What it costs, and where the others are, with the parameter fixed so far from its estimate. Nothing where that cannot be solved.
    fn solved(&self, away: f64, start: &Values, environment: &SolveEnvironment<'_>) -> Option<(f64, Values)> {
        let Profiled { problem, values: estimate, reference, .. } = self.of;
        let block = problem.columns()[self.column].block;
        let mut start = start.clone();
        start.set(block, &[estimate.scalar(block) + away]);
        let fixed = problem.with_fixed(&[block], "looked at");
        let fixed = match reference {
            Some(reference) => fixed.with_reference((*reference).clone()),
            None => fixed,
        };
        let there = environment.to_within(KNOWN * GROWTH * self.noise).solve(&fixed, &start).ok()?;
        Some((there.cost, there.values))
    }

    /// Where the linear model at `from` has the others with the parameter so much farther.
    fn led_by(&self, farther: f64, from: &Point) -> Result<Values, EvaluateError> {
        let there;
        let known = if from.distance == 0.0 {
            self.of.analysis.covariance()
        } else {
            there = RankAnalysis::new(self.of.problem, &from.values)?;
            there.covariance()
        };
        let variance = known.at(self.column, self.column);
        let columns = 0..self.of.problem.columns().len();
        let step: Vec<f64> = columns.map(|column| known.at(column, self.column) * farther / variance).collect();
        Ok(self.of.problem.retract(&from.values, &step))
    }
}

/// Of a profile.
#[derive(Clone)]
struct Point {
    /// From the estimate.
    distance: f64,
    /// What readings, knowledge and the others' reference cost there.
    cost: f64,
    /// Where the others explain the readings best.
    values: Values,
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::{Automatic, Block, BlockId, Factor, Formula, LocalNumbers, Noise, Number, ProblemBuilder};

    use super::*;
    use crate::testing::with_environment;

    /// `asinh x` and the difference of `y` to `x`, which follows: the profile of `x` is `½ (asinh x / σ)²`.
    #[derive(Debug)]
    struct Flattened([BlockId; 2]);

    impl Formula for Flattened {
        fn blocks(&self) -> &[BlockId] {
            &self.0
        }

        fn len(&self) -> usize {
            2
        }

        fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            (residual[0], residual[1]) = (p.scalar(0).asinh(), p.scalar(1) - p.scalar(0));
            Ok(())
        }
    }

    /// What is told of `x`, if it is more than σ.
    fn reported(sigma: f64, limit: f64) -> Option<f64> {
        let mut builder = ProblemBuilder::new();
        let blocks = ["x", "y"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        let noise = Noise::independent(&[sigma, 1.0]).unwrap();
        builder.add_factor(Factor::new(Automatic(Flattened(blocks)), noise));
        let (problem, values) = builder.build().unwrap();
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let profiled = Profiled {
            problem: &problem,
            values: &values,
            analysis: &analysis,
            reference: None,
            matters: 0.05,
            starts: &[],
        };
        let found = with_environment(|w| profiled.wider(&[(0, limit)], w)).unwrap();
        found.into_iter().map(|(_, std)| std).reduce(f64::max)
    }

    #[test]
    fn a_profile_that_flattens_tells_its_own_width() {
        // ½ h² is reached at sinh(h σ): the standard deviation sinh(h σ)/h grows up to h = 4, beyond which nobody looks but for a step.
        let width = |h: f64| (0.5 * h).sinh() / h;
        let std = reported(0.5, 5.0).unwrap();
        assert!((0.99 * width(4.0)..width(6.0)).contains(&std), "{std} {}", width(4.0));
    }

    #[test]
    fn what_is_nearly_linear_or_known_well_enough_stays() {
        assert_eq!(reported(0.05, 0.5), None, "sinh(0.2)/4 is 0.0503");
        assert_eq!(reported(0.5, 20.0), None, "a fortieth of its limit");
    }

    /// `x (10 − 9 y)` and `300 y (y − 1)`: where `y` is zero `x` is known to 0.1, where it is one to 1, and both explain the readings.
    #[derive(Debug)]
    struct TwoValleys([BlockId; 2]);

    impl Formula for TwoValleys {
        fn blocks(&self) -> &[BlockId] {
            &self.0
        }

        fn len(&self) -> usize {
            2
        }

        fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            let (x, y) = (p.scalar(0), p.scalar(1));
            (residual[0], residual[1]) = (x * (-y * 9.0 + 10.0), y * (y - 1.0) * 300.0);
            Ok(())
        }
    }

    #[test]
    fn who_begins_elsewhere_finds_the_wider_of_two_valleys() {
        let mut builder = ProblemBuilder::new();
        let blocks = ["x", "y"].map(|name| builder.add_block(Block::scalar(name, ""), &[0.0]));
        builder.add_factor(Factor::new(Automatic(TwoValleys(blocks)), Noise::independent(&[1.0, 1.0]).unwrap()));
        let (problem, values) = builder.build().unwrap();
        let analysis = RankAnalysis::new(&problem, &values).unwrap();
        let mut other = values.clone();
        other.set(blocks[1], &[1.0]);
        let told = |starts: &[Values]| {
            let (problem, values, analysis) = (&problem, &values, &analysis);
            let profiled = Profiled { problem, values, analysis, reference: None, matters: 0.05, starts };
            with_environment(|w| profiled.wider(&[(0, 1.5)], w)).unwrap()
        };
        assert_eq!(told(&[]), [], "who follows the valley does not see the other");
        let stds: Vec<f64> = told(&[other]).into_iter().map(|(_, std)| std).collect();
        assert!(!stds.is_empty() && stds.iter().all(|std| (std - 1.0).abs() < 0.02), "{stds:?}");
    }
}
