//! Whether the readings need the models of sensors beyond gain and bias: each tested against its absence.
//!
//! With the `p` parameters of one model held at zero and everything else solved for again, χ² grows by `Δ`. If they are zero,
//!
//! ```text
//!     Δ ~ χ²(p)                          noise as stated (likelihood ratio)
//!     (Δ / p) / (χ² / dof) ~ F(p, dof)   noise from the residuals
//! ```
//!
//! So with the drifts of an instrument's biases, of all its axes together. That each table has biases of its own is tested by their
//! differences `a`, which are linear in what is estimated: `aᵀ Σ⁻¹ a` is how much χ² grows where all tables have the same.
//!
//! Where standard deviations are robust to model error, or readings are counted by a loss, χ² means neither, and `aᵀ Σ⁻¹ a ~ χ²(p)`
//! with the covariance `Σ` of the estimate `a` is asked instead (Wald).

use std::ops::Range;

use gravcal_estimation::statistics::LinearFunction;
use gravcal_estimation::{BlockId, Loss};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::ParameterId;
use gravcal_robot_model::session::{AuxiliarySensor, Drift, Session};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::solving::fit::fit;
use crate::joint::variables::State;
use crate::judgement::Judgement;
use crate::result::{Fit, NoiseSource, SensorModelTest, TestAgainstZero, TestKind, UncertaintyResult};

/// Why a parameter is fixed in the problem without it.
const ABSENT: &str = "tested against zero";

/// What the tests are made of.
pub(in crate::joint) struct ModelTests<'a> {
    pub session: &'a Session,
    pub solved: &'a Solved,
    pub judgement: &'a Judgement,
    pub fit: &'a Fit,
    pub uncertainty: &'a UncertaintyResult,
}

