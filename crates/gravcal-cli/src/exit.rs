//! Exit codes.

use gravcal_calibration::result::{EstimatorResult, Verdict, deciding};

/// How the program ends; worse is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Exit {
    /// Everything that is asked for is, or can be, determined.
    Determined = 0,
    /// What was found could not be printed or shown; what is written to files is complete.
    NotShown = 1,
    /// Bad input or usage.
    BadInput = 2,
    /// Solved, but something that is asked for is undetermined or cannot be relied on.
    PartlyDetermined = 3,
    /// No answer to rely on: no convergence, stopped before, or readings that contradict the model.
    Failed = 4,
}

impl Exit {
    /// Every way to end.
    #[cfg(test)]
    pub const ALL: [Exit; 5] = [Exit::Determined, Exit::NotShown, Exit::BadInput, Exit::PartlyDetermined, Exit::Failed];

    /// The number that the shell sees.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// What a calibration comes to: the joint estimator decides where it ran, otherwise the worst of those that did.
    pub fn of_calibration(results: &[EstimatorResult]) -> Exit {
        deciding(results).map_or(Exit::Failed, |result| result.verdict.into())
    }
}

impl From<Verdict> for Exit {
    fn from(verdict: Verdict) -> Exit {
        match verdict {
            Verdict::Determined => Exit::Determined,
            Verdict::PartlyDetermined => Exit::PartlyDetermined,
            Verdict::Failed => Exit::Failed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(name: &str, verdict: Verdict) -> EstimatorResult {
        EstimatorResult::blank(name, verdict, "")
    }

    #[test]
    fn codes_are_those_of_the_contract() {
        assert_eq!(Exit::ALL.map(Exit::code), [0, 1, 2, 3, 4]);
        assert_eq!(
            [Verdict::Determined, Verdict::PartlyDetermined, Verdict::Failed].map(|verdict| Exit::from(verdict).code()),
            [0, 3, 4]
        );
    }

    #[test]
    fn the_joint_estimator_decides() {
        let results = [result("sequential", Verdict::Failed), result("joint", Verdict::Determined)];
        assert_eq!(Exit::of_calibration(&results), Exit::Determined);
    }

    #[test]
    fn a_single_estimator_decides_for_itself() {
        assert_eq!(Exit::of_calibration(&[result("sequential", Verdict::PartlyDetermined)]), Exit::PartlyDetermined);
    }

    #[test]
    fn without_the_joint_estimator_the_worst_decides() {
        let results = [result("sequential", Verdict::Failed), result("joint-paper-signals", Verdict::Determined)];
        assert_eq!(Exit::of_calibration(&results), Exit::Failed);
    }
}
