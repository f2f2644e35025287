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
//! where nothing moved, any sensor at all is named with probability [`SIGNIFICANCE`] at most, and a tenth of it more by the test of all together.
//!
//! Covariances that leaving out blocks of poses told have only as many degrees of freedom as there were blocks, less one (ν, the fewest
//! of all calibrations). Then `χ²/d · (ν − p + 1)/ν` is held against F with d and ν − p + 1 degrees of freedom, as Hotelling's T² is.
//!
//! **Beside the others.** What moved by less than its own uncertainty is seen where that is common to all sensors (`beside_others.rs`).
//!
//! **Doubts.** What moved by errors of a model has not moved: where intervals of a calibration may not hold, that is told before any sensor
//! is named ([`Comparison::doubts`]).
//!
//! **Assumptions.** Calibrations of different recordings (a reading in two of them counts as agreement), errors that are normal with the
//! stated covariance. What all share (a load's mass, lengths of links, a prior) is no part of a difference and does not count as one.
//!
//! **Gravity** of known magnitude has no variance along itself: then its direction is compared, in the plane across the mean one. It
//! stands in the frame of the base, which the position offset of the first joint defines: a move of that offset looks like one of gravity
//! ([`Comparison::base_frame`]).
//!
//! **What is not seen.** A parameter that any of the calibrations holds or leaves open may have moved unnoticed:
//! [`Comparison::not_seen`].

mod beside_others;
mod compared;
mod homogeneity;
mod sensor;
#[cfg(test)]
mod tests;

use gravcal_recording::EarlierEstimate;
use gravcal_robot_model::session::BASE_FRAME_CHOICE;

pub use compared::{
    BesideOthers, ComparedParameter, Comparison, ComparisonError, GRAVITY, HomogeneityTest, LeftOut, SIGNIFICANCE,
    SensorComparison,
};

use homogeneity::test;
use sensor::{Sensor, sensors};

/// Compares calibrations of one robot, in the order of their time.
///
/// # Errors
/// See [`ComparisonError`].
pub fn compare(calibrations: &[&EarlierEstimate]) -> Result<Comparison, ComparisonError> {
    if calibrations.len() < 2 {
        return Err(ComparisonError::One);
    }
    let freedom = calibrations.iter().filter_map(|one| one.blocks_left_out).min().map(|blocks| blocks as f64 - 1.0);
    let mut sensors: Vec<SensorComparison> =
        sensors(calibrations)?.into_iter().map(|sensor| tested(sensor, freedom)).collect();
    if sensors.iter().all(|sensor| sensor.name == GRAVITY || !sensor.in_all) {
        return Err(ComparisonError::NoSensorInCommon);
    }
    if sensors.iter().all(|sensor| sensor.test.is_none()) {
        return Err(ComparisonError::NothingInCommon);
    }
    correct(&mut sensors);
    beside_others::name_moved(calibrations, &mut sensors, freedom);
    let doubts = calibrations.iter().map(|calibration| calibration.doubts.clone()).collect();
    Ok(Comparison { sensors, base_frame: base_frame(calibrations), doubts })
}

/// `freedom`: degrees of freedom of the covariances where they were found by leaving out blocks.
fn tested(sensor: Sensor, freedom: Option<f64>) -> SensorComparison {
    let Sensor { name, mut parameters, mut left_out, in_all, models_differ_in, estimates } = sensor;
    let test = estimates.as_ref().and_then(|estimates| test(estimates, freedom));
    if estimates.is_some() && test.is_none() {
        let why = "is not compared: its covariances cannot be inverted".to_owned();
        left_out.push(LeftOut { name: name.clone(), why, can_move: true });
        parameters.clear();
    }
    SensorComparison { name, parameters, left_out, in_all, models_differ_in, test, beside_others: None }
}

fn base_frame(calibrations: &[&EarlierEstimate]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for parameter in calibrations.iter().flat_map(|calibration| &calibration.parameters) {
        if parameter.held.as_deref() == Some(BASE_FRAME_CHOICE) && !names.contains(&parameter.name) {
            names.push(parameter.name.clone());
        }
    }
    names
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
