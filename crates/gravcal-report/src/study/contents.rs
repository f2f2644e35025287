//! What a report tells: a study and what it came to.

use gravcal_study::batch::Manifest;
use gravcal_study::measures::Series;

/// A study and what it came to.
#[derive(Clone, Copy, Debug)]
pub struct StudyReport<'a> {
    /// What was studied.
    pub manifest: &'a Manifest,
    /// What it came to, in the order of points, estimators, solvers.
    pub series: &'a [Series],
}

impl StudyReport<'_> {
    /// `Study of sequential, joint over noise and converter`.
    pub(super) fn title(&self) -> String {
        let axes: Vec<&str> = self.manifest.axes.iter().map(|axis| axis.name.as_str()).collect();
        let over = if axes.is_empty() { String::new() } else { format!(" over {}", axes.join(" and ")) };
        format!("Study of {}{over}", self.manifest.estimators.join(", "))
    }

    /// The estimator of a series, with the solver where several are compared.
    pub(super) fn name(&self, series: &Series) -> String {
        let estimator = &self.manifest.estimators[series.estimator];
        match self.manifest.solvers.len() {
            0 | 1 => estimator.clone(),
            _ => format!("{estimator}, {}", self.manifest.solvers[series.solver]),
        }
    }

    /// Series of one point.
    pub(super) fn at(&self, point: usize) -> impl Iterator<Item = &Series> {
        self.series.iter().filter(move |series| series.point == point)
    }
}
