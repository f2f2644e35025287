//! The test of friction at rest where the fit has it as an unknown: its estimate `c` without its prior over its own deviation.
//!
//! `F = c²/σ_c²` has one degree of freedom and those of the channel (Wald's test, which is the score test of a fit without it as long as
//! the unknown is linear, as this one is).

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::rows::Rows;
use super::score::Score;
use crate::joint::Solved;

/// Fewer degrees of freedom tell no noise.
const LEAST_FREEDOM: f64 = 4.0;

/// `column`: what a unit of friction does to the whitened residuals. Nothing where the readings do not tell it.
pub fn of_estimate(solved: &Solved, rows: &Rows, channel: usize, column: &[f64]) -> Option<Score> {
    let found = solved.friction_at_rest(channel)?;
    let freedom = rows.freedom()[channel];
    let statistic = (found.size / found.std).powi(2);
    let p_value = FisherSnedecor::new(1.0, freedom).ok().filter(|_| freedom >= LEAST_FREEDOM)?.sf(statistic);
    let mean_square = column.iter().map(|z| z * z).sum::<f64>() / rows.of_channel(channel).len().max(1) as f64;
    Some(Score {
        statistic,
        degrees_of_freedom: [1.0, freedom],
        blocks: None,
        p_value,
        coefficients: vec![found.size],
        in_noise: found.size.abs() * mean_square.sqrt(),
        gain: statistic,
        // The fit has it already.
        terms: Vec::new(),
    })
}
