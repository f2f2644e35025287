//! What a page shows, and which estimators.

use gravcal_calibration::result::{EstimatorResult, deciding};
use gravcal_robot_model::Session;

use crate::provenance::Provenance;

/// The page of a calibration.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationPage<'a> {
    /// What was calibrated; its readings are drawn.
    pub session: &'a Session,
    /// What the estimators answered.
    pub results: &'a [EstimatorResult],
    /// Where it comes from.
    pub provenance: &'a Provenance,
}

impl CalibrationPage<'_> {
    /// The estimator that decides.
    pub(super) fn main(&self) -> Option<&EstimatorResult> {
        deciding(self.results)
    }

    /// Those that are drawn, the one that decides first.
    pub(super) fn drawn(&self) -> Vec<&EstimatorResult> {
        let main = self.main();
        let others = self.results.iter().filter(|result| main.is_none_or(|main| main.name != result.name));
        main.into_iter().chain(others).filter(|result| result.fit.is_some()).take(2).collect()
    }
}