impl ModelTests<'_> {
    /// Tests every model of the session.
    pub fn all(&self, environment: &SolveEnvironment<'_>) -> Result<Vec<SensorModelTest>, EstimateError> {
        let vanishing = self.session.terms.models().filter(|model| model.vanishes_at_zero(&self.session.poses));
        let of_joints = vanishing.map(|model| {
            self.one(&self.session.robot.chain.joints()[model.joint].name, model.name, model.places(), environment)
        });
        let drifts = self.session.instruments.iter().flat_map(|instrument| {
            let of_drift = |(place, drift): (usize, &Drift)| {
                let axes = instrument.kind.axes().len();
                let first = instrument.drift_parameters().start + place * axes;
                self.one(&instrument.name, drift.as_str(), first..first + axes, environment)
            };
            instrument.drifts.iter().enumerate().map(of_drift).collect::<Vec<_>>()
        });
        let of_tables = self.session.instruments.iter().filter(|instrument| instrument.biases > 1);
        of_joints.chain(drifts).chain(of_tables.map(|instrument| Ok(self.of_tables(instrument)))).collect()
    }

    fn one(
        &self,
        owner: &str,
        model: &str,
        places: Range<usize>,
        environment: &SolveEnvironment<'_>,
    ) -> Result<SensorModelTest, EstimateError> {
        // One that several sensors share is absent from all of them.
        let reported = |place: usize| ParameterId::Further(self.session.further[place].same_as.unwrap_or(place));
        let parameters: Vec<ParameterId> = places.map(reported).filter(|id| self.is_free(*id)).collect();
        let test = if self.determined(&parameters) { self.test(&parameters, environment)? } else { None };
        Ok(self.reported(owner, model, &parameters, test))
    }

    /// Whether the biases of an instrument differ from table to table.
    fn of_tables(&self, instrument: &AuxiliarySensor) -> SensorModelTest {
        let axes = instrument.kind.axes().len();
        let bias =
            |set: usize, axis: usize| ParameterId::Further(instrument.bias_parameters().start + set * axes + axis);
        let of_axis = |axis: usize| (0..instrument.biases).map(|set| bias(set, axis)).collect::<Vec<_>>();
        let free = |axis: &Vec<ParameterId>| axis.iter().all(|id| self.is_free(*id));
        let by_axis: Vec<Vec<ParameterId>> = (0..axes).map(of_axis).filter(free).collect();
        let parameters = by_axis.concat();
        let test = if self.determined(&parameters) { self.differences(&by_axis) } else { None };
        self.reported(&instrument.name, "biases-of-tables", &parameters, test)
    }

    fn reported(
        &self,
        owner: &str,
        model: &str,
        parameters: &[ParameterId],
        test: Option<TestAgainstZero>,
    ) -> SensorModelTest {
        let parameters = parameters.iter().map(|id| self.session.parameter_name(*id)).collect();
        SensorModelTest { joint: owner.to_owned(), model: model.to_owned(), parameters, test }
    }

    fn determined(&self, parameters: &[ParameterId]) -> bool {
        !parameters.is_empty() && parameters.iter().all(|id| self.judgement.determines(*id))
    }

    fn is_free(&self, id: ParameterId) -> bool {
        self.session.parameter(id).fixed.is_none()
    }

    fn test(
        &self,
        parameters: &[ParameterId],
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<TestAgainstZero>, EstimateError> {
        let Some(stated) = self.noise_stated() else { return Ok(self.wald(parameters)) };
        let Some(growth) = self.growth_without(parameters, environment)? else { return Ok(None) };
        let (count, dof) = (parameters.len(), self.fit.degrees_of_freedom);
        Ok(if stated {
            chi_squared(TestKind::LikelihoodRatio, growth, count)
        } else {
            f(growth / count as f64 / (self.fit.chi_squared / dof as f64), count, dof)
        })
    }

    /// Whether the noise is as stated, or from the residuals; nothing where standard deviations come from neither.
    fn noise_stated(&self) -> Option<bool> {
        match self.uncertainty {
            UncertaintyResult::Noise { source, widened_by } if self.solved.built.loss == Loss::None => {
                Some(*source == NoiseSource::Stated && widened_by.is_none())
            }
            _ => None,
        }
    }

    /// By how much χ² grows where the parameters are zero; `None` where that problem does not converge.
    fn growth_without(
        &self,
        parameters: &[ParameterId],
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<f64>, EstimateError> {
        let solved = self.solved;
        let mut start = solved.state(&State::nominal(self.session));
        parameters.iter().for_each(|id| *start.value_mut(*id) = 0.0);
        let built = build_with_constraints(self.session, solved.readings(), &start)?.with_loss(solved.built.loss)?;
        let fixed: Vec<BlockId> = parameters.iter().map(|id| built.variables.block(*id)).collect();
        let absent = built.problem.with_fixed(&fixed, ABSENT);
        let (_, without) = fit(&built.with_problem(absent), environment)?;
        Ok(without.termination.converged().then(|| 2.0 * (without.cost - solved.least_cost()).max(0.0)))
    }

    fn wald(&self, parameters: &[ParameterId]) -> Option<TestAgainstZero> {
        let solved = self.solved;
        let blocks: Vec<BlockId> = parameters.iter().map(|id| solved.built.variables.block(*id)).collect();
        let covariance = solved.covariance().stored(&solved.built.problem, &solved.estimate.values, &blocks);
        let values: Vec<f64> = blocks.iter().map(|id| solved.estimate.values.scalar(*id)).collect();
        chi_squared(TestKind::Wald, weighted_square(&values, &covariance)?, values.len())
    }

    /// Whether all parameters of each group are the same.
    fn differences(&self, groups: &[Vec<ParameterId>]) -> Option<TestAgainstZero> {
        let solved = self.solved;
        let block = |id: &ParameterId| solved.built.variables.block(*id);
        let pairs: Vec<[BlockId; 2]> =
            groups.iter().flat_map(|group| group.iter().skip(1).map(|id| [block(id), block(&group[0])])).collect();
        let column = |id: &BlockId| solved.built.problem.columns_of(*id).next();
        let function = |[a, b]: &[BlockId; 2]| Some(vec![(column(a)?, 1.0), (column(b)?, -1.0)]);
        let functions: Vec<LinearFunction> = pairs.iter().map(function).collect::<Option<_>>()?;
        let difference = |[a, b]: &[BlockId; 2]| solved.estimate.values.scalar(*a) - solved.estimate.values.scalar(*b);
        let values: Vec<f64> = pairs.iter().map(difference).collect();
        let square = weighted_square(&values, &solved.covariance().of(&functions))?;
        let (count, dof) = (values.len(), self.fit.degrees_of_freedom);
        match self.noise_stated() {
            Some(true) => chi_squared(TestKind::LikelihoodRatio, square, count),
            // The covariance is scaled by what the residuals show.
            Some(false) => f(square / count as f64, count, dof),
            None => chi_squared(TestKind::Wald, square, count),
        }
    }
}

/// `aᵀ Σ⁻¹ a`; nothing where Σ has no inverse.
fn weighted_square(values: &[f64], covariance: &[f64]) -> Option<f64> {
    let (count, values) = (values.len(), DVector::from_column_slice(values));
    let weighted = DMatrix::from_row_slice(count, count, covariance).cholesky()?.solve(&values);
    Some(values.dot(&weighted))
}

fn f(statistic: f64, parameters: usize, dof: usize) -> Option<TestAgainstZero> {
    FisherSnedecor::new(parameters as f64, dof as f64).ok().map(|distribution| TestAgainstZero {
        kind: TestKind::F,
        statistic,
        degrees_of_freedom: [Some(parameters), Some(dof)],
        p_value: distribution.sf(statistic),
    })
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
    use gravcal_robot_model::sensors::Options;
    use gravcal_robot_model::session::{Session, UncertaintyChoice};

    use crate::result::{SensorModelTest, TestKind};
    use crate::testing::sensor_models::{estimate, shoulder, with_model};

    fn with_drift(drift: f64, trial: u64) -> Session {
        with_model(shoulder(), 1, "torque-bias-in-time", &Options::default(), &[drift]).session(trial)
    }

    fn tested(session: &Session) -> SensorModelTest {
        let [test] = estimate(session).sensor_models.try_into().unwrap();
        test
    }

    #[test]
    fn a_term_that_is_there_is_needed() {
        let reported = tested(&with_drift(2e-3, 0));
        assert_eq!((reported.joint.as_str(), reported.model.as_str()), ("joint2", "torque-bias-in-time"));
        assert_eq!(reported.parameters, ["joint2.torque_bias_drift"]);
        let test = reported.test.unwrap();
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
