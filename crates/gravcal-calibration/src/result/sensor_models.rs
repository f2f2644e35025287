//! Models of sensors, tested against their absence.

use std::fmt;

use serde::Serialize;

/// A model of a joint's sensor or of an instrument's biases, tested against the hypothesis that all its parameters are zero.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensorModelTest {
    /// The joint, or the instrument.
    pub joint: String,
    /// `torque-bias-in-time`, …; `biases-of-tables` where an instrument has biases of its own in each table, which are tested for being
    /// the same.
    pub model: String,
    /// Its parameters that were estimated.
    pub parameters: Vec<String>,
    /// The test, where the data determine the parameters.
    pub test: Option<TestAgainstZero>,
}

/// How unlikely readings are as these, if the parameters were zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TestAgainstZero {
    /// Which one.
    pub kind: TestKind,
    /// Its statistic.
    pub statistic: f64,
    /// Its degrees of freedom: the number of parameters, and for F those of the fit.
    pub degrees_of_freedom: [Option<usize>; 2],
    /// Probability of a statistic at least as large.
    pub p_value: f64,
}

/// A test of parameters against zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TestKind {
    /// By how much χ² grows without them, the noise being as stated.
    LikelihoodRatio,
    /// The same, relative to the χ² that is left, where the noise is taken from the residuals.
    F,
    /// By their covariance, where that is robust to model error or the readings were counted by a loss.
    Wald,
}

impl fmt::Display for TestKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            TestKind::LikelihoodRatio => "likelihood ratio",
            TestKind::F => "F",
            TestKind::Wald => "Wald",
        })
    }
}
