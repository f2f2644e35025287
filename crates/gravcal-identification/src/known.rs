//! What the readings say at an estimate, to first order.
//!
//! ```text
//!     C = (JᵀJ)⁺     J: whitened Jacobian, with what decided constraints hold as all but exact readings
//! ```

use gravcal_estimation::statistics::{NoiseScale, Solution, StatisticsError, along_constraints, leans};
use gravcal_estimation::{Estimate, EvaluateError, Problem, RankAnalysis, Uncertainty};

/// What is known there.
#[derive(Debug)]
pub struct Known {
    /// Of the problem along its active constraints.
    pub analysis: RankAnalysis,
    /// The problem with what the active constraints hold as readings; nothing where none is active.
    pub along_constraints: Option<Problem>,
    /// By how many standard deviations the readings would like to pass each active constraint.
    pub leans: Vec<f64>,
    /// How well, by the noise as it is stated.
    pub uncertainty: Uncertainty,
}

impl Known {
    /// At an estimate of a problem.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated there, or has no standard deviations.
    pub fn at<E>(problem: &Problem, estimate: &Estimate) -> Result<Known, E>
    where
        E: From<EvaluateError> + From<StatisticsError>,
    {
        let mut analysis = RankAnalysis::of(problem, estimate)?;
        let leans = leans(problem, estimate, &analysis);
        let along = along_constraints(problem, estimate, &analysis)?;
        if let Some(problem) = &along {
            analysis = RankAnalysis::new(problem, &estimate.values)?;
        }
        let judged = along.as_ref().unwrap_or(problem);
        let solution = Solution { problem: judged, values: &estimate.values, analysis: &analysis };
        let uncertainty = Uncertainty::from_noise(&solution, NoiseScale::Stated)?;
        Ok(Known { analysis, along_constraints: along, leans, uncertainty })
    }
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Loss;

    use super::*;
    use crate::testing::{line, sensor, solved};

    #[test]
    fn a_line_is_known_as_the_textbook_says() {
        let readings = [(0.0, 1.2, 0.5), (1.0, 2.7, 0.5), (2.0, 5.3, 0.5), (6.0, 12.9, 0.5)];
        let (problem, start, [gain, _, bias]) = sensor(&readings, [1.0, 0.0, 0.0], &[1], Loss::None);
        let known = Known::at::<StatisticsError>(&problem, &solved(&problem, &start)).unwrap();
        let sxx = line(&readings).2;
        let std = |id| known.uncertainty.covariance().std(problem.columns_of(id).start);
        assert!((std(gain) - 0.5 / sxx.sqrt()).abs() < 1e-9);
        assert!((std(bias) - 0.5 * (0.25 + 2.25_f64.powi(2) / sxx).sqrt()).abs() < 1e-9);
        assert!(known.along_constraints.is_none() && known.leans.is_empty() && known.analysis.rank() == 2);
    }
}
