//! How uncertain a measurement is.

use faer::Mat;
use faer::linalg::solvers::Llt;
use thiserror::Error;

/// Covariance of the error of one factor's measurements, in the unit of the reading.
#[derive(Clone, Debug)]
pub enum Noise {
    /// Independent rows; the inverse of each row's standard deviation.
    Independent {
        /// `1/σ` of each row.
        weights: Vec<f64>,
    },
    /// Correlated rows with covariance `Σ = L Lᵀ`.
    Correlated {
        /// `L⁻¹`, row-major.
        whitener: Vec<f64>,
    },
}

/// A covariance that is none.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NoiseError {
    /// A standard deviation that is zero, negative or not finite.
    #[error("standard deviation {0} of row {1} must be positive and finite")]
    StandardDeviation(f64, usize),
    /// A covariance matrix that is not symmetric positive definite.
    #[error("the covariance of {0} correlated readings is not positive definite")]
    NotPositiveDefinite(usize),
}

impl Noise {
    /// Independent rows with the standard deviations `std`.
    ///
    /// # Errors
    /// Where one of them is not positive and finite.
    pub fn independent(std: &[f64]) -> Result<Self, NoiseError> {
        if let Some(row) = std.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
            return Err(NoiseError::StandardDeviation(std[row], row));
        }
        Ok(Noise::Independent { weights: std.iter().map(|s| 1.0 / s).collect() })
    }

    /// Correlated rows with the given covariance, row-major.
    ///
    /// # Errors
    /// Where it is not positive definite.
    pub fn correlated(covariance: &[f64], rows: usize) -> Result<Self, NoiseError> {
        let matrix = Mat::from_fn(rows, rows, |i, j| covariance[i * rows + j]);
        let factor = Llt::new(matrix.as_ref(), faer::Side::Lower).map_err(|_| NoiseError::NotPositiveDefinite(rows))?;
        let mut inverse = Mat::<f64>::identity(rows, rows);
        factor.L().solve_lower_triangular_in_place(inverse.as_mut());
        let whitener: Vec<f64> = (0..rows * rows).map(|k| inverse[(k / rows, k % rows)]).collect();
        if whitener.iter().all(|w| w.is_finite()) {
            Ok(Noise::Correlated { whitener })
        } else {
            Err(NoiseError::NotPositiveDefinite(rows))
        }
    }

    /// Number of rows it describes.
    pub fn rows(&self) -> usize {
        match self {
            Noise::Independent { weights } => weights.len(),
            Noise::Correlated { whitener } => (whitener.len() as f64).sqrt().round() as usize,
        }
    }

    /// Whitens rows of `width` numbers in place; afterwards each row has unit variance and no correlation.
    pub(crate) fn whiten(&self, rows: &mut [f64], width: usize) {
        match self {
            Noise::Independent { weights } => {
                for (row, weight) in rows.chunks_exact_mut(width).zip(weights) {
                    row.iter_mut().for_each(|v| *v *= weight);
                }
            }
            Noise::Correlated { whitener } => {
                let n = self.rows();
                // L⁻¹ is lower triangular: from the last row up, each result needs only rows not yet overwritten.
                for i in (0..n).rev() {
                    for column in 0..width {
                        rows[i * width + column] =
                            (0..=i).map(|j| whitener[i * n + j] * rows[j * width + column]).sum();
                    }
                }
            }
        }
    }
}

impl Noise {
    /// The reverse of whitening, in place: what has unit variance and no correlation becomes an error of the readings.
    pub(crate) fn unwhiten(&self, rows: &mut [f64]) {
        match self {
            Noise::Independent { weights } => rows.iter_mut().zip(weights).for_each(|(v, weight)| *v /= weight),
            Noise::Correlated { whitener } => {
                let n = self.rows();
                for i in 0..n {
                    let known: f64 = (0..i).map(|j| whitener[i * n + j] * rows[j]).sum();
                    rows[i] = (rows[i] - known) / whitener[i * (n + 1)];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_makes_the_quadratic_form_of_the_inverse_covariance() {
        let covariance = [4.0, 1.2, 1.2, 9.0];
        let noise = Noise::correlated(&covariance, 2).unwrap();
        let mut r = [1.5, -2.0];
        let determinant = 4.0 * 9.0 - 1.2 * 1.2;
        let expected = (9.0 * 1.5 * 1.5 - 2.0 * 1.2 * 1.5 * -2.0 + 4.0 * 4.0) / determinant;
        noise.whiten(&mut r, 1);
        assert!((r[0] * r[0] + r[1] * r[1] - expected).abs() < 1e-14);
    }

    #[test]
    fn unwhitening_undoes_whitening() {
        let correlated = Noise::correlated(&[4.0, 1.2, 1.2, 9.0], 2).unwrap();
        for noise in [correlated, Noise::independent(&[2.0, 3.0]).unwrap()] {
            let mut r = [1.5, -2.0];
            noise.unwhiten(&mut r);
            noise.whiten(&mut r, 1);
            assert!((r[0] - 1.5).abs() < 1e-14 && (r[1] + 2.0).abs() < 1e-14, "{r:?}");
        }
    }

    #[test]
    fn impossible_noise_is_refused() {
        assert_eq!(Noise::independent(&[1.0, 0.0]).unwrap_err(), NoiseError::StandardDeviation(0.0, 1));
        assert!(Noise::independent(&[f64::NAN]).is_err());
        assert_eq!(Noise::correlated(&[1.0, 2.0, 2.0, 1.0], 2).unwrap_err(), NoiseError::NotPositiveDefinite(2));
    }
}
