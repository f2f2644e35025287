//! How well the readings are explained as a whole.
//!
//! ```text
//!     χ² = Σ r²,  p = P(χ²_dof ≥ χ²),  misfit √(χ²/dof)                                    without a loss
//!     z = (2 #{|r| > m} − n)/√n,  p = P(N ≥ z),  misfit median |r| / m,  m = 0.6745        under one
//! ```
//!
//! Where some channels state their noise and others do not, χ² is that of the rows which state it, and dof = Σ (1 − h) over them, h being the share
//! of a row that the parameters take up.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use crate::median::{NORMAL_MEDIAN, median};
use crate::residuals::RowResidual;

/// Probability below which the stated noise is taken not to explain the residuals.
const SIGNIFICANCE: f64 = 1e-3;
/// Residuals this many times as large as the stated noise makes them are too small: less is no matter.
const TOO_WELL: f64 = 0.8;

/// What residuals say of the noise that was stated.
#[derive(Clone, Copy, Debug)]
pub struct Explained {
    /// Sum of squares of the whitened residuals.
    pub chi_squared: f64,
    /// Rows less rank.
    pub degrees_of_freedom: usize,
    /// Probability of residuals as large by chance, of those whose noise is stated; nothing where none is, or no row is free.
    pub p_value: Option<f64>,
    /// Median of their sizes beside that of the noise, under a loss.
    pub median_ratio: Option<f64>,
    /// How many times as large as their stated noise makes them these are.
    pub times_noise: f64,
}

impl Explained {
    /// By noise that the residuals themselves told: always well.
    pub fn by_own_noise(chi_squared: f64, degrees_of_freedom: usize) -> Explained {
        Explained { chi_squared, degrees_of_freedom, p_value: None, median_ratio: None, times_noise: 1.0 }
    }

    /// By stated noise.
    pub fn by_chi_squared(chi_squared: f64, degrees_of_freedom: usize) -> Explained {
        let (p_value, times_noise) = by_chi_squared(chi_squared, degrees_of_freedom as f64);
        Explained { p_value, times_noise, ..Explained::by_own_noise(chi_squared, degrees_of_freedom) }
    }

    /// By the noise that some channels state. `stated`: residuals of these.
    pub fn by_stated_rows(chi_squared: f64, degrees_of_freedom: usize, stated: &[RowResidual]) -> Explained {
        let squares = stated.iter().map(|row| row.whitened * row.whitened).sum();
        let freedom = stated.iter().map(|row| (1.0 - row.leverage).max(0.0)).sum();
        let (p_value, times_noise) = by_chi_squared(squares, freedom);
        Explained { p_value, times_noise, ..Explained::by_own_noise(chi_squared, degrees_of_freedom) }
    }

    /// By stated noise and outliers. `freed`: residuals in standard deviations, as large as they would be had the fit not followed them.
    pub fn by_median(chi_squared: f64, degrees_of_freedom: usize, freed: &[f64]) -> Explained {
        let (p_value, median_ratio) = by_median(freed);
        let times_noise = median_ratio.unwrap_or(1.0);
        Explained { chi_squared, degrees_of_freedom, p_value, median_ratio, times_noise }
    }

    /// How many times worse than their stated noise the readings are explained, where that is no accident: `√(χ²/dof)`,
    /// under a loss by the median.
    pub fn misfit(&self) -> Option<f64> {
        self.p_value.filter(|p| *p < SIGNIFICANCE).map(|_| self.times_noise)
    }

    /// How many times as large as their stated noise makes them residuals are where they are too small, and that is no accident: the noise is
    /// another than stated.
    pub fn too_well(&self) -> Option<f64> {
        self.p_value.filter(|p| *p > 1.0 - SIGNIFICANCE).map(|_| self.times_noise).filter(|ratio| *ratio < TOO_WELL)
    }
}

/// Probability, and how many times the noise residuals are; less than one degree of freedom tells nothing.
fn by_chi_squared(chi_squared: f64, degrees_of_freedom: f64) -> (Option<f64>, f64) {
    match ChiSquared::new(degrees_of_freedom) {
        Ok(distribution) if degrees_of_freedom >= 1.0 => {
            (Some(distribution.sf(chi_squared)), (chi_squared / degrees_of_freedom).sqrt())
        }
        _ => (None, 1.0),
    }
}

