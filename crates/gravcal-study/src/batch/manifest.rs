//! What a study's results are of.

use serde::{Deserialize, Serialize};

use super::part::{Part, parts};
use super::table::Columns;
use crate::plan::{Axis, MOST_POINTS, MOST_TRIALS, Study, places, reported};

/// Errors of so many quantities, of each estimator with each solver at each point, are more than anyone looks at.
const MOST_CELLS: usize = 10_000_000;

/// What stands in `study.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the program.
    pub gravcal: String,
    /// SHA-256 of all that the results depend on.
    pub fingerprint: String,
    /// Trials at each point.
    pub trials: u64,
    /// Names of the estimators.
    pub estimators: Vec<String>,
    /// Names of the solvers.
    pub solvers: Vec<String>,
    /// What is varied.
    pub axes: Vec<Axis>,
    /// The grid: of each point the place on each axis.
    pub points: Vec<Vec<usize>>,
    /// Name and unit of each quantity.
    pub quantities: Vec<(String, String)>,
}

impl Manifest {
    /// That of a study with these solvers.
    pub fn new(study: &Study, solvers: &[String]) -> Manifest {
        Manifest {
            gravcal: env!("CARGO_PKG_VERSION").to_owned(),
            fingerprint: study.fingerprint.clone(),
            trials: study.trials,
            estimators: study.estimators.iter().map(ToString::to_string).collect(),
            solvers: solvers.to_vec(),
            axes: study.axes.clone(),
            points: study.points.iter().map(|point| point.places.clone()).collect(),
            quantities: study.quantities.clone(),
        }
    }

    /// The columns of its tables.
    pub fn columns(&self) -> Columns {
        Columns {
            estimators: self.estimators.clone(),
            solvers: self.solvers.clone(),
            quantities: self.quantities.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    pub(super) fn parts(&self) -> Vec<Part> {
        parts(self.points.len(), self.trials)
    }

    /// What is wrong with one that was read: figures and tables count on the rest.
    pub(super) fn check(&self) -> Result<(), &'static str> {
        let sizes: Vec<usize> = self.axes.iter().map(|axis| axis.labels.len()).collect();
        let is_whole = |axis: &Axis| axis.numbers.as_ref().is_none_or(|numbers| numbers.len() == axis.labels.len());
        let count = sizes.iter().try_fold(1usize, |count, size| count.checked_mul(*size));
        let trials = self.trials.saturating_mul(self.points.len() as u64);
        let grid = || self.points.iter().enumerate().all(|(index, point)| *point == places(index, &sizes));
        let series = [self.estimators.len(), self.solvers.len(), self.quantities.len().max(1)];
        let cells = series.iter().fold(self.points.len(), |product, size| product.saturating_mul(*size));
        match () {
            () if !(1..=MOST_POINTS).contains(&self.points.len()) => Err("its number of points is none of a study"),
            () if !(1..=MOST_TRIALS).contains(&trials) => Err("its number of trials is none of a study"),
            () if self.estimators.is_empty() || self.solvers.is_empty() => Err("it compares nothing"),
            () if cells > MOST_CELLS => Err("it compares more than a study can"),
            () if !self.axes.iter().all(is_whole) => Err("an axis has more or fewer numbers than labels"),
            () if count != Some(self.points.len()) || !grid() => Err("its points are not the grid of what is varied"),
            () => Ok(()),
        }
    }

    /// `noise = 0.3 count, range = 90 deg`; nothing where nothing is varied.
    pub fn reported(&self, point: usize) -> String {
        reported(&self.axes, &self.points[point])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two axes, of two values and of one.
    fn manifest() -> Manifest {
        let axis = |name: &str, numbers: &[f64]| Axis {
            name: name.to_owned(),
            unit: None,
            labels: numbers.iter().map(f64::to_string).collect(),
            numbers: Some(numbers.to_vec()),
        };
        Manifest {
            gravcal: "0".to_owned(),
            fingerprint: "0".to_owned(),
            trials: 3,
            estimators: vec!["joint".to_owned()],
            solvers: vec!["levenberg-marquardt".to_owned()],
            axes: vec![axis("noise", &[0.1, 0.2]), axis("poses", &[30.0])],
            points: vec![vec![0, 0], vec![1, 0]],
            quantities: Vec::new(),
        }
    }

    type Change = fn(&mut Manifest);

    #[test]
    fn what_contradicts_itself_is_seen() {
        assert_eq!(manifest().check(), Ok(()));
        let changes: [(&str, Change); 11] = [
            ("more than a study can", |manifest| manifest.quantities = vec![Default::default(); MOST_CELLS]),
            ("number of trials", |manifest| manifest.trials = 0),
            ("number of trials", |manifest| manifest.trials = u64::MAX),
            ("number of points", |manifest| manifest.points.clear()),
            ("nothing", |manifest| manifest.estimators.clear()),
            ("nothing", |manifest| manifest.solvers.clear()),
            ("numbers than labels", |manifest| manifest.axes[0].numbers = Some(vec![0.1])),
            ("grid", |manifest| manifest.points[1][0] = 2),
            ("grid", |manifest| manifest.points[1].truncate(1)),
            ("grid", |manifest| manifest.points.push(vec![0, 0])),
            ("grid", |manifest| {
                manifest.axes[1] = Axis { labels: Vec::new(), numbers: None, ..manifest.axes[1].clone() }
            }),
        ];
        for (reported, change) in changes {
            let mut changed = manifest();
            change(&mut changed);
            assert!(changed.check().is_err_and(|why| why.contains(reported)), "{reported}: {:?}", changed.check());
        }
    }
}
