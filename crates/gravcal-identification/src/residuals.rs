//! Residuals with the leverage of their rows.
//!
//! ```text
//!     h_i = a_iᵀ (AᵀA)⁺ a_i      a_i: row i of the whitened Jacobian, Var r_i = 1 − h_i where the noise is as stated
//! ```

use gravcal_estimation::{EvaluateError, Problem, RankAnalysis, Values};

/// Of one row of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowResidual {
    /// In standard deviations of the noise.
    pub whitened: f64,
    /// Share of the row that the parameters take up, 0 to 1.
    pub leverage: f64,
}

impl RowResidual {
    /// As large as it would be had the fit not followed it, in standard deviations.
    pub fn freed(self) -> f64 {
        self.whitened / (1.0 - self.leverage).max(f64::EPSILON).sqrt()
    }
}

/// Those of the first `count` rows of a problem. `analysis`: of the problem at these values.
///
/// # Errors
/// Where a residual cannot be evaluated.
pub fn row_residuals(
    problem: &Problem,
    values: &Values,
    analysis: &RankAnalysis,
    count: usize,
) -> Result<Vec<RowResidual>, EvaluateError> {
    let (leverages, residuals) = analysis.leverages(problem, values)?;
    let residual = |(whitened, leverage)| RowResidual { whitened, leverage };
    Ok(residuals.into_iter().zip(leverages).take(count).map(residual).collect())
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Loss;

    use super::*;
    use crate::testing::{line, sensor, solved};

    #[test]
    fn the_leverages_of_a_line_are_those_of_the_textbook() {
        let readings = [(0.0, 1.2, 0.5), (1.0, 2.7, 0.5), (2.0, 5.3, 0.5), (6.0, 12.9, 0.5)];
        let (problem, start, _) = sensor(&readings, [1.0, 0.0, 0.0], &[1], Loss::None);
        let estimate = solved(&problem, &start);
        let analysis = RankAnalysis::new(&problem, &estimate.values).unwrap();
        let rows = row_residuals(&problem, &estimate.values, &analysis, readings.len()).unwrap();
        let (intercept, slope, sxx) = line(&readings);
        for ((x, y, std), row) in readings.iter().zip(rows) {
            let leverage = 0.25 + (x - 2.25).powi(2) / sxx;
            let residual = (intercept + slope * x - y) / std;
            assert!((row.leverage - leverage).abs() < 1e-9 && (row.whitened - residual).abs() < 1e-6, "{row:?}");
            assert!((row.freed() - residual / (1.0 - leverage).sqrt()).abs() < 1e-5, "{row:?}");
        }
    }
}
