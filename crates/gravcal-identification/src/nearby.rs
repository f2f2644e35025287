//! How little the readings may say at values near the estimate.
//!
//! At an estimate, which noise moves, a direction that has no effect at the truth has some: an upright base comes out a little tilted, a
//! joint that stands at zero a little off it. Its effect `s = |J v|` is then made of that error, and a standard deviation that rests on it says
//! nothing. To first order `s` changes with the unknowns by
//!
//! ```text
//!     a = ∂(uᵀ J v)/∂x = uᵀ (J(x + h v) − J(x − h v)) / 2h,      s u = J v,      var s = aᵀ C a,      C = (JᵀJ + W)⁻¹
//! ```
//!
//! as second derivatives commute (and as `v`, and `u`, make `s` stationary). `W` is the reference prior, as narrow as what would be of use, for
//! what the readings leave open. The truth may lie some standard deviations from the estimate to that side at which `s` is smaller,
//!
//! ```text
//!     x* = x − C a / √(aᵀ C a) · min(1, s / √(aᵀ C a))      and on from there, with the v of x*
//! ```
//!
//! There the readings are judged, too. What is not determined there is not determined, and no standard deviation is told that is less than
//! that there; beyond two standard deviations, less than two thirds of it ([`AT_LEAST`]). Where the problem is linear over the errors of its
//! estimate, nothing changes.
//!
//! Two kinds of directions are followed: singular ones that make up a share of a standard deviation that matters, and the error of each
//! parameter, `v = C e`.
//!
//! Why it is so, and what was tried: `docs/decisions/truth-is-not-the-estimate.md`.

use gravcal_estimation::{Column, EvaluateError, Problem, Reference, Values};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal};

/// Standard deviations from the estimate to which the truth is looked for, one a piece of the way.
const PLAUSIBLE: usize = 4;
/// Growth of ½ χ² beyond which values are not plausible: five standard deviations.
pub const IMPLAUSIBLE: f64 = 12.5;
/// Share of the standard deviation at plausible values that is told at least.
pub const AT_LEAST: f64 = 2.0 / 3.0;
/// An effect that varies by less than this share of itself by a standard deviation is at the farthest still as much as is told.
const STEADY: f64 = (1.0 - AT_LEAST) / PLAUSIBLE as f64;
/// Steps at most by which the rest follows a piece; one that lowers ½ χ² by less is the last.
const CORRECTIONS: usize = 6;
const SETTLED: f64 = 0.1;
/// Times by which a standard deviation is too small that has no basis.
pub const BASELESS: f64 = 10.0;
/// Only directions that make up this share of a limit of use are looked at, and this share where most of what is asked for is open: that may be
/// anywhere, and takes far what hangs on it.
const MATTERS: f64 = 0.05;
const MATTERS_AMONG_OPEN: f64 = 0.002;
/// Length of the step of a difference, in limits of use.
const DIFFERENCE: f64 = 1e-3;
/// An effect of a limit of use below this is nothing: the rank tells of it.
const NOTHING: f64 = 1e-3;
/// Added to the diagonal, of which it is this share: what nothing is known of has a wide covariance, not none.
const RIDGE: f64 = 1e-14;
/// Problems with more columns are not looked at: such have unknowns of single poses, which have knowledge of their own.
pub const MOST_COLUMNS: usize = 400;

/// Plausible values at which something has the least effect, one for each direction whose effect is not steady, with what ½ χ² is larger by
/// there. `asked`: column and limit of use of what is asked for; `determined`: columns of what will be told; `plausible`: where unknowns lie
/// of which the readings say nothing.
///
/// # Errors
/// Where a residual cannot be evaluated nearby.
pub fn least_informed_nearby(
    (problem, values): (&Problem, &Values),
    asked: &[(usize, f64)],
    determined: &[usize],
    (plausible, matters): (&Reference, f64),
) -> Result<Vec<(Values, f64)>, EvaluateError> {
    if problem.columns().len() > MOST_COLUMNS {
        return Ok(Vec::new());
    }
    let alone = problem.without_reference();
    let norms = alone.linearize(values)?.column_scales();
    let scales = scales(&alone, &norms, asked, plausible);
    let mut firmness = DVector::zeros(scales.len());
    for (column, std) in plausible.std_by_column(problem).into_iter().chain(directions(problem)) {
        firmness[column] = (scales[column] / std).powi(2);
    }
    let surroundings = Surroundings { problem: &alone, scales, firmness };
    let Some(estimate) = surroundings.point(values.clone())? else { return Ok(Vec::new()) };
    let faint = faint_directions(&estimate.hessian, asked, matters).into_iter().map(Direction::Faint);
    let errors = determined.iter().copied().map(Direction::ErrorOf);
    let mut found = Vec::new();
    for direction in faint.chain(errors) {
        found.extend(surroundings.where_less(&estimate, direction)?);
    }
    Ok(found)
}

