//! Whether the readings need the models of sensors beyond gain and bias: each tested against its absence.
//!
//! With the `p` parameters of one model held at zero and everything else solved for again, χ² grows by `Δ`. If they are zero,
//!
//! ```text
//!     Δ ~ χ²(p)                          noise as stated (likelihood ratio)
//!     (Δ / p) / (χ² / dof) ~ F(p, dof)   noise from the residuals
//! ```
//!
//! Where standard deviations are robust to model error, or readings are counted by a loss, χ² means neither, and `aᵀ Σ⁻¹ a ~ χ²(p)`
//! with the covariance `Σ` of the estimate `a` is asked instead (Wald).

use gravcal_estimation::{BlockId, Loss};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use super::fit::fit;
use super::problem::{JointProblem, pose_with_constraints};
use super::{EstimateError, Solved, Unknowns};
use crate::judgement::Judgement;
use crate::parameter::ParameterId;
use crate::result::{Fit, NoiseSource, SensorModelTest, TestAgainstZero, TestKind, UncertaintyResult};
use crate::session::Session;
use crate::workbench::Workbench;

/// Why a parameter is held in the problem without it.
const ABSENT: &str = "tested against zero";

/// What the tests are made of.
pub(super) struct ModelTests<'a> {
    pub session: &'a Session,
    pub solved: &'a Solved,
    pub judgement: &'a Judgement,
    pub fit: &'a Fit,
    pub uncertainty: &'a UncertaintyResult,
}

impl ModelTests<'_> {
    /// Tests every model of the session.
    pub fn all(&self, workbench: &Workbench<'_>) -> Result<Vec<SensorModelTest>, EstimateError> {
        let models = self.session.terms.models().into_iter();
        let tests = models.map(|(joint, model, places)| {
            let parameters: Vec<ParameterId> =
                places.map(ParameterId::Further).filter(|id| self.is_free(*id)).collect();
            let determined = !parameters.is_empty() && parameters.iter().all(|id| self.judgement.determines(*id));
            Ok(SensorModelTest {
                joint: self.session.robot.chain.joints()[joint].name.clone(),
                model: model.as_str(),
                parameters: parameters.iter().map(|id| self.session.parameter_name(*id)).collect(),
                test: if determined { self.test(&parameters, workbench)? } else { None },
            })
        });
        tests.collect()
    }

    fn is_free(&self, id: ParameterId) -> bool {
        self.session.parameter(id).held.is_none()
    }

    fn test(
        &self,
        parameters: &[ParameterId],
        workbench: &Workbench<'_>,
    ) -> Result<Option<TestAgainstZero>, EstimateError> {
        let from_noise = match self.uncertainty {
            UncertaintyResult::Noise { source, widened_by } if self.solved.posed.loss == Loss::None => {
                Some(*source == NoiseSource::Stated && widened_by.is_none())
            }
            _ => None,
        };
        let Some(stated) = from_noise else { return Ok(self.wald(parameters)) };
        let Some(growth) = self.growth_without(parameters, workbench)? else { return Ok(None) };
        let (count, dof) = (parameters.len(), self.fit.degrees_of_freedom);
        Ok(if stated {
            chi_squared(TestKind::LikelihoodRatio, growth, count)
        } else {
            let statistic = growth / count as f64 / (self.fit.chi_squared / dof as f64);
            FisherSnedecor::new(count as f64, dof as f64).ok().map(|distribution| TestAgainstZero {
                kind: TestKind::F,
                statistic,
                degrees_of_freedom: [Some(count), Some(dof)],
                p_value: distribution.sf(statistic),
            })
        })
    }

    /// By how much χ² grows where the parameters are zero; `None` where that problem does not converge.
    fn growth_without(
        &self,
        parameters: &[ParameterId],
        workbench: &Workbench<'_>,
    ) -> Result<Option<f64>, EstimateError> {
        let solved = self.solved;
        let mut start = solved.unknowns(&Unknowns::nominal(self.session));
        parameters.iter().for_each(|id| *start.value_mut(*id) = 0.0);
        let posed = pose_with_constraints(self.session, &solved.readings, &start)?.with_loss(solved.posed.loss)?;
        let held: Vec<BlockId> = parameters.iter().map(|id| posed.layout.block(*id)).collect();
        let absent = JointProblem { problem: posed.problem.holding(&held, ABSENT), ..posed };
        let (_, without) = fit(&absent, &solved.readings, workbench)?;
        Ok(without.termination.converged().then(|| 2.0 * (without.cost - solved.estimate.cost).max(0.0)))
    }

    fn wald(&self, parameters: &[ParameterId]) -> Option<TestAgainstZero> {
        let solved = self.solved;
        let blocks: Vec<BlockId> = parameters.iter().map(|id| solved.posed.layout.block(*id)).collect();
        let covariance = solved.covariance().stored(&solved.posed.problem, &solved.estimate.values, &blocks);
        let count = parameters.len();
        let values = DVector::from_iterator(count, blocks.iter().map(|id| solved.estimate.values.scalar(*id)));
        let weighted = DMatrix::from_row_slice(count, count, &covariance).cholesky()?.solve(&values);
        chi_squared(TestKind::Wald, values.dot(&weighted), count)
    }
}

