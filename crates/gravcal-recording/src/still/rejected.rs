//! Why an interval in which the arm seemed to stand is no pose.

use std::fmt;

/// A part of a recording in which the arm seemed to stand, and that is no pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// Its first and last time, s, on the recording's clock.
    pub interval: [f64; 2],
    /// Why.
    pub reason: Reason,
}

/// Why an interval in which the arm seemed to stand is no pose. Each names a column, where it is one that says so.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// It still settles when it ends.
    Settling {
        /// The column that does.
        column: String,
    },
    /// A joint moves, slowly or a little.
    Moving {
        /// Of the joint.
        column: String,
    },
    /// Of a column that says something more seldom than the positions so few samples fall into it that standing cannot be told from moving.
    Short {
        /// The column that does.
        column: String,
        /// How many.
        samples: u64,
        /// How long the arm should stand, s.
        least: f64,
        /// Column of the joint that seems to move.
        joint: String,
    },
    /// A reading drifts by more than its noise.
    Drifting {
        /// The column that does.
        column: String,
        /// Slope, its inside unit a second.
        per_second: f64,
    },
    /// A reading departs and comes back: something touched the arm.
    Touched {
        /// The column that does.
        column: String,
        /// When, s.
        at: f64,
    },
    /// A reading is much noisier than in other standstills.
    Restless {
        /// The column.
        column: String,
    },
    /// It is much shorter than the others.
    Brief {
        /// How long the others are on the median, s.
        usual: f64,
    },
    /// The position of a joint is not recorded.
    NoPosition {
        /// Its column.
        column: String,
    },
}

impl fmt::Display for Rejected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} to {:.2} s, {}", self.interval[0], self.interval[1], self.reason)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Settling { column } => write!(f, "`{column}` still settles when it ends"),
            Reason::Moving { column } => write!(f, "`{column}` moves"),
            Reason::Short { column, samples, least, .. } => write!(
                f,
                "it is too short for `{column}`, of which only {samples} samples fall into it: let the arm stand for {least:.1} s or more"
            ),
            Reason::Drifting { column, per_second } => {
                write!(f, "`{column}` drifts by more than its noise, {per_second:.3e} a second")
            }
            Reason::Touched { column, at } => {
                write!(f, "`{column}` departs and comes back at {at:.2} s, as if the arm were touched")
            }
            Reason::Restless { column } => write!(f, "`{column}` is much noisier than in other standstills"),
            Reason::Brief { usual } => {
                write!(
                    f,
                    "the arm stands for a moment only, beside {usual:.2} s on the median, as where joints turn round"
                )
            }
            Reason::NoPosition { column } => write!(f, "`{column}` is not recorded"),
        }
    }
}