/// Share of a limit of use that an error must make up to be worth a look, by whether most of what is asked for is open.
pub fn share_that_matters(mostly_open: bool) -> f64 {
    if mostly_open { MATTERS_AMONG_OPEN } else { MATTERS }
}

/// The growth of ½ χ² in one direction that is as improbable as a growth in several. Where so many directions lose their effect they explain
/// no noise, and ½ χ² is larger by half their number on average: χ² of as many degrees of freedom. Noise that was found from so many
/// (`freedom`) degrees of freedom may itself be too small: then it is Fisher's F of both.
pub fn as_of_one_direction(growth: f64, directions: usize, freedom: Option<f64>) -> f64 {
    let directions = directions as f64;
    let improbable = match freedom {
        None => ChiSquared::new(directions).map(|distribution| distribution.sf(2.0 * growth)).ok(),
        Some(freedom) => {
            FisherSnedecor::new(directions, freedom).map(|distribution| distribution.sf(2.0 * growth / directions)).ok()
        }
    };
    // Beyond what the distribution resolves, no number of directions makes it plausible.
    match improbable.filter(|improbable| improbable.is_normal()) {
        Some(improbable) => 0.5 * Normal::standard().inverse_cdf(0.5 * improbable).powi(2),
        None => growth,
    }
}

/// Columns of directions, of which nobody can be farther off than about a radian, and what this is in their unit.
fn directions(problem: &Problem) -> impl Iterator<Item = (usize, f64)> {
    let radian = |(column, of): (usize, &Column)| Some((column, problem.block(of.block).manifold().radian()?));
    problem.columns().iter().enumerate().filter_map(radian)
}

/// What a step of one is by each column: a limit of use of what is asked for, what is plausible of the rest.
fn scales(problem: &Problem, norms: &[f64], asked: &[(usize, f64)], plausible: &Reference) -> DVector<f64> {
    let mut scales = DVector::from_iterator(norms.len(), norms.iter().map(|norm| 1.0 / norm));
    plausible.std_by_column(problem).into_iter().for_each(|(column, std)| scales[column] = std);
    asked.iter().for_each(|(column, limit)| scales[*column] = *limit);
    scales
}

/// Right singular vectors that make up a share of a limit of use that matters.
fn faint_directions(hessian: &DMatrix<f64>, asked: &[(usize, f64)], share: f64) -> Vec<DVector<f64>> {
    let eigen = hessian.clone().symmetric_eigen();
    let directions = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let directions = directions.map(|(square, direction)| (square.max(0.0).sqrt(), direction.clone_owned()));
    let matters = |value: f64, direction: &DVector<f64>| {
        value > NOTHING && asked.iter().any(|(column, _)| direction[*column].abs() > share * value)
    };
    directions.filter(|(value, direction)| matters(*value, direction)).map(|(_, direction)| direction).collect()
}

/// What has an effect.
enum Direction {
    /// Nearly the same at every point, in scaled columns.
    Faint(DVector<f64>),
    /// By which a column errs.
    ErrorOf(usize),
}

