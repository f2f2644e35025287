//! Intervals.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::result::GravityResult;

/// Factor between a standard deviation and the half-width of a 95 % interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantile(f64);

impl Quantile {
    /// Normal where the noise was stated; Student's t where it was estimated with these degrees of freedom.
    pub fn new(noise_estimated: bool, degrees_of_freedom: usize) -> Quantile {
        let student = || StudentsT::new(0.0, 1.0, degrees_of_freedom as f64).ok().map(|t| t.inverse_cdf(0.975));
        let normal = || Normal::new(0.0, 1.0).ok().map(|n| n.inverse_cdf(0.975));
        Quantile(if noise_estimated { student() } else { normal() }.unwrap_or(f64::NAN))
    }

    /// 95 % interval.
    pub fn interval(self, value: f64, std: f64) -> [f64; 2] {
        [value - self.0 * std, value + self.0 * std]
    }
}

/// Gravity with its covariance (3 × 3, row-major), m/s².
///
/// The cone holds a χ² with two degrees of freedom: its half-angle is `√(−2 ln 0.05)` times the largest standard
/// deviation across the vector, so that it covers at least 95 %.
pub(crate) fn gravity_result(vector: [f64; 3], covariance: &[f64], asked: bool) -> GravityResult {
    let matrix = nalgebra::Matrix3::from_row_slice(covariance);
    let norm = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
    let unit = nalgebra::Vector3::from(vector) / norm;
    let across = nalgebra::Matrix3::identity() - unit * unit.transpose();
    let largest = (across * matrix * across).symmetric_eigenvalues().max().max(0.0).sqrt();
    let half_angle = (-2.0 * 0.05_f64.ln()).sqrt() * largest / norm;
    GravityResult {
        vector_m_per_s2: vector,
        std_m_per_s2: std::array::from_fn(|i| covariance[4 * i].max(0.0).sqrt()),
        cone95_deg: half_angle.to_degrees(),
        asked,
    }
}
