//! Errors of readings that their noise does not explain, one variance for each channel, by restricted likelihood (REML).
//!
//! ```text
//!     y_i = f_i(x) + e_i + u_i      e_i ~ N(0, s_i²)  the reading's own noise, stated or measured
//!                                   u_i ~ N(0, v)     its unexplained error; v ≥ 0 of the channel
//!     Σ w_i² r_i² = Σ w_i (1 − h_i)     w_i = 1/(s_i² + v)
//! ```
//!
//! over the readings of the channel, with residuals `r_i` and leverages `h_i` of the weighted fit: where the slope of the restricted
//! likelihood is zero (Patterson and Thompson, *Biometrika* 58, 1971; Harville, *J. American Statistical Association* 72, 1977). `v` is
//! found with residuals and leverages as they are, the fit is repeated with the new weights, and so on, until both stand.
//! Where residuals are no larger than the noise makes them, `v` is zero and everything is as if there were none.
//!
//! Under a loss, residuals may be outliers, and `v` is what makes their median that of normal errors.

use crate::median::{NORMAL_MEDIAN, median};

/// Halvings of the interval in which a variance lies: beyond the digits of a number.
const HALVINGS: usize = 60;

/// A reading of a channel.
#[derive(Clone, Copy, Debug)]
pub struct ErrorRow {
    /// `s²`, square of the unit of the reading.
    pub noise: f64,
    /// `r²`, the same.
    pub squared: f64,
    /// `1 − h`.
    pub freedom: f64,
}

/// The variance of the unexplained errors of readings, square of their unit.
pub fn variance_beyond_noise(rows: &[ErrorRow]) -> f64 {
    let slope = |v: f64| {
        let of_row = |row: &ErrorRow| {
            let weight = 1.0 / (row.noise + v);
            weight * (weight * row.squared - row.freedom)
        };
        rows.iter().map(of_row).sum::<f64>()
    };
    where_it_falls_to_zero(rows, slope)
}

/// The same by the median of the residuals.
pub fn variance_beyond_noise_by_median(rows: &[ErrorRow]) -> f64 {
    let excess = |v: f64| {
        let size = |row: &ErrorRow| row.squared / (row.freedom.max(f64::EPSILON) * (row.noise + v));
        let mut sizes: Vec<f64> = rows.iter().map(size).collect();
        median(&mut sizes).unwrap_or(0.0) - NORMAL_MEDIAN * NORMAL_MEDIAN
    };
    where_it_falls_to_zero(rows, excess)
}

/// Where a function of the variance falls to zero that is negative for all beyond the largest one that any residual suggests.
fn where_it_falls_to_zero(rows: &[ErrorRow], function: impl Fn(f64) -> f64) -> f64 {
    if rows.iter().map(|row| row.freedom).sum::<f64>() <= 0.0 || function(0.0) <= 0.0 {
        return 0.0;
    }
    let mut high = rows.iter().map(|row| row.squared).sum::<f64>();
    while function(high) > 0.0 && high.is_finite() {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if function(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    use super::*;

    fn rows(noise: f64, residuals: &[f64], freedom: f64) -> Vec<ErrorRow> {
        residuals.iter().map(|r| ErrorRow { noise, squared: r * r, freedom }).collect()
    }

    /// A mean of n readings of one noise: `v = Σ r²/(n − 1) − s²`.
    #[test]
    fn readings_of_one_noise_have_the_closed_form() {
        let residuals = [0.3, -0.5, 0.1, 0.7, -0.6];
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let found = variance_beyond_noise(&rows(0.04, &residuals, 0.8));
        assert!((found - (squares / 4.0 - 0.04)).abs() < 1e-12, "{found}");
    }

    /// One-way layout: means of groups of 2 and of 8 readings have noise σ²/n; their variance beyond it is that of the balanced
    /// analysis of variance where n is the same.
    #[test]
    fn a_one_way_layout_has_the_estimate_of_the_analysis_of_variance() {
        let means = [1.0, 1.4, 0.7, 1.9, 1.1, 0.3];
        let grand = means.iter().sum::<f64>() / 6.0;
        let between = means.iter().map(|m| (m - grand).powi(2)).sum::<f64>() / 5.0;
        let residuals: Vec<f64> = means.iter().map(|m| m - grand).collect();
        let found = variance_beyond_noise(&rows(0.09 / 8.0, &residuals, 5.0 / 6.0));
        assert!((found - (between - 0.09 / 8.0)).abs() < 1e-12, "{found}");
    }

    /// Of readings that differ in noise it is the maximum of the restricted likelihood, found by looking for it.
    #[test]
    fn readings_that_differ_in_noise_have_the_maximum_of_the_restricted_likelihood() {
        let noise = [0.01, 0.02, 0.5, 0.04, 0.3, 0.01, 1.0, 0.02];
        let values = [0.9, 1.6, 2.4, 0.4, 0.1, 1.3, -1.0, 0.8];
        let weights = |v: f64| noise.map(|s| 1.0 / (s + v));
        let mean = |v: f64| {
            let weights = weights(v);
            weights.iter().zip(values).map(|(w, y)| w * y).sum::<f64>() / weights.iter().sum::<f64>()
        };
        let likelihood = |v: f64| {
            let of_row = |(w, y): (f64, f64)| w.ln() - w * (y - mean(v)).powi(2);
            weights(v).into_iter().zip(values).map(of_row).sum::<f64>() - weights(v).iter().sum::<f64>().ln()
        };
        let best = (0..200_000).map(|k| 1e-5 * f64::from(k)).max_by(|a, b| likelihood(*a).total_cmp(&likelihood(*b)));
        let mut v = 0.0;
        for _ in 0..200 {
            let (weights, mean) = (weights(v), mean(v));
            let total: f64 = weights.iter().sum();
            let row = |((s, y), w): ((&f64, f64), f64)| ErrorRow {
                noise: *s,
                squared: (y - mean).powi(2),
                freedom: 1.0 - w / total,
            };
            v = variance_beyond_noise(&noise.iter().zip(values).zip(weights).map(row).collect::<Vec<_>>());
        }
        assert!((v - best.unwrap()).abs() < 2e-5 && v > 0.1, "{v} {best:?}");
    }

    #[test]
    fn residuals_no_larger_than_the_noise_leave_nothing_unexplained() {
        assert_eq!(variance_beyond_noise(&rows(0.25, &[0.3, -0.5, 0.1, 0.4, -0.4], 0.8)), 0.0);
        assert_eq!(variance_beyond_noise(&rows(0.25, &[], 0.8)), 0.0);
        // Nothing is left where the fit follows every reading.
        assert_eq!(variance_beyond_noise(&rows(0.25, &[1e-9, 1e-9], 0.0)), 0.0);
        assert_eq!(variance_beyond_noise_by_median(&rows(0.25, &[0.1, -0.2, 0.1], 0.8)), 0.0);
    }

    #[test]
    fn outliers_do_not_move_the_median() {
        let mut random = Pcg64::seed_from_u64(7);
        let mut residuals: Vec<f64> = (0..2000).map(|_| 0.5 * random.sample::<f64, _>(StandardNormal)).collect();
        residuals.iter_mut().step_by(10).for_each(|r| *r = 100.0);
        let found = variance_beyond_noise_by_median(&rows(0.04, &residuals, 1.0)).sqrt();
        let truth = (0.25_f64 - 0.04).sqrt();
        assert!((found / truth - 1.0).abs() < 0.25, "{found} {truth}");
        assert!(variance_beyond_noise(&rows(0.04, &residuals, 1.0)).sqrt() > 10.0 * truth);
    }
}
