//! What a study compares: the estimators that a user can run, and some that only who knows the truth can.

use std::fmt;
use std::str::FromStr;

use gravcal_calibration::joint::Signals;
use gravcal_robot_model::EstimatorName;

/// One column of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// An estimator as a user runs it.
    Estimator(EstimatorName),
    /// The paper's steps with the true results of step 1: torque biases and position gains.
    SequentialTrueStep1,
    /// The paper's steps with the true results of steps 1 and 2, gravity included.
    SequentialTrueSteps1And2,
}

impl Compared {
    /// Every one.
    pub fn all() -> impl Iterator<Item = Compared> {
        let true_steps = [Compared::SequentialTrueStep1, Compared::SequentialTrueSteps1And2];
        EstimatorName::ALL.into_iter().map(Compared::Estimator).chain(true_steps)
    }

    /// The estimator that it is, or is made of.
    pub fn estimator(self) -> EstimatorName {
        match self {
            Compared::Estimator(name) => name,
            Compared::SequentialTrueStep1 | Compared::SequentialTrueSteps1And2 => EstimatorName::Sequential,
        }
    }

    /// The readings that it uses.
    pub(crate) fn signals(self) -> Signals {
        match self.estimator() {
            EstimatorName::Sequential | EstimatorName::SequentialWithCovariance | EstimatorName::JointPaperSignals => {
                Signals::PaperSteps
            }
            EstimatorName::Recursive | EstimatorName::Joint => Signals::All,
        }
    }
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Compared::Estimator(name) => name.as_str(),
            Compared::SequentialTrueStep1 => "sequential-true-step-1",
            Compared::SequentialTrueSteps1And2 => "sequential-true-steps-1-and-2",
        })
    }
}

impl FromStr for Compared {
    type Err = String;

    fn from_str(name: &str) -> Result<Compared, String> {
        Compared::all().find(|compared| compared.to_string() == name).ok_or_else(|| {
            let known: Vec<String> = Compared::all().map(|compared| compared.to_string()).collect();
            format!("unknown estimator `{name}`; there is: {}", known.join(", "))
        })
    }
}
