//! Uncertainty from the noise: the model holds, and errors differ only by chance.
//!
//! Without a loss the covariance is `σ² (JᵀJ)⁻¹` of the whitened Jacobian over the determined directions, with σ = 1
//! where the noise was stated, `σ² = Σ r²/(n − p)` where only its ratios are known.
//!
//! With losses it is that of an M-estimator (Huber, *Robust statistics*, 1981, section 7.6, the first of his three
//! forms and his correction K). For the pieces `i` (rows, or whole factors of d rows where their noise is correlated)
//! that have the same loss, with `ψ = ρ′ r`,
//!
//! ```text
//!     m = Σ (d ρ′ + 2 ρ″ s) / n             mean slope of ψ
//!     q = Σ ρ′² s / (n − p)                 mean square of ψ
//!     K = 1 + (p/n) var(slope) / m²
//!
//!     Σ = A⁻¹ B A⁻¹,   A = Σ_losses m JᵀJ,   B = Σ_losses K² q JᵀJ
//! ```
//!
//! `n`, `p`: rows with that loss and how many parameters they take up. With one loss this is `K² q/m² (JᵀJ)⁻¹`. Rows
//! without a loss keep their stated noise (m = q = K = 1).
//!
//! **Assumptions.** The whitened errors under one loss are independent, alike and symmetric, normal or not. Their size
//! cancels: `q` and `m` come from the residuals, so the stated noise only sets where the loss begins. That is why a loss
//! always gives Student's intervals, and why nothing is scaled by χ² on top. Without a loss and with stated noise
//! intervals are normal.
//!
//! **Few residuals** may make the noise that was found from them ([`NoiseScale::Found`]) much too small by chance: `ν s²/σ²` is distributed as χ²
//! with ν degrees of freedom. Student's intervals allow for that. A standard deviation does not, and is therefore multiplied by
//!
//! ```text
//!     max(1, ½ √(ν/χ²_ν(P)))                χ²_ν(P): the quantile of probability P = 0.001
//! ```
//!
//! so that at most one in 1,000 is below half of the right one: by 5.6 with ν = 3, 1.5 with 8, 1 from 17 on. Intervals stay. Several noises that are
//! found from the same residuals share their degrees of freedom: each is taken to have as many as the others. Noises that are alike, and
//! inform one another, count as fewer than they are.

use faer::Mat;
use faer::linalg::solvers::{Llt, Solve};
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

use super::projected::{Piece, Projected, sandwiched};
use super::{Covariance, Quantile, Solution, StatisticsError, Uncertainty};
use crate::Loss;

/// Highest probability with which a standard deviation that was found from the residuals is told below half of the right one.
const TOO_SMALL: f64 = 0.001;

/// What is known of the size of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseScale {
    /// Stated before the residuals were seen: the covariance as it is, normal intervals.
    Stated,
    /// Already found from these residuals: the covariance as it is, larger where they are few; Student's intervals.
    Found {
        /// How many noises share the degrees of freedom, one at least: one of forces and one of moments are two; of several that are alike,
        /// but not one, each counts as a share of one.
        noises: f64,
    },
    /// Stated up to a common factor, which the residuals tell: the covariance is scaled by χ² over its degrees of freedom,
    /// Student's intervals.
    Relative,
}

impl Uncertainty {
    /// The uncertainty that follows from the noise alone.
    ///
    /// # Errors
    /// Where the noise is not stated (or there is a loss) and no residual is left to tell it, or where so much is
    /// forgiven that no minimum is left.
    pub fn from_noise(solution: &Solution<'_>, noise: NoiseScale) -> Result<Uncertainty, StatisticsError> {
        let (rows, rank) = (solution.problem.rows(), solution.analysis.rank());
        let robust = solution.problem.factors().iter().any(|factor| factor.loss != Loss::None);
        if !robust && noise == NoiseScale::Stated {
            return Ok(Uncertainty::with_quantile(solution.analysis.covariance(), Quantile::normal()));
        }
        if rows <= rank {
            return Err(StatisticsError::NoFreedom { rows, rank });
        }
        let shared_by = if let NoiseScale::Found { noises } = noise { noises.max(1.0) } else { 1.0 };
        let freedom = (rows - rank) as f64 / shared_by;
        let covariance = if robust {
            of_m_estimator(solution)?
        } else {
            let plain = solution.analysis.covariance();
            match noise {
                NoiseScale::Relative => {
                    let residuals = solution.problem.residuals(solution.values)?;
                    plain.scaled(residuals.iter().map(|r| r * r).sum::<f64>() / freedom)
                }
                NoiseScale::Stated | NoiseScale::Found { .. } => plain,
            }
        };
        // With a loss, too, the size of the noise is then known by these residuals alone.
        let larger = if matches!(noise, NoiseScale::Found { .. }) { cautious_factor(freedom) } else { 1.0 };
        let quantile = Quantile::student(freedom).for_deviations_larger_by(larger);
        Ok(Uncertainty::with_quantile(covariance.scaled(larger * larger), quantile))
    }
}