fn chi_squared(kind: TestKind, statistic: f64, parameters: usize) -> Option<TestAgainstZero> {
    ChiSquared::new(parameters as f64).ok().map(|distribution| TestAgainstZero {
        kind,
        statistic,
        degrees_of_freedom: [Some(parameters), None],
        p_value: distribution.sf(statistic),
    })
}

#[cfg(test)]
mod tests {
    use crate::result::{SensorModelTest, TestKind};
    use crate::sensors::testing::{estimate, shoulder, with_model};
    use crate::sensors::{Options, SensorModelName};
    use crate::session::{Session, UncertaintyChoice};

    fn with_drift(drift: f64, trial: u64) -> Session {
        with_model(shoulder(), 1, SensorModelName::TorqueBiasInTime, &Options::default(), &[drift]).session(trial)
    }

    fn tested(session: &Session) -> SensorModelTest {
        let [test] = estimate(session).sensor_models.try_into().unwrap();
        test
    }

    #[test]
    fn a_term_that_is_there_is_needed() {
        let told = tested(&with_drift(2e-3, 0));
        assert_eq!((told.joint.as_str(), told.model), ("joint2", "torque-bias-in-time"));
        assert_eq!(told.parameters, ["joint2.torque_bias_drift"]);
        let test = told.test.unwrap();
        assert_eq!((test.kind, test.degrees_of_freedom), (TestKind::LikelihoodRatio, [Some(1), None]));
        assert!(test.p_value < 1e-12 && test.statistic > 100.0, "{test:?}");
    }

    /// Of terms that are not there, about one in twenty has p < 0.05.
    #[test]
    fn p_values_of_a_term_that_is_not_there_are_evenly_spread() {
        let values: Vec<f64> = (0..60).map(|trial| tested(&with_drift(0.0, trial)).test.unwrap().p_value).collect();
        let below = |level: f64| values.iter().filter(|p| **p < level).count();
        assert!(below(0.05) <= 9 && (18..=42).contains(&below(0.5)), "{values:?}");
    }

    #[test]
    fn noise_from_the_residuals_makes_it_an_f_test_and_robust_uncertainty_that_of_wald() {
        let mut session = with_drift(2e-3, 0);
        session.uncertainty = UncertaintyChoice::Sandwich { block_poses: 5 };
        let wald = tested(&session).test.unwrap();
        assert!(wald.kind == TestKind::Wald && wald.p_value < 1e-6, "{wald:?}");
        session.uncertainty = UncertaintyChoice::Noise;
        for reading in session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()) {
            reading.std = None;
        }
        let f = tested(&session).test.unwrap();
        assert!(f.kind == TestKind::F && f.degrees_of_freedom[1].unwrap() > 1000 && f.p_value < 1e-6, "{f:?}");
    }
}
