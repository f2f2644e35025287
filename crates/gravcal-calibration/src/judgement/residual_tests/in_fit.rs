//! The test of a term that the fit has as an unknown with a prior: friction at rest, joints that bend. Its estimate `c` without its prior over
//! its own deviation.
//!
//! `F = c²/σ_c²` has one degree of freedom and those of the channel (Wald's test, which is the score test of a fit without it as long as
//! the unknown is linear, as these nearly are).

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::rows::Rows;
use super::score::Score;
use crate::joint::OfReadings;

/// Fewer degrees of freedom tell no noise.
const LEAST_FREEDOM: f64 = 4.0;

/// `column`: what a unit of it does to the whitened residuals. Nothing where the channel has too few readings.
pub fn of_estimate(found: OfReadings, rows: &Rows, channel: usize, column: &[f64]) -> Option<Score> {
    let freedom = rows.freedom()[channel];
    let statistic = (found.size / found.std).powi(2);
    if !statistic.is_finite() || freedom < LEAST_FREEDOM {
        return None;
    }
    let p_value = FisherSnedecor::new(1.0, freedom).ok()?.sf(statistic);
    let mean_square = |channel: usize| {
        let own = rows.of_channel(channel);
        own.iter().map(|row| column[*row].powi(2)).sum::<f64>() / own.len().max(1) as f64
    };
    let largest = (0..rows.channels()).map(mean_square).fold(0.0, f64::max);
    Some(Score {
        statistic,
        degrees_of_freedom: [1.0, freedom],
        blocks: None,
        p_value,
        p_of_noise: p_value,
        coefficients: vec![found.size],
        in_noise: found.size.abs() * largest.sqrt(),
        gain: statistic,
    })
}