/// By what a standard deviation is multiplied that was found with so many degrees of freedom, as chance may have made it too small.
fn cautious_factor(freedom: f64) -> f64 {
    let smallest = |found: ChiSquared| 0.5 * (freedom / found.inverse_cdf(TOO_SMALL)).sqrt();
    ChiSquared::new(freedom).map_or(f64::INFINITY, smallest).max(1.0)
}

/// By what a standard deviation and its interval are larger where the noise behind them was found with `own` degrees of freedom, and not with the `common`
/// ones that they were told with; 1 where that is no fewer.
pub fn larger_for_fewer(own: f64, common: f64) -> f64 {
    // Both may be the same sum, rounded differently.
    if own.is_nan() || own >= common * (1.0 - 1e-9) {
        return 1.0;
    }
    let interval = |freedom: f64| StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
    let factor = (interval(own) / interval(common)).max(cautious_factor(own) / cautious_factor(common));
    if factor.is_finite() { factor } else { f64::MAX.sqrt() }
}

fn of_m_estimator(solution: &Solution<'_>) -> Result<Covariance, StatisticsError> {
    let projected = Projected::new(solution)?;
    let factors = solution.problem.factors();
    let gram = projected.gram(0..factors.len());
    let inverse = Llt::new(gram.as_ref(), faer::Side::Lower).map_err(|_| StatisticsError::NotConvex)?;
    let (mut bread, mut meat) = (Mat::zeros(gram.nrows(), gram.nrows()), Mat::zeros(gram.nrows(), gram.nrows()));
    for loss in different(factors.iter().map(|factor| factor.loss)) {
        let group = || (0..factors.len()).filter(|factor| factors[*factor].loss == loss);
        let own = projected.gram(group());
        let (slope, square) = match loss {
            Loss::None => (1.0, 1.0),
            _ => influence(group().flat_map(|factor| projected.pieces(factor)), trace(&inverse.solve(&own)))?,
        };
        bread += faer::Scale(slope) * &own;
        meat += faer::Scale(square) * &own;
    }
    Ok(projected.covariance(&sandwiched(&bread, &meat)?))
}

fn different(losses: impl Iterator<Item = Loss>) -> Vec<Loss> {
    let mut different = Vec::new();
    for loss in losses {
        if !different.contains(&loss) {
            different.push(loss);
        }
    }
    different
}

