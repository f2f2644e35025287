//! How the estimators of a point compare: rms errors over those of the last estimator.

use gravcal_study::measures::Series;

use super::StudyReport;

/// One quantity, and the rms error of each estimator over that of the last.
pub(super) struct Compared {
    pub quantity: usize,
    /// In the order of the estimators but the last; NaN where one has no estimates.
    pub ratios: Vec<f64>,
}

impl StudyReport<'_> {
    /// The last estimator of a point, with which the others are compared; nothing where there is only one.
    pub(super) fn reference(&self, point: usize) -> Option<&Series> {
        let last = self.at(point).last()?;
        (self.at(point).count() > 1).then_some(last)
    }

    pub(super) fn compared(&self, point: usize) -> Vec<Compared> {
        let Some(reference) = self.reference(point) else { return Vec::new() };
        let others: Vec<&Series> = self.at(point).filter(|series| *series != reference).collect();
        let rms = |series: &Series, quantity: usize| series.quantities[quantity].rms.value;
        (0..self.manifest.quantities.len())
            .map(|quantity| Compared {
                quantity,
                ratios: others.iter().map(|other| rms(other, quantity) / rms(reference, quantity)).collect(),
            })
            .collect()
    }
}
