//! The joint problem as it is built, with the readings that it is built from: `build.rs` builds it.

use std::sync::Arc;

use gravcal_estimation::{EvaluateError, Loss, Problem, Values};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::error::BuildError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::variables::VariableIndex;

/// A built joint problem. Whatever solves or judges it takes the readings and their noise from here, so that these are those of its factors.
#[derive(Clone, Debug)]
pub struct JointProblem {
    /// The problem.
    pub problem: Problem,
    /// Its start.
    pub initial: Values,
    /// Its blocks.
    pub variables: VariableIndex,
    /// The reading of each row of one; these rows come first.
    pub rows: Vec<ReadingId>,
    /// The residual of the session of each row of one's own; these come next.
    pub modelled: Vec<usize>,
    /// Poses whose readings enter: so many factors come first, one each, in the order of the session.
    pub poses: usize,
    /// How these factors count readings far beyond their noise.
    pub loss: Loss,
    readings: Arc<MeasurementSet>,
}

impl JointProblem {
    /// A problem and its start, built from these readings, none of them counted by a loss and no residual of the session's own among them.
    pub(super) fn of(
        readings: &MeasurementSet,
        (problem, initial): (Problem, Values),
        variables: VariableIndex,
        rows: Vec<ReadingId>,
    ) -> JointProblem {
        let (modelled, poses, loss) = (Vec::new(), readings.poses(), Loss::None);
        JointProblem { problem, initial, variables, rows, modelled, poses, loss, readings: Arc::new(readings.clone()) }
    }

    /// The readings that entered, with the noise that was stated or found.
    pub fn readings(&self) -> &MeasurementSet {
        &self.readings
    }

    /// The same readings and unknowns in another problem: with blocks fixed, other knowledge, another reference.
    pub(super) fn with_problem(self, problem: Problem) -> JointProblem {
        JointProblem { problem, ..self }
    }

    /// What the initial values predict of each reading, in its unit.
    pub(crate) fn predicted(&self, session: &Session) -> Result<Vec<(ReadingId, f64)>, EvaluateError> {
        let residuals = self.problem.residuals(&self.initial)?;
        let predicted = self.rows.iter().zip(residuals).filter_map(|(id, residual)| {
            let value = session.reading(*id)?.value;
            Some((*id, value + self.readings.std(session, *id) * residual))
        });
        Ok(predicted.collect())
    }

    /// The same with its reference about its start.
    pub(super) fn resting_at_start(self) -> JointProblem {
        match self.problem.reference() {
            Some(reference) => {
                let problem = self.problem.with_reference(reference.centered_at(&self.initial));
                self.with_problem(problem)
            }
            None => self,
        }
    }

    /// The same problem with another loss of the readings.
    pub(crate) fn with_loss(&self, loss: Loss) -> Result<JointProblem, BuildError> {
        if loss == self.loss {
            return Ok(self.clone());
        }
        Ok(JointProblem { problem: self.problem.with_loss(0..self.poses, loss)?, loss, ..self.clone() })
    }
}