/// Mean slope of ψ, and its mean square with Huber's correction, of pieces that take up so many parameters.
fn influence<'p>(pieces: impl Iterator<Item = Piece<'p>>, parameters: f64) -> Result<(f64, f64), StatisticsError> {
    let (mut rows, mut slopes, mut slopes_squared, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for piece in pieces {
        let length = piece.len() as f64;
        let slope = piece.loss.first + 2.0 * piece.loss.second * piece.square / length;
        rows += length;
        slopes += length * slope;
        slopes_squared += length * slope * slope;
        squares += piece.loss.first.powi(2) * piece.square;
    }
    let mean = slopes / rows;
    if mean <= 0.0 || rows <= parameters {
        return Err(StatisticsError::NotConvex);
    }
    let variance = (slopes_squared / rows - mean * mean).max(0.0);
    let correction = 1.0 + parameters / rows * variance / (mean * mean);
    Ok((mean, correction * correction * squares / (rows - parameters)))
}

fn trace(matrix: &Mat<f64>) -> f64 {
    (0..matrix.nrows()).map(|i| matrix[(i, i)]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{fit, fit_robustly, line};

    /// Slope and intercept of a line, by the textbook.
    #[test]
    fn noise_known_up_to_a_factor_is_taken_from_the_residuals() {
        let y = [0.1, 1.3, 1.8, 3.4, 3.9];
        let solved = fit(line(&y));
        let stated = Uncertainty::from_noise(&solved.solution(), NoiseScale::Stated).unwrap();
        let relative = Uncertainty::from_noise(&solved.solution(), NoiseScale::Relative).unwrap();
        // Σ(t − t̄)² = 10, residuals −0.06, 0.17, −0.3, 0.33, −0.14 of 0.04 + 0.97 t − y.
        assert!((stated.covariance().at(1, 1) - 0.1).abs() < 1e-12);
        let variance =
            (0.06_f64.powi(2) + 0.17_f64.powi(2) + 0.3_f64.powi(2) + 0.33_f64.powi(2) + 0.14_f64.powi(2)) / 3.0;
        let ratio = relative.covariance().at(1, 1) / (0.1 * variance);
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        let [low, high] = relative.interval(0.0, &[(1, 1.0)]);
        let student = 3.182_446_305 * (0.1 * variance).sqrt();
        assert!((high - student).abs() < 1e-8 && (low + student).abs() < 1e-8);
        let found = Uncertainty::from_noise(&solved.solution(), NoiseScale::Found { noises: 1.0 }).unwrap();
        assert!(found.interval(0.0, &[(1, 1.0)])[1] > 1.6 * stated.interval(0.0, &[(1, 1.0)])[1]);
    }

    /// Quantiles of χ² as printed: 0.0243 with 3 degrees of freedom, 0.857 with 8.
    #[test]
    fn deviations_that_few_residuals_tell_are_told_larger_and_their_intervals_stay() {
        let solved = fit(line(&[0.1, 1.3, 1.8, 3.4, 3.9]));
        let [stated, found] = [NoiseScale::Stated, NoiseScale::Found { noises: 1.0 }]
            .map(|n| Uncertainty::from_noise(&solved.solution(), n).unwrap());
        let larger = found.covariance().std_of(&[(1, 1.0)]) / stated.covariance().std_of(&[(1, 1.0)]);
        assert!((larger - 0.5 * (3.0_f64 / 0.0243).sqrt()).abs() < 2e-3 * larger, "{larger}");
        let width = found.interval(0.0, &[(1, 1.0)])[1] / stated.covariance().std_of(&[(1, 1.0)]);
        assert!((width - 3.182_446_305).abs() < 1e-6, "{width}");
        assert!((cautious_factor(8.0) - 0.5 * (8.0_f64 / 0.857).sqrt()).abs() < 1e-3);
        assert_eq!([17.0, 100.0, 1e6].map(cautious_factor), [1.0; 3]);
        // Two noises have one and a half each.
        let two = Uncertainty::from_noise(&solved.solution(), NoiseScale::Found { noises: 2.0 }).unwrap();
        let larger = two.covariance().std_of(&[(1, 1.0)]) / stated.covariance().std_of(&[(1, 1.0)]);
        assert!((larger / cautious_factor(1.5) - 1.0).abs() < 1e-12 && larger > 10.0, "{larger}");
    }

    #[test]
    fn deviations_with_a_loss_are_told_as_much_larger() {
        let solved = fit_robustly(&[-0.5, 0.4, 0.1, -0.3, 0.2, 0.6, -0.6, 30.0], Loss::Huber(1.0));
        let [stated, found] = [NoiseScale::Stated, NoiseScale::Found { noises: 1.0 }]
            .map(|n| Uncertainty::from_noise(&solved.solution(), n).unwrap());
        let larger = found.covariance().std_of(&[(0, 1.0)]) / stated.covariance().std_of(&[(0, 1.0)]);
        assert!((larger - cautious_factor(7.0)).abs() < 1e-12 && larger > 1.5, "{larger}");
        let [of_stated, of_found] = [stated, found].map(|known| known.interval(0.0, &[(0, 1.0)])[1]);
        assert!((of_found / of_stated - 1.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_residual_left_there_is_no_noise_to_estimate() {
        let solved = fit(line(&[1.0, 2.0]));
        assert!(Uncertainty::from_noise(&solved.solution(), NoiseScale::Stated).is_ok());
        let refused = Uncertainty::from_noise(&solved.solution(), NoiseScale::Found { noises: 1.0 }).unwrap_err();
        assert_eq!(refused, StatisticsError::NoFreedom { rows: 2, rank: 2 });
    }

    /// Huber's formula by hand, for the level of readings of which one is far out.
    /// Student's t of three degrees of freedom is 3.18, of 270 it is 1.97; the factor of three is 5.6.
    #[test]
    fn fewer_degrees_of_freedom_make_larger_deviations() {
        assert!((larger_for_fewer(3.0, 270.0) - 5.6).abs() < 0.05, "{}", larger_for_fewer(3.0, 270.0));
        assert!((larger_for_fewer(20.0, 1e4) - 2.086 / 1.960).abs() < 1e-3, "{}", larger_for_fewer(20.0, 1e4));
        assert_eq!([larger_for_fewer(30.0, 30.0), larger_for_fewer(f64::INFINITY, 30.0)], [1.0; 2]);
        assert!(larger_for_fewer(0.0, 30.0) > 1e6);
    }

    #[test]
    fn a_loss_takes_the_size_of_the_noise_from_the_residuals() {
        let y = [-0.5, 0.4, 0.1, -0.3, 0.2, 0.6, -0.6, 30.0];
        let solved = fit_robustly(&y, Loss::Huber(1.0));
        let level = solved.values.as_slice()[0];
        assert!((level - (1.0 - 0.1) / 7.0).abs() < 1e-9, "{level}"); // seven inside, one pulls with force 1
        let uncertainty = Uncertainty::from_noise(&solved.solution(), NoiseScale::Stated).unwrap();
        let (n, m) = (8.0, 7.0 / 8.0);
        let squares: f64 = y[..7].iter().map(|y| (y - level).powi(2)).sum::<f64>() + 1.0;
        let correction = 1.0 + 1.0 / n * (m - m * m) / (m * m);
        let expected = correction * correction * squares / (n - 1.0) / (m * m) / n;
        let found = uncertainty.covariance().at(0, 0);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
}