impl Direction {
    /// Of length one. `effect`: that at the point before, if there was one.
    fn at(&mut self, point: &Point, effect: Option<f64>) -> Option<DVector<f64>> {
        match self {
            Direction::ErrorOf(column) => point.covariance.column(*column).clone_owned().try_normalize(0.0),
            Direction::Faint(direction) => {
                let Some(effect) = effect else { return Some(direction.clone()) };
                // What has a larger effect than before is left behind.
                let mut shifted = point.hessian.clone();
                (0..shifted.nrows()).for_each(|k| shifted[(k, k)] += effect * effect);
                *direction = shifted.cholesky()?.solve(direction).try_normalize(0.0)?;
                Some(direction.clone())
            }
        }
    }
}

/// What is near an estimate, in scaled columns.
struct Surroundings<'a> {
    problem: &'a Problem,
    scales: DVector<f64>,
    /// Diagonal of `W`.
    firmness: DVector<f64>,
}

/// Values, and what the readings say there in scaled columns.
struct Point {
    values: Values,
    /// ½ χ² of the readings.
    cost: f64,
    gradient: DVector<f64>,
    /// `JᵀJ`.
    hessian: DMatrix<f64>,
    /// `(JᵀJ + W)⁻¹`.
    covariance: DMatrix<f64>,
}

