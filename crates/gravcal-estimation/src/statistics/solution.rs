//! A solved problem, as the statistics need it.

use super::StatisticsError;
use crate::{BlockId, Problem, RankAnalysis, Values, named_combinations};

/// A solved problem, as the statistics need it.
#[derive(Clone, Copy, Debug)]
pub struct Solution<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Where its cost is smallest.
    pub values: &'a Values,
    /// What the data determine there.
    pub analysis: &'a RankAnalysis,
}

impl Solution<'_> {
    /// # Errors
    /// Where the problem has eliminated blocks, which the scatter of samples cannot tell apart.
    pub(super) fn without_eliminated(&self) -> Result<(), StatisticsError> {
        let eliminated = |id: &BlockId| self.problem.block(*id).eliminated && !self.problem.columns_of(*id).is_empty();
        match self.problem.block_ids().find(eliminated) {
            Some(id) => Err(StatisticsError::Eliminated(self.problem.block(id).name.clone())),
            None => Ok(()),
        }
    }

    /// A step by all columns in words.
    pub(super) fn name_direction(&self, step: &[f64]) -> String {
        let columns: Vec<usize> = (0..step.len()).collect();
        let named =
            named_combinations(self.problem, self.values, &columns, &self.analysis.sparse(&columns, &[step.to_vec()]));
        named.first().map_or_else(String::new, ToString::to_string)
    }
}
