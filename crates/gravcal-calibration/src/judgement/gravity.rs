//! Gravity with its uncertainty.

use crate::result::GravityResult;

/// Gravity with its covariance (3 × 3, row-major) and the 95 % interval of each component, m/s².
///
/// The cone holds the direction with 95 % probability at least. `radius` is that of a disc that does so, where the
/// larger standard deviation across the vector is that along a unit vector: `radius(std, along)`, m/s².
pub(crate) fn gravity_result(
    vector: [f64; 3],
    covariance: &[f64],
    ci95: [[f64; 2]; 3],
    asked: bool,
    radius: impl Fn(f64, [f64; 3]) -> f64,
) -> GravityResult {
    let matrix = nalgebra::Matrix3::from_row_slice(covariance);
    let norm = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
    let unit = nalgebra::Vector3::from(vector) / norm;
    let across = nalgebra::Matrix3::identity() - unit * unit.transpose();
    let eigen = (across * matrix * across).symmetric_eigen();
    let widest = eigen.eigenvalues.imax();
    let std = eigen.eigenvalues[widest].max(0.0).sqrt();
    let half_angle = radius(std, eigen.eigenvectors.column(widest).into_owned().into()) / norm;
    GravityResult {
        vector_m_per_s2: vector,
        std_m_per_s2: std::array::from_fn(|i| covariance[4 * i].max(0.0).sqrt()),
        ci95_m_per_s2: ci95,
        cone95_deg: half_angle.to_degrees(),
        asked,
    }
}
