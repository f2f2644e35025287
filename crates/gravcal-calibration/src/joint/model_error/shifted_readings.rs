//! Readings that may all be off in a way that is known, and that residuals need not show: what it does to every number.

use gravcal_estimation::statistics::{Solution, StatisticsError, moved_by};
use gravcal_estimation::{Loss, RankAnalysis};
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::solved::Solved;

/// Standard deviations by which it moves a number, from which it is told.
const MATTERS: f64 = 0.5;

/// What such errors do.
#[derive(Clone, Debug, Default)]
pub(super) struct Shifted {
    /// By how much each column of the problem that is judged is off.
    pub moved: Vec<f64>,
    /// Whether that is worth a remark.
    pub matters: bool,
}

impl Solved {
    /// Errors of readings, one entry a row of the problem, in standard deviations. `size`: of a reading, in its unit; nothing where none is off.
    pub(super) fn errors_of(&self, session: &Session, size: impl Fn(ReadingId) -> f64) -> Option<Vec<f64>> {
        let mut errors = vec![0.0; self.judged_problem().rows()];
        for (id, error) in self.built.rows.iter().zip(&mut errors) {
            *error = size(*id) / self.readings().std(session, *id);
        }
        errors.iter().any(|error| *error != 0.0).then_some(errors)
    }

    /// What each of these errors of the readings does.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(super) fn shifted_by(&self, session: &Session, errors: &[Vec<f64>]) -> Result<Vec<Shifted>, StatisticsError> {
        let (problem, covariance) = (self.judged_problem(), self.covariance());
        let variables = &self.built.variables;
        let told = session.parameters().into_iter().map(|id| variables.block(id)).chain([variables.gravity]);
        let columns: Vec<usize> = told.flat_map(|block| problem.columns_of(block)).collect();
        let shifted = |moved: Vec<f64>| {
            let far = |column: &usize| {
                let std = covariance.std(*column);
                std > 0.0 && moved[*column].abs() > MATTERS * std
            };
            Shifted { matters: columns.iter().any(far), moved }
        };
        Ok(self.moved_by_errors(errors)?.into_iter().map(shifted).collect())
    }

    /// By how much each column is off. Under a loss the solution is that of least squares with each row's weight.
    fn moved_by_errors(&self, errors: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, StatisticsError> {
        let (problem, values) = (self.judged_problem(), &self.estimate.values);
        if self.built.loss == Loss::None || errors.is_empty() {
            return moved_by(&Solution { problem, values, analysis: &self.analysis }, errors);
        }
        let (weighted, weights) = (problem.weighted_at(values)?, problem.weights(values)?);
        let analysis = RankAnalysis::new(&weighted, values)?;
        let counted = |errors: &Vec<f64>| errors.iter().zip(&weights).map(|(e, weight)| e * weight.sqrt()).collect();
        let errors: Vec<Vec<f64>> = errors.iter().map(counted).collect();
        moved_by(&Solution { problem: &weighted, values, analysis: &analysis }, &errors)
    }
}
