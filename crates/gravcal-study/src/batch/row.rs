//! What is kept of one estimator's answer to one trial.

use std::fmt;
use std::str::FromStr;

use gravcal_calibration::result::Verdict;

/// How one estimator fared in one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Place of the point in the study.
    pub point: usize,
    /// Number of the trial.
    pub trial: u64,
    /// Place among the study's estimators.
    pub estimator: usize,
    /// Place among its solvers.
    pub solver: usize,
    /// What became of it.
    pub outcome: Outcome,
    /// Why it failed, where it did.
    pub reason: Option<String>,
    /// Iterations of the solver.
    pub iterations: u64,
    /// One for each quantity of the study.
    pub cells: Vec<Cell>,
}

/// One quantity. Numbers are in its unit, and NaN where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Estimate less truth.
    pub error: f64,
    /// The standard deviation that the estimator told.
    pub std: f64,
    /// The Cramér-Rao bound of the readings that the estimator uses.
    pub bound: f64,
    /// Whether the truth lies in the 95 % interval; `None` where there is no estimate.
    pub inside: Option<bool>,
}

impl Cell {
    /// Nothing is known.
    pub const EMPTY: Cell = Cell { error: f64::NAN, std: f64::NAN, bound: f64::NAN, inside: None };
}

/// What became of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything asked for is determined.
    Determined,
    /// Something is not.
    PartlyDetermined,
    /// There is no answer to rely on.
    Failed,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Outcome; 3] = [Outcome::Determined, Outcome::PartlyDetermined, Outcome::Failed];

    /// As in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Outcome::Determined => "determined",
            Outcome::PartlyDetermined => "partly-determined",
            Outcome::Failed => "failed",
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for Outcome {
    type Err = String;

    fn from_str(name: &str) -> Result<Outcome, String> {
        Outcome::ALL
            .into_iter()
            .find(|outcome| outcome.as_str() == name)
            .ok_or_else(|| format!("unknown outcome `{name}`"))
    }
}

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Outcome {
        match verdict {
            Verdict::Determined => Outcome::Determined,
            Verdict::PartlyDetermined => Outcome::PartlyDetermined,
            Verdict::Failed => Outcome::Failed,
        }
    }
}
