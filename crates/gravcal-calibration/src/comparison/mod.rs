//! Which sensor moved between calibrations of one robot.
//!
//! Of each sensor (and of gravity) the parameters `x_i` that all calibrations estimated are held against one value for all,
//!
//! ```text
//!     x̄ = (Σ C_i⁻¹)⁻¹ Σ C_i⁻¹ x_i          χ² = Σ (x_i − x̄)ᵀ C_i⁻¹ (x_i − x̄)
//! ```
//!
//! with `C_i` their covariance. If nothing moved, and the calibrations are independent, χ² has `(N − 1) p` degrees of freedom; for two
//! calibrations it is `(x_a − x_b)ᵀ (C_a + C_b)⁻¹ (x_a − x_b)`. As there are many sensors, p-values are corrected by Holm's method:
//! where nothing moved, any sensor at all is named with probability [`SIGNIFICANCE`] at most.
//!
//! **Assumptions.** Calibrations of different recordings (a reading in two of them counts as agreement), errors that are normal with the
//! stated covariance. What all share (a load's mass, lengths of links, a prior) is no part of a difference and does not count as one.
//!
//! **Gravity** of known magnitude has no variance along itself: then its direction is compared, in the plane across the mean one.

mod sensor;
#[cfg(test)]
mod tests;

use gravcal_recording::EarlierEstimate;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use thiserror::Error;

use sensor::{Estimates, Sensor, sensors};

/// Probability with which any sensor at all is named where none has moved.
pub const SIGNIFICANCE: f64 = 0.01;

/// Calibrations cannot be compared.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ComparisonError {
    /// One alone.
    #[error("a comparison takes two calibrations or more")]
    One,
    /// They have nothing in common.
    #[error("no parameter is estimated by all of these calibrations: are they of one robot?")]
    NothingInCommon,
    /// A parameter in different units.
    #[error("{name} is in {first} in one calibration and in {other} in another: its sensor's unit has changed")]
    Units {
        /// The parameter.
        name: String,
        /// One unit.
        first: String,
        /// Another.
        other: String,
    },
}

/// What a comparison comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Gravity first, then the sensors in the order of the first calibration.
    pub sensors: Vec<SensorComparison>,
}

/// One sensor in all calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorComparison {
    /// `joint1 torque`, `joint1 position`, `gravity`, or an instrument's name.
    pub name: String,
    /// The parameters that are compared.
    pub parameters: Vec<ComparedParameter>,
    /// Parameters that are not compared, each with the reason.
    pub left_out: Vec<String>,
    /// Absent where nothing of it can be compared.
    pub test: Option<HomogeneityTest>,
}

/// A parameter in all calibrations.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedParameter {
    /// `joint1.torque_gain`.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// By calibration.
    pub values: Vec<f64>,
    /// Standard deviations, by calibration.
    pub stds: Vec<f64>,
}

/// How unlikely such differences are, if the sensor has not moved.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneityTest {
    /// χ².
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of a χ² at least as large.
    pub p_value: f64,
    /// The same corrected for the number of sensors, by Holm's method.
    pub corrected_p_value: f64,
    /// Whether that is below [`SIGNIFICANCE`].
    pub moved: bool,
    /// Of more than two calibrations, the one after which the sensor moved most (its index), with the χ² of that step.
    pub largest_step: (usize, f64),
}

impl Comparison {
    /// The sensors that moved.
    pub fn moved(&self) -> impl Iterator<Item = &SensorComparison> {
        self.sensors.iter().filter(|sensor| sensor.test.as_ref().is_some_and(|test| test.moved))
    }

    /// How many sensors were tested.
    pub fn tests(&self) -> usize {
        self.sensors.iter().filter(|sensor| sensor.test.is_some()).count()
    }
}

/// Compares calibrations of one robot, in the order of their time.
///
/// # Errors
/// See [`ComparisonError`].
pub fn compare(calibrations: &[&EarlierEstimate]) -> Result<Comparison, ComparisonError> {
    if calibrations.len() < 2 {
        return Err(ComparisonError::One);
    }
    let mut compared = Vec::new();
    for Sensor { name, parameters, left_out, estimates } in sensors(calibrations)? {
        let test = estimates.and_then(|estimates| test(&estimates));
        compared.push(SensorComparison { name, parameters, left_out, test });
    }
    if compared.iter().all(|sensor| sensor.test.is_none()) {
        return Err(ComparisonError::NothingInCommon);
    }
    correct(&mut compared);
    Ok(Comparison { sensors: compared })
}

/// `None` where a covariance is singular.
fn test(estimates: &Estimates) -> Option<HomogeneityTest> {
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
    let p_value = ChiSquared::new(degrees_of_freedom as f64).ok()?.sf(chi_squared);
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

/// χ² of the difference to the calibration before.
fn step(estimates: &Estimates, next: usize) -> Option<f64> {
    let difference = &estimates.values[next] - &estimates.values[next - 1];
    let covariance = &estimates.covariances[next] + &estimates.covariances[next - 1];
    Some(difference.dot(&covariance.cholesky()?.solve(&difference)))
}

/// Holm's method: the k-th smallest of m p-values counts m − k + 1 times, and no less than a smaller one.
fn correct(sensors: &mut [SensorComparison]) {
    let mut tests: Vec<&mut HomogeneityTest> = sensors.iter_mut().filter_map(|sensor| sensor.test.as_mut()).collect();
    tests.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    let (count, mut least) = (tests.len(), 0.0_f64);
    for (place, test) in tests.into_iter().enumerate() {
        least = least.max(((count - place) as f64 * test.p_value).min(1.0));
        test.corrected_p_value = least;
        test.moved = least < SIGNIFICANCE;
    }
}
