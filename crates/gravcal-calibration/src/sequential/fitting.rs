//! The small least-squares problems of the steps: solved, checked for rank, and told with their covariance.

use gravcal_estimation::{BlockId, Covariance, Estimate, Problem, ProblemBuilder, Spectrum, Values};

use super::found::{Frozen, Missing};
use crate::workbench::Workbench;

/// A solved step.
pub(super) struct StepFit {
    pub problem: Problem,
    pub estimate: Estimate,
    pub covariance: Covariance,
    pub degrees_of_freedom: usize,
}

impl StepFit {
    /// Solves the step's problem; refuses it where the readings leave a direction open.
    pub fn solve(builder: ProblemBuilder, workbench: &Workbench<'_>, cure: &str) -> Result<StepFit, Missing> {
        let refuse = |why: String| Missing::new(why, cure);
        let (problem, initial) = builder.build().map_err(|e| refuse(e.to_string()))?;
        let estimate = workbench.solve(&problem, &initial).map_err(|e| refuse(e.to_string()))?;
        if !estimate.termination.converged() {
            return Err(refuse(format!("the fit ended without an answer: {}", estimate.termination)));
        }
        let spectrum = Spectrum::of(&problem, &estimate).map_err(|e| refuse(e.to_string()))?;
        if spectrum.rank() < problem.columns().len() {
            return Err(refuse("the readings of this step leave a combination of its unknowns open".into()));
        }
        Ok(StepFit {
            degrees_of_freedom: problem.rows() - spectrum.rank(),
            covariance: spectrum.covariance(),
            problem,
            estimate,
        })
    }

    pub fn values(&self) -> &Values {
        &self.estimate.values
    }

    /// A scalar block with its standard deviation, unless that exceeds `limit`.
    pub fn frozen(&self, id: BlockId, limit: f64, cure: &str) -> Result<Frozen, Missing> {
        let value = self.values().scalar(id);
        let std = self.problem.columns_of(id).next().map_or(0.0, |column| self.covariance.std(column));
        if std <= limit {
            Ok(Frozen { value, std })
        } else {
            let name = &self.problem.block(id).name;
            Err(Missing::new(
                format!("its step fixes {name} only to ±{std:.3}, more than {limit:.3}, which would be of use"),
                cure,
            ))
        }
    }
}
