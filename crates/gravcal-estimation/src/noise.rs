//! How uncertain a measurement is.

use std::sync::Arc;

use faer::Mat;
use faer::linalg::solvers::Llt;
use thiserror::Error;

/// Share by which both halves of a covariance matrix may differ: rounding.
const ASYMMETRY: f64 = 1e-9;

/// Covariance of the error of one factor's measurements, in the unit of the reading.
#[derive(Clone, Debug)]
pub enum Noise {
    /// Independent rows: see [`Noise::independent`].
    Independent(Weights),
    /// Correlated rows: see [`Noise::correlated`].
    Correlated(Whitener),
}

/// `1/σ` of each row, positive and finite.
#[derive(Clone, Debug)]
pub struct Weights(pub(crate) Arc<[f64]>);

/// `L⁻¹` of a covariance `Σ = L Lᵀ`, row-major.
#[derive(Clone, Debug)]
pub struct Whitener(pub(crate) Vec<f64>);

/// A covariance that is none.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum NoiseError {
    /// A standard deviation that is zero, negative or not finite, or so small that its inverse is not.
    #[error("standard deviation {0} of row {1} must be positive and finite, and so must its inverse")]
    StandardDeviation(f64, usize),
    /// A covariance matrix of the wrong size.
    #[error("the covariance of {rows} correlated readings has {numbers} numbers, not {}", rows * rows)]
    Size {
        /// How many numbers there are.
        numbers: usize,
        /// Of how many readings.
        rows: usize,
    },
    /// A covariance matrix that is not symmetric.
    #[error("the covariance of readings {0} and {1} is stated twice, and not the same: {2} and {3}")]
    Asymmetric(usize, usize, f64, f64),
    /// A covariance matrix that is not positive definite.
    #[error("the covariance of {0} correlated readings is not positive definite")]
    NotPositiveDefinite(usize),
}

impl Noise {
    /// Independent rows with the standard deviations `std`.
    ///
    /// # Errors
    /// Where one of them is not positive and finite, or its inverse is not.
    pub fn independent(std: &[f64]) -> Result<Self, NoiseError> {
        let sound = |s: &f64| s.is_finite() && *s > 0.0 && s.recip().is_finite();
        match std.iter().position(|s| !sound(s)) {
            Some(row) => Err(NoiseError::StandardDeviation(std[row], row)),
            None => Ok(Noise::Independent(Weights(std.iter().map(|s| 1.0 / s).collect()))),
        }
    }

    /// Correlated rows with the given covariance, row-major.
    ///
    /// # Errors
    /// Where it is not a symmetric and positive definite matrix of `rows · rows` numbers.
    pub fn correlated(covariance: &[f64], rows: usize) -> Result<Self, NoiseError> {
        if covariance.len() != rows * rows {
            return Err(NoiseError::Size { numbers: covariance.len(), rows });
        }
        for (i, j) in (0..rows).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let (below, above) = (covariance[i * rows + j], covariance[j * rows + i]);
            if (below - above).abs() > ASYMMETRY * below.abs().max(above.abs()) {
                return Err(NoiseError::Asymmetric(i, j, below, above));
            }
        }
        let matrix = Mat::from_fn(rows, rows, |i, j| covariance[i * rows + j]);
        let factor = Llt::new(matrix.as_ref(), faer::Side::Lower).map_err(|_| NoiseError::NotPositiveDefinite(rows))?;
        let mut inverse = Mat::<f64>::identity(rows, rows);
        factor.L().solve_lower_triangular_in_place(inverse.as_mut());
        let whitener: Vec<f64> = (0..rows * rows).map(|k| inverse[(k / rows, k % rows)]).collect();
        if whitener.iter().all(|w| w.is_finite()) {
            Ok(Noise::Correlated(Whitener(whitener)))
        } else {
            Err(NoiseError::NotPositiveDefinite(rows))
        }
    }

    /// Number of rows it describes.
    pub fn rows(&self) -> usize {
        match self {
            Noise::Independent(Weights(weights)) => weights.len(),
            Noise::Correlated(Whitener(whitener)) => (whitener.len() as f64).sqrt().round() as usize,
        }
    }

    /// Whitens rows of `width` numbers in place; afterwards each row has unit variance and no correlation.
    pub(crate) fn whiten(&self, rows: &mut [f64], width: usize) {
        match self {
            Noise::Independent(Weights(weights)) if width == 1 => {
                rows.iter_mut().zip(weights.iter()).for_each(|(v, weight)| *v *= weight);
            }
            Noise::Independent(Weights(weights)) => {
                for (row, weight) in rows.chunks_exact_mut(width).zip(weights.iter()) {
                    row.iter_mut().for_each(|v| *v *= weight);
                }
            }
            Noise::Correlated(Whitener(whitener)) => {
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
            Noise::Independent(Weights(weights)) => {
                rows.iter_mut().zip(weights.iter()).for_each(|(v, weight)| *v /= weight)
            }
            Noise::Correlated(Whitener(whitener)) => {
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
        assert!(Noise::independent(&[1e-320]).is_err(), "its inverse is infinite");
        assert_eq!(Noise::correlated(&[1.0; 3], 2).unwrap_err(), NoiseError::Size { numbers: 3, rows: 2 });
        let reported = Noise::correlated(&[1.0, 0.9, 0.0, 1.0], 2).unwrap_err().to_string();
        assert_eq!(reported, "the covariance of readings 1 and 0 is stated twice, and not the same: 0 and 0.9");
        assert_eq!(Noise::correlated(&[1.0, 2.0, 2.0, 1.0], 2).unwrap_err(), NoiseError::NotPositiveDefinite(2));
    }
}
