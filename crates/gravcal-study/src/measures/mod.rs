//! What a table of trials comes to: errors, intervals, outcomes, each with its own Monte-Carlo error.
//!
//! Of one estimator, one quantity and one point, over the `n` trials with an estimate `x̂`, truth `x`, told standard deviation `s`
//! and Cramér-Rao bound `c`:
//!
//! ```text
//!     bias       mean of x̂ − x
//!     rms        √ mean of (x̂ − x)²
//!     ratio      √ mean of (x̂ − x)²/c²        1 for an estimator that reaches the bound
//!     nees       mean of (x̂ − x)²/s²          1 where the told deviations are true
//!     coverage   share of 95 % intervals that hold x
//! ```
//!
//! The Monte-Carlo error of a mean is its standard deviation over √n; that of a root of a mean is half as much, relative to it.

mod sums;

use crate::batch::{BatchError, Expected, Outcome, StudyFolder, TableReader};

use sums::{Mean, Sums};

/// A number with its Monte-Carlo standard error. NaN where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// How one estimator does with one quantity at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityMeasures {
    /// Trials with an estimate.
    pub estimates: u64,
    /// In the quantity's unit.
    pub bias: Measure,
    /// In the quantity's unit.
    pub rms: Measure,
    /// In the Cramér-Rao bound.
    pub ratio: Measure,
    /// Normalised estimation error squared.
    pub nees: Measure,
    /// From 0 to 1.
    pub coverage: Measure,
    /// Root mean square of the bounds, in the quantity's unit.
    pub bound: f64,
}

/// How one estimator does at one point with one solver.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Place of the point in the study.
    pub point: usize,
    /// Place of the estimator.
    pub estimator: usize,
    /// Place of the solver.
    pub solver: usize,
    /// Trials.
    pub trials: u64,
    /// Trials with each outcome, in the order of [`Outcome::ALL`].
    pub outcomes: [u64; 3],
    /// Iterations of the solver.
    pub iterations: Measure,
    /// Reasons of failures and how often, the most frequent first; of many different ones the first that came.
    pub reasons: Vec<(String, u64)>,
    /// One for each quantity of the study.
    pub quantities: Vec<QuantityMeasures>,
}

impl Series {
    /// Share of trials with that outcome.
    pub fn share(&self, outcome: Outcome) -> f64 {
        self.outcomes[outcome as usize] as f64 / self.trials as f64
    }
}

/// Reasons that are told apart.
const REASONS: usize = 20;

/// Reads the table of a complete study once, in memory that does not grow with it.
///
/// The result is in the order of points, estimators, solvers.
///
/// # Errors
/// The table is missing or damaged, or holds other rows than the study has.
pub fn measure(folder: &StudyFolder) -> Result<Vec<Series>, BatchError> {
    let manifest = &folder.manifest;
    let (estimators, solvers) = (manifest.estimators.len(), manifest.solvers.len());
    folder.check_complete()?;
    let mut table = TableReader::open(&folder.trials(), &manifest.columns())?;
    let mut sums = vec![Sums::new(manifest.quantities.len()); manifest.points.len() * estimators * solvers];
    let mut expected = Expected::whole(&folder.trials(), manifest);
    while let Some(rows) = table.next_rows() {
        for row in rows? {
            expected.take(&row)?;
            sums[(row.point * estimators + row.estimator) * solvers + row.solver].add(&row);
        }
    }
    expected.end()?;
    let places = sums.into_iter().enumerate();
    Ok(places
        .map(|(place, sums)| {
            let (rest, solver) = (place / solvers, place % solvers);
            sums.series(rest / estimators, rest % estimators, solver)
        })
        .collect())
}

impl Measure {
    const NONE: Measure = Measure { value: f64::NAN, error: f64::NAN };

    fn of(mean: &Mean) -> Measure {
        Measure { value: mean.mean(), error: mean.standard_error() }
    }

    /// `√m` with the error `e/(2 √m)`.
    fn root_of(mean: &Mean) -> Measure {
        let root = mean.mean().sqrt();
        Measure { value: root, error: mean.standard_error() / (2.0 * root) }
    }

    /// A share of trials, with the error `√(p (1 − p)/n)`.
    fn share(hits: u64, trials: u64) -> Measure {
        if trials == 0 {
            return Measure::NONE;
        }
        let share = hits as f64 / trials as f64;
        Measure { value: share, error: (share * (1.0 - share) / trials as f64).sqrt() }
    }
}
