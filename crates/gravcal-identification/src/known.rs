//! What the readings say at an estimate, to first order.
//!
//! ```text
//!     C = (JᵀJ)⁺     J: whitened Jacobian, with what decided constraints hold as all but exact readings
//! ```

use gravcal_estimation::statistics::{NoiseKnowledge, Solution, StatisticsError, along_constraints, leans};
use gravcal_estimation::{Estimate, EvaluateError, Problem, Spectrum, Uncertainty};

/// What is known there.
#[derive(Debug)]
pub struct Known {
    /// Of the problem along its active constraints.
    pub spectrum: Spectrum,
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
        let mut spectrum = Spectrum::of(problem, estimate)?;
        let leans = leans(problem, estimate, &spectrum);
        let along = along_constraints(problem, estimate, &spectrum)?;
        if let Some(problem) = &along {
            spectrum = Spectrum::new(problem, &estimate.values)?;
        }
        let judged = along.as_ref().unwrap_or(problem);
        let solution = Solution { problem: judged, values: &estimate.values, spectrum: &spectrum };
        let uncertainty = Uncertainty::from_noise(&solution, NoiseKnowledge::Stated)?;
        Ok(Known { spectrum, along_constraints: along, leans, uncertainty })
    }
}
