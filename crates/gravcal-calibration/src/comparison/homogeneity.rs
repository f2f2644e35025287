//! Whether calibrations have one value of some parameters.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use super::compared::HomogeneityTest;
use super::sensor::Estimates;

/// χ² of one value for all, its degrees of freedom, and the probability of one at least as large. `None` where a covariance cannot be inverted.
pub(super) fn homogeneous(estimates: &Estimates, freedom: Option<f64>) -> Option<(f64, usize, f64)> {
    let weights: Vec<DMatrix<f64>> = estimates
        .covariances
        .iter()
        .map(|covariance| Some(covariance.clone().cholesky()?.inverse()))
        .collect::<Option<_>>()?;
    let size = estimates.values.first()?.len();
    let sum = weights.iter().fold(DMatrix::zeros(size, size), |sum, weight| sum + weight);
    let weighted = weights.iter().zip(&estimates.values).fold(DVector::zeros(size), |sum, (w, x)| sum + w * x);
    let mean = sum.cholesky()?.solve(&weighted);
    let of = |(weight, value): (&DMatrix<f64>, &DVector<f64>)| (value - &mean).dot(&(weight * (value - &mean)));
    let chi_squared: f64 = weights.iter().zip(&estimates.values).map(of).sum();
    let degrees_of_freedom = (estimates.values.len() - 1) * size;
    let p_value = probability(chi_squared, degrees_of_freedom as f64, size as f64, freedom)?;
    Some((chi_squared, degrees_of_freedom, p_value))
}

/// `None` where a covariance cannot be inverted.
pub(super) fn test(estimates: &Estimates, freedom: Option<f64>) -> Option<HomogeneityTest> {
    let (chi_squared, degrees_of_freedom, p_value) = homogeneous(estimates, freedom)?;
    let steps: Option<Vec<f64>> = (1..estimates.values.len()).map(|next| step(estimates, next)).collect();
    let largest = steps?.into_iter().enumerate().fold((0, 0.0), |most, step| if step.1 > most.1 { step } else { most });
    Some(HomogeneityTest {
        chi_squared,
        degrees_of_freedom,
        p_value,
        corrected_p_value: p_value,
        moved: false,
        largest_step: largest,
    })
}

/// Probability of a χ² at least as large; `None` where covariances have too few degrees of freedom for so many parameters.
fn probability(chi_squared: f64, degrees_of_freedom: f64, parameters: f64, freedom: Option<f64>) -> Option<f64> {
    let Some(freedom) = freedom else { return Some(ChiSquared::new(degrees_of_freedom).ok()?.sf(chi_squared)) };
    let left = freedom - parameters + 1.0;
    let statistic = chi_squared / degrees_of_freedom * left / freedom;
    Some(FisherSnedecor::new(degrees_of_freedom, left).ok()?.sf(statistic))
}

/// χ² of the difference to the calibration before.
fn step(estimates: &Estimates, next: usize) -> Option<f64> {
    let difference = &estimates.values[next] - &estimates.values[next - 1];
    let covariance = &estimates.covariances[next] + &estimates.covariances[next - 1];
    Some(difference.dot(&covariance.cholesky()?.solve(&difference)))
}
