//! Directions whose effect on the readings is not significantly different from none.
//!
//! At an estimate, which noise moves, a direction that has no effect at the truth has some: an upright base comes out a little tilted, a
//! joint that stands at zero a little off it. Its singular value `s = uᵀ J v` is then made of that error, and a standard deviation that rests on
//! it says nothing. To first order `s` changes with the unknowns by
//!
//! ```text
//!     a = ∂(uᵀ J v)/∂x = uᵀ (J(x + h v) − J(x − h v)) / 2h,      var s = aᵀ (JᵀJ + W)⁻¹ a
//! ```
//!
//! as second derivatives commute; u and v are those of the estimate, and `W` is the reference prior, as narrow as what would be of use, for what
//! the readings leave open. Where `s` is within [`SIGNIFICANT`] of its standard deviations of zero, the truth may be where it *is* zero: the
//! nearest such point,
//!
//! ```text
//!     x* = x − C a s / (aᵀ C a),      C = (JᵀJ + W)⁻¹
//! ```
//!
//! is judged as the estimate is, and what is not determined there is not determined.

use gravcal_estimation::{EvaluateError, Problem, Reference, Values};
use nalgebra::{DMatrix, DVector};

/// Standard deviations from zero at which a singular value is one.
const SIGNIFICANT: f64 = 3.0;
/// Growth of ½ χ² beyond which values are not plausible: twice the standard deviations above.
const IMPLAUSIBLE: f64 = 18.0;
/// Only directions that make up this share of a limit of use are looked at.
pub(crate) const MATTERS: f64 = 0.05;
/// Length of the step of a difference, in limits of use.
const DIFFERENCE: f64 = 1e-3;
/// A singular value in limits of use below this is nothing: the rank tells of it.
const NOTHING: f64 = 1e-3;
/// Problems with more columns are not looked at: such have unknowns of single poses, which have knowledge of their own.
const MOST_COLUMNS: usize = 400;

/// The nearest plausible values at which a direction that matters has no effect, one for each such direction. `asked`: column and limit of use of
/// what is asked for; `plausible`: where unknowns lie of which the readings say nothing.
///
/// # Errors
/// Where a residual cannot be evaluated nearby.
pub(crate) fn degenerate_nearby(
    (problem, values): (&Problem, &Values),
    asked: &[(usize, f64)],
    plausible: &Reference,
) -> Result<Vec<Values>, EvaluateError> {
    if problem.columns().len() > MOST_COLUMNS {
        return Ok(Vec::new());
    }
    let alone = problem.without_reference();
    let linearization = alone.linearize(values)?;
    let scales = scales(problem, &linearization.column_scales(), asked, plausible);
    let faint = faint_directions(&linearization.hessian(), asked, &scales);
    if faint.is_empty() {
        return Ok(Vec::new());
    }
    let Some(covariance) = plausible_covariance(problem, values, plausible)? else { return Ok(Vec::new()) };
    let (here, mut found) = (linearization.cost(), Vec::new());
    for (value, direction) in faint {
        let step: Vec<f64> = direction.iter().zip(&scales).map(|(v, scale)| v * scale).collect();
        let change = DVector::from_vec(change_of_effect(problem, values, &step, DIFFERENCE)?);
        let moved = &covariance * &change;
        let variance = change.dot(&moved).max(0.0);
        if value * value < SIGNIFICANT * SIGNIFICANT * variance {
            let back: Vec<f64> = moved.iter().map(|entry| -entry * value / variance).collect();
            let there = problem.retract(values, &back);
            // Farther than the linear model says, the truth is not there.
            if alone.cost(&there).is_ok_and(|cost| cost - here < IMPLAUSIBLE) {
                found.push(there);
            }
        }
    }
    Ok(found)
}

/// What a step of one is by each column: a limit of use of what is asked for, what is plausible of the rest.
fn scales(problem: &Problem, norms: &[f64], asked: &[(usize, f64)], plausible: &Reference) -> Vec<f64> {
    let mut scales: Vec<f64> = norms.iter().map(|norm| 1.0 / norm).collect();
    plausible.std_by_column(problem).into_iter().for_each(|(column, std)| scales[column] = std);
    asked.iter().for_each(|(column, limit)| scales[*column] = *limit);
    scales
}

/// Singular values and right singular vectors, in these scales, of directions that make up a share of a limit of use that matters.
fn faint_directions(hessian: &[f64], asked: &[(usize, f64)], scales: &[f64]) -> Vec<(f64, Vec<f64>)> {
    let size = scales.len();
    let scaled = DMatrix::from_fn(size, size, |i, j| hessian[i * size + j] * scales[i] * scales[j]);
    let eigen = scaled.symmetric_eigen();
    let directions = (0..size).map(|k| (eigen.eigenvalues[k].max(0.0).sqrt(), eigen.eigenvectors.column(k)));
    let matters = |value: f64, direction: &[f64]| {
        asked.iter().any(|(column, _)| direction[*column].abs() > MATTERS * value) && value > NOTHING
    };
    let all = directions.map(|(value, direction)| (value, direction.iter().copied().collect::<Vec<f64>>()));
    all.filter(|(value, direction)| matters(*value, direction)).collect()
}

/// `a`, with `s u = J v` by differences of the residuals.
fn change_of_effect(problem: &Problem, values: &Values, step: &[f64], h: f64) -> Result<Vec<f64>, EvaluateError> {
    let [there, back] = [h, -h].map(|h| problem.retract(values, &step.iter().map(|c| h * c).collect::<Vec<f64>>()));
    let [ahead, behind] = [problem.residuals(&there)?, problem.residuals(&back)?];
    let effect: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect();
    let length = effect.iter().map(|e| e * e).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let unit: Vec<f64> = effect.iter().map(|e| e / length).collect();
    let [ahead, behind] = [problem.transposed_product(&there, &unit)?, problem.transposed_product(&back, &unit)?];
    Ok(ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h)).collect())
}

/// `(JᵀJ + W)⁻¹`; nothing where that is no positive definite matrix to the last digit.
fn plausible_covariance(
    problem: &Problem,
    values: &Values,
    plausible: &Reference,
) -> Result<Option<DMatrix<f64>>, EvaluateError> {
    let problem = problem.with_reference(plausible.clone());
    let linearization = problem.linearize(values)?;
    let (size, scales) = (problem.columns().len(), linearization.column_scales());
    let hessian = linearization.hessian();
    let scaled = DMatrix::from_fn(size, size, |i, j| hessian[i * size + j] / scales[i] / scales[j]);
    let ridge = DMatrix::identity(size, size) * 1e-14;
    let inverse = (scaled + ridge).cholesky().map(|factor| factor.inverse());
    Ok(inverse.map(|inverse| DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] / scales[i] / scales[j])))
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
        let found = degenerate_nearby((&problem, &values), &[(1, 0.1)], &plausible).unwrap();
        found.iter().map(|values| values.scalar(blocks[0])).collect()
    }

    #[test]
    fn what_rests_on_a_tilt_within_its_error_is_insignificant() {
        // The tilt is known to about 0.7; three of these are 2.1.
        for tilt in [0.3, 1.0] {
            assert!(judged(tilt).iter().any(|there| there.abs() < 0.3 * tilt), "{:?}", judged(tilt));
        }
        assert!(judged(10.0).is_empty() && judged(40.0).is_empty());
    }
}