/// Probability of as many residuals beyond the median of normal noise, of which each is with probability one half, and
/// how far their own median lies from it. A tenth of outliers moves it little, a model that is wrong for all of them far.
fn by_median(residuals: &[f64]) -> (Option<f64>, Option<f64>) {
    let count = residuals.len() as f64;
    let beyond = residuals.iter().filter(|r| r.abs() > NORMAL_MEDIAN).count() as f64;
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    let ratio = median(&mut sizes).map(|median| median / NORMAL_MEDIAN);
    (ratio.map(|_| Normal::standard().sf((2.0 * beyond - count) / count.sqrt())), ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_outliers_does_not_contradict_the_noise_and_twice_the_noise_does() {
        // Quantiles of the normal distribution.
        let quantile = |k: usize| Normal::standard().inverse_cdf((k as f64 + 0.5) / 1000.0);
        let normal: Vec<f64> = (0..1000).map(quantile).collect();
        let (p, ratio) = by_median(&normal);
        assert!((p.unwrap() - 0.5).abs() < 0.05 && (ratio.unwrap() - 1.0).abs() < 0.01, "{p:?} {ratio:?}");
        let spoilt: Vec<f64> = normal.iter().enumerate().map(|(k, r)| if k % 20 == 0 { 50.0 } else { *r }).collect();
        assert!(by_median(&spoilt).0.unwrap() > 1e-2);
        let twice: Vec<f64> = normal.iter().map(|r| 2.0 * r).collect();
        let (p, ratio) = by_median(&twice);
        assert!(p.unwrap() < 1e-9 && (ratio.unwrap() - 2.0).abs() < 0.02);
    }

    #[test]
    fn squares_are_judged_by_their_distribution() {
        // Of two degrees of freedom it is exponential: P(χ² ≥ x) = exp(−x/2).
        let explained = Explained::by_chi_squared(5.0, 2);
        assert!((explained.p_value.unwrap() - (-2.5_f64).exp()).abs() < 1e-12 && explained.misfit().is_none());
        assert!((Explained::by_chi_squared(18.0, 2).misfit().unwrap() - 3.0).abs() < 1e-12);
        assert!(Explained::by_own_noise(18.0, 2).misfit().is_none());
        assert!(Explained::by_chi_squared(18.0, 0).misfit().is_none());
    }

    /// Four rows of which the parameters take up half: two degrees of freedom.
    #[test]
    fn rows_that_state_their_noise_are_judged_by_themselves() {
        let row = |whitened: f64| RowResidual { whitened, leverage: 0.5 };
        let of = |whitened: f64| Explained::by_stated_rows(100.0, 100, &[row(whitened); 4]);
        assert!((of(2.0).p_value.unwrap() - (-8.0_f64).exp()).abs() < 1e-12);
        assert!((of(3.0).misfit().unwrap() - 18.0_f64.sqrt()).abs() < 1e-12 && of(1.0).misfit().is_none());
        assert!((of(3.0).chi_squared, of(3.0).degrees_of_freedom) == (100.0, 100));
        assert!(Explained::by_stated_rows(100.0, 100, &[row(9.0)]).misfit().is_none(), "half a degree of freedom");
        assert!(Explained::by_stated_rows(100.0, 100, &[]).p_value.is_none());
    }

    #[test]
    fn residuals_are_too_small_where_that_is_no_accident_and_matters() {
        let too_well = |chi_squared: f64, freedom: usize| Explained::by_chi_squared(chi_squared, freedom).too_well();
        assert!((too_well(600.0, 1000).unwrap() - 0.6_f64.sqrt()).abs() < 1e-12);
        assert!(too_well(700.0, 1000).is_none(), "by a sixth: no matter");
        assert!(too_well(0.5, 2).is_none(), "that happens");
        assert!(Explained::by_own_noise(600.0, 1000).too_well().is_none());
    }
}