impl Surroundings<'_> {
    /// Nothing where `JᵀJ + W` is no positive definite matrix to the last digit.
    fn point(&self, values: Values) -> Result<Option<Point>, EvaluateError> {
        let linearization = self.problem.linearize(&values)?;
        let (size, scales, hessian) = (self.scales.len(), &self.scales, linearization.hessian());
        let hessian = DMatrix::from_fn(size, size, |i, j| hessian[i * size + j] * scales[i] * scales[j]);
        let gradient = DVector::from_column_slice(linearization.gradient()).component_mul(scales);
        let mut firm = hessian.clone();
        (0..size).for_each(|k| firm[(k, k)] += self.firmness[k] + RIDGE * hessian[(k, k)]);
        let cost = linearization.cost();
        let covariance = firm.cholesky().map(|factor| factor.inverse());
        Ok(covariance.map(|covariance| Point { values, cost, gradient, hessian, covariance }))
    }

    fn retracted(&self, from: &Values, step: &DVector<f64>) -> Values {
        self.problem.retract(from, step.component_mul(&self.scales).as_slice())
    }

    /// Where this direction has less effect, up to [`PLAUSIBLE`] standard deviations away; nearer by, or none, where the readings contradict
    /// what is farther. The way is curved: it is followed in pieces.
    fn where_less(&self, estimate: &Point, mut direction: Direction) -> Result<Option<(Values, f64)>, EvaluateError> {
        let (mut found, mut effect): (Option<Point>, Option<f64>) = (None, None);
        for _ in 0..PLAUSIBLE {
            let here = found.as_ref().unwrap_or(estimate);
            let Some(along) = direction.at(here, effect) else { break };
            let (value, change) = self.effect(&here.values, &along)?;
            effect = Some(value);
            let moved = &here.covariance * &change;
            let std = change.dot(&moved).max(0.0).sqrt();
            if std <= STEADY * value || value < NOTHING {
                break;
            }
            let step = moved * (-(value / std).min(1.0) / std);
            let Some(there) = self.point(self.retracted(&here.values, &step))? else { break };
            let there = self.settled(there, &change)?;
            if there.cost - estimate.cost >= IMPLAUSIBLE {
                break;
            }
            found = Some(there);
        }
        Ok(found.map(|point| (point.values, point.cost - estimate.cost)))
    }

    /// The size of the effect of a direction, and how it changes: `a`, with `s u = J v` by differences of the residuals.
    fn effect(&self, at: &Values, direction: &DVector<f64>) -> Result<(f64, DVector<f64>), EvaluateError> {
        let [there, back] = [DIFFERENCE, -DIFFERENCE].map(|h| self.retracted(at, &(direction * h)));
        let difference = |ahead: Vec<f64>, behind: Vec<f64>| {
            (DVector::from_vec(ahead) - DVector::from_vec(behind)) / (2.0 * DIFFERENCE)
        };
        let effect = difference(self.problem.residuals(&there)?, self.problem.residuals(&back)?);
        let value = effect.norm();
        let unit = effect / value.max(f64::MIN_POSITIVE);
        let product = |values: &Values| self.problem.transposed_product(values, unit.as_slice());
        Ok((value, difference(product(&there)?, product(&back)?).component_mul(&self.scales)))
    }

    /// The rest follows by Gauss-Newton steps that leave `change` as it is: `δ = −C g + C a (aᵀ C g)/(aᵀ C a)`.
    fn settled(&self, mut there: Point, change: &DVector<f64>) -> Result<Point, EvaluateError> {
        for _ in 0..CORRECTIONS {
            let (free, moved) = (&there.covariance * &there.gradient, &there.covariance * change);
            let step = &moved * (change.dot(&free) / change.dot(&moved).max(f64::MIN_POSITIVE)) - free;
            let Ok(Some(corrected)) = self.point(self.retracted(&there.values, &step)) else { break };
            let gained = there.cost - corrected.cost;
            if gained > 0.0 {
                there = corrected;
            }
            if gained < SETTLED {
                break;
            }
        }
        Ok(there)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravcal_estimation::{Automatic, Block, BlockId, Factor, Formula, LocalNumbers, Noise, Number, ProblemBuilder};

    /// Readings of `tilt` itself and of `gain · tilt`: without a tilt nothing is known of the gain.
    #[derive(Debug)]
    struct Tilted {
        blocks: [BlockId; 2],
        tilt: f64,
    }

    impl Formula for Tilted {
        fn blocks(&self) -> &[BlockId] {
            &self.blocks
        }

        fn len(&self) -> usize {
            2
        }

        fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
            let (tilt, gain) = (x.block(0)[0], x.block(1)[0]);
            (residual[0], residual[1]) = (tilt - self.tilt, gain * tilt - self.tilt);
            Ok(())
        }
    }

    /// The tilts at which the readings say nothing of the gain.
    fn judged(tilt: f64) -> Vec<f64> {
        let mut builder = ProblemBuilder::new();
        let blocks =
            [("tilt", tilt), ("gain", 1.0)].map(|(name, value)| builder.add_block(Block::scalar(name, ""), &[value]));
        let residual = Automatic(Tilted { blocks, tilt });
        builder.add_factor(Factor::new(residual, Noise::independent(&[1.0, 1.0]).unwrap()));
        let (problem, values) = builder.build().unwrap();
        let plausible = Reference::new(values.clone()).with(blocks[1], &[0.1]);
        let found = least_informed_nearby((&problem, &values), &[(1, 0.1)], &[1], (&plausible, MATTERS)).unwrap();
        found.iter().map(|(values, _)| values.scalar(blocks[0])).collect()
    }

    #[test]
    fn growth_in_several_directions_counts_as_in_one() {
        // 0.05 of χ²: 3.841 of one degree of freedom, 18.307 of ten (Abramowitz and Stegun, table 26.8).
        assert!((as_of_one_direction(0.5 * 3.841_459, 1, None) - 0.5 * 3.841_459).abs() < 1e-6);
        assert!((as_of_one_direction(0.5 * 18.307_038, 10, None) - 0.5 * 3.841_459).abs() < 1e-6);
        assert!(as_of_one_direction(2.0, 0, None) == 2.0 && as_of_one_direction(1e4, 10, None) > IMPLAUSIBLE);
        assert!(
            as_of_one_direction(0.0, 3, None) == 0.0 && as_of_one_direction(f64::INFINITY, 3, None) == f64::INFINITY
        );
        // The 95 % quantiles of F with 1 and 9, and with 4 and 9 degrees of freedom (Abramowitz and Stegun, table 26.9).
        for (directions, quantile) in [(1, 5.117), (4, 3.633)] {
            let growth = as_of_one_direction(0.5 * directions as f64 * quantile, directions, Some(9.0));
            assert!((growth - 0.5 * 3.841_459).abs() < 1e-3, "{directions}: {growth}");
        }
    }

    #[test]
    fn what_rests_on_a_tilt_within_its_error_is_insignificant() {
        // The tilt is known to about 0.7; three of these are 2.1.
        for tilt in [0.3, 1.0] {
            assert!(judged(tilt).iter().any(|there| there.abs() < 0.3 * tilt), "{:?}", judged(tilt));
        }
        assert!(judged(20.0).is_empty() && judged(40.0).is_empty());
    }
}
