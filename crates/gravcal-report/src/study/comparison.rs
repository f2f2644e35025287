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

    /// Whether a series is the one with which the others of its point are compared.
    ///
    /// By its place: two that are the same differ in numbers that are none.
    pub(super) fn is_reference(&self, series: &Series) -> bool {
        let place = |series: &Series| (series.estimator, series.solver);
        self.reference(series.point).is_some_and(|last| place(last) == place(series))
    }

    /// The other series of a point.
    pub(super) fn others(&self, point: usize) -> impl Iterator<Item = &Series> {
        self.at(point).filter(|series| !self.is_reference(series))
    }

    pub(super) fn compared(&self, point: usize) -> Vec<Compared> {
        let Some(reference) = self.reference(point) else { return Vec::new() };
        let others: Vec<&Series> = self.others(point).collect();
        let rms = |series: &Series, quantity: usize| series.quantities[quantity].rms.value;
        (0..self.manifest.quantities.len())
            .map(|quantity| Compared {
                quantity,
                ratios: others.iter().map(|other| rms(other, quantity) / rms(reference, quantity)).collect(),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::testing::{manifest, quantity, series};

    #[test]
    fn what_lacks_an_estimate_is_not_compared_with_itself() {
        let manifest = manifest(&["sequential", "joint"], Vec::new());
        let mut series = series(&manifest);
        series.iter_mut().for_each(|series| series.quantities[1] = quantity(1.0, 0.95, 0));
        let report = StudyReport { manifest: &manifest, series: &series };
        assert_eq!(report.others(0).map(|series| report.name(series)).collect::<Vec<_>>(), ["sequential"]);
        assert_eq!(report.compared(0)[0].ratios, [3.0]);
    }
}
