//! What a converter's step leaves of its error in a mean.
//!
//! Of readings rounded to steps Δ, behind noise of variance σ², the mean is off by an error that depends on where between two steps the
//! true value is. Over all places its mean square is (Widrow and Kollár, Quantization Noise, 2008)
//!
//! ```text
//!     R(σ) = Σ_k Δ² / (2 π² k²) exp(−4 π² k² σ² / Δ²)
//! ```
//!
//! Δ²/12 without noise, next to nothing from half a step of noise on. The variance of the readings themselves is on the mean
//! `σ² + Δ²/12 − R(σ)`, so that variances of many standstills tell σ.

use std::f64::consts::PI;

/// How much of a step is left in a mean: 1 without noise and 0 where noise of this variance smooths it.
pub(super) fn roughness(step: f64, noise: f64) -> f64 {
    (-2.0 * PI.powi(2) * noise / (step * step)).exp()
}

/// R: mean square error of a mean over readings in steps, behind noise of this variance.
fn rounding(step: f64, noise: f64) -> f64 {
    let term = |order: u32| {
        let order = f64::from(order * order);
        roughness(step, noise).powf(2.0 * order) / (2.0 * PI.powi(2) * order)
    };
    step * step * (1..=40).map(term).sum::<f64>()
}

/// The same, where readings in standstills have this variance on the mean.
pub(super) fn rounding_of_readings(step: f64, variance: f64) -> f64 {
    if step <= 0.0 {
        return 0.0;
    }
    let seen = |noise: f64| noise + step * step / 12.0 - rounding(step, noise);
    let (mut low, mut high) = (0.0, variance);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if seen(middle) < variance { low = middle } else { high = middle }
    }
    rounding(step, low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_noise_the_error_is_that_of_rounding_and_with_noise_it_goes() {
        assert!((rounding(2.0, 0.0) - 4.0 / 12.0).abs() < 0.006);
        assert!(rounding(2.0, 1.0) < 1e-4);
        assert!((rounding_of_readings(2.0, 0.0) - 4.0 / 12.0).abs() < 0.006);
    }

    /// Readings of many true values behind noise that a rational generator spreads evenly over its quantiles.
    #[test]
    fn the_variance_of_readings_tells_the_error_of_their_means() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        for noise in [0.1, 0.2, 0.3, 0.5] {
            let (mut variances, mut errors) = (0.0, 0.0);
            let places = 400;
            for place in 0..places {
                let truth = f64::from(place) / f64::from(places);
                let readings: Vec<f64> = (0..2000)
                    .map(|_| (truth + noise * random.sample::<f64, _>(rand_distr::StandardNormal)).round())
                    .collect();
                let mean = readings.iter().sum::<f64>() / 2000.0;
                let variance = readings.iter().map(|reading| (reading - mean).powi(2)).sum::<f64>() / 1999.0;
                variances += variance / f64::from(places);
                errors += ((mean - truth).powi(2) - variance / 2000.0) / f64::from(places);
            }
            let reported = rounding_of_readings(1.0, variances);
            assert!((reported - errors).abs() < 0.05 * errors + 1e-4, "{noise}: {reported} {errors}");
        }
    }
}
