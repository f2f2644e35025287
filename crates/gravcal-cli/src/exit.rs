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
    /// Solved, but something that is asked for is undetermined.
    PartlyDetermined = 3,
    /// No convergence, or stopped before.
    NoConvergence = 4,
}

impl Exit {
    /// Every way to end.
    #[cfg(test)]
    pub const ALL: [Exit; 5] =
        [Exit::Determined, Exit::NotShown, Exit::BadInput, Exit::PartlyDetermined, Exit::NoConvergence];

    /// The number that the shell sees.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// What a calibration comes to: the joint estimator decides where it ran, otherwise the worst of those that did.
    pub fn of_calibration(results: &[EstimatorResult]) -> Exit {
        deciding(results).map_or(Exit::NoConvergence, |result| result.verdict.into())
    }
}

impl From<Verdict> for Exit {
    fn from(verdict: Verdict) -> Exit {
        match verdict {
            Verdict::Determined => Exit::Determined,
            Verdict::PartlyDetermined => Exit::PartlyDetermined,
            Verdict::Failed => Exit::NoConvergence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravcal_calibration::result::{CovarianceResult, Detail};

    fn result(name: &str, verdict: Verdict) -> EstimatorResult {
        EstimatorResult {
            name: name.into(),
            verdict,
            termination: String::new(),
            iterations: 0,
            trace: Vec::new(),
            gravity: None,
            parameters: Vec::new(),
            covariance: CovarianceResult::default(),
            moments: Vec::new(),
            deflections: Vec::new(),
            position_errors: Vec::new(),
            sensor_models: Vec::new(),
            residual_tests: Vec::new(),
            undetermined: Vec::new(),
            active_constraints: Vec::new(),
            weak: Vec::new(),
            held: Vec::new(),
            uncertainty: None,
            loss: None,
            outliers: Vec::new(),
            fit: None,
            payloads: Vec::new(),
            consistent_model: None,
            notes: Vec::new(),
            reasons: 0,
            detail: Detail::default(),
        }
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
        assert_eq!(Exit::of_calibration(&results), Exit::NoConvergence);
    }
}
