//! What moving a load changes in the readings of the joint before the swept one: fitted sinusoids, subtracted (paper, section 3.2).

use gravcal_estimation::{Block, BlockId, Factor, Noise};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::residuals::{MeasuredDifference, Sinusoid, SinusoidBlocks};
use gravcal_robot_model::session::{ReadingId, Session};
use nalgebra::{Matrix3, SMatrix, Vector3};

use super::bias::readings_of;
use super::carried::place;
use super::contradiction::refuse_contradiction;
use super::fitting::{StepFit, StepProblem};
use super::found::{Frozen, Missing};
use super::values::SequentialValues;
use crate::closed_form::fit_sinusoid;
use crate::plan::{LoadPair, Plan};

/// A sweep needs more readings than a sinusoid has numbers.
const NUMBERS: usize = 3;

/// The difference between two placements at one position of the observed joint.
pub(super) struct Difference {
    /// Mean position readings up to the observed joint.
    pub position: Vec<f64>,
    /// `(a, c, e)`, unit of the torque reading.
    pub measured: MeasuredDifference,
    /// Of `(a, c, e)`, given the swept joint's gain.
    pub covariance: Matrix3<f64>,
    /// See [`LoadPair`].
    pub posture: usize,
}

/// The joint whose torque is read while the next one sweeps, and what is known of both.
pub(super) struct Observed<'a> {
    pub session: &'a Session,
    pub plan: &'a Plan,
    pub known: &'a SequentialValues,
    pub joint: usize,
    /// Position gain of the joint that sweeps.
    pub swept_gain: Frozen,
    /// What would help where the sinusoids are none.
    pub cure: String,
}

impl Observed<'_> {
    /// Second placement's fitted sinusoid less the first's, eqs. (17), (18), of each pair; those with too few readings left out.
    pub fn differences(
        &self,
        pairs: &[LoadPair],
        environment: &SolveEnvironment<'_>,
    ) -> Result<Vec<Difference>, Missing> {
        let rows = |sweep: &usize| -> Rows {
            readings_of(self.session, &self.plan.sweeps[*sweep].poses, self.joint + 1, self.joint)
        };
        let mut step = StepProblem::default();
        let block = Block::scalar(SensorParameter::PositionGain.as_str(), "");
        let gain = step.freeze(block, &[self.swept_gain.value], place(self.joint + 1, SensorParameter::PositionGain));
        let mut fitted_pairs: Vec<(&LoadPair, [Sweep; 2])> = Vec::new();
        for pair in pairs {
            let [first, second] = [rows(&pair.sweeps[0]), rows(&pair.sweeps[1])];
            if first.len().min(second.len()) > NUMBERS {
                fitted_pairs.push((pair, [self.add(&mut step, gain, &first)?, self.add(&mut step, gain, &second)?]));
            }
        }
        if fitted_pairs.is_empty() {
            return Ok(Vec::new());
        }
        let fitted = StepFit::solve(step, environment, &self.cure)?;
        let noise = self.known.noise_scale(self.session, self.joint);
        let what = format!("step 3 of {} (sinusoids)", self.session.robot.chain.joints()[self.joint].name);
        refuse_contradiction(&fitted, &self.known.errors, noise, (&what, &self.cure))?;
        Ok(fitted_pairs.iter().map(|(pair, sweeps)| self.difference(&fitted, pair, sweeps)).collect())
    }

    /// Adds the sinusoid of one sweep, from where it fits best.
    fn add(&self, step: &mut StepProblem, position_gain: BlockId, rows: &Rows) -> Result<Sweep, Missing> {
        let id = |pose| ReadingId { pose, channel: self.joint };
        let std: Vec<f64> = rows.iter().map(|(pose, _)| self.known.readings.std(self.session, id(*pose))).collect();
        let noise = Noise::independent(&std).map_err(|e| Missing::new(e.to_string(), &self.cure))?;
        let readings: Vec<(f64, f64)> = rows.iter().map(|(_, reading)| *reading).collect();
        let none = || Missing::new("the sweeps of step 3 form no sinusoid", &self.cure);
        let start = fit_sinusoid(&readings, self.swept_gain.value, None).ok_or_else(none)?.coefficients;
        let name = |what: &str| format!("{what} from pose {}", rows[0].0);
        let turning = Block::vector(name("turning"), "", &["a", "c"]).linear();
        let turning = step.builder.add_block(turning, &[start[0], start[1]]);
        let constant = step.builder.add_block(Block::scalar(name("constant"), "").linear(), &[start[2]]);
        let blocks = SinusoidBlocks { position_gain, torque_bias: constant, coefficients: turning };
        step.builder.add_factor(Factor::new(Sinusoid::new(blocks, readings), noise));
        Ok([turning, constant])
    }

    fn difference(&self, fitted: &StepFit, pair: &LoadPair, sweeps: &[Sweep; 2]) -> Difference {
        let poses: Vec<usize> = pair.sweeps.iter().flat_map(|s| self.plan.sweeps[*s].poses.iter().copied()).collect();
        let sum = |l: usize| poses.iter().map(|pose| self.session.poses[*pose].position[l]).sum::<f64>();
        let (covariance, coefficients, by_gain) = subtracted(fitted, sweeps);
        Difference {
            position: (0..=self.joint).map(|l| sum(l) / poses.len() as f64).collect(),
            measured: MeasuredDifference {
                coefficients: coefficients.into(),
                gain: self.swept_gain.value,
                by_gain: by_gain.into(),
            },
            covariance,
            posture: pair.posture,
        }
    }
}

/// Pose, position of the swept joint and torque of the observed one.
type Rows = Vec<(usize, (f64, f64))>;

/// Blocks `(a, c)` and `e` of a sweep.
type Sweep = [BlockId; 2];

/// Covariance, value and derivative by the gain of the second sweep's `(a, c, e)` less the first's.
fn subtracted(fitted: &StepFit, sweeps: &[Sweep; 2]) -> (Matrix3<f64>, Vector3<f64>, Vector3<f64>) {
    let subtract = SMatrix::<f64, 3, 6>::from_fn(|i, j| match j {
        j if j == i => -1.0,
        j if j == i + 3 => 1.0,
        _ => 0.0,
    });
    let (own, by_gain) = fitted.errors_of(sweeps.iter().flatten().copied());
    let of_sweep = |[turning, constant]: &Sweep| {
        let turning = fitted.values().get(*turning);
        Vector3::new(turning[0], turning[1], fitted.values().scalar(*constant))
    };
    let own = SMatrix::<f64, 6, 6>::from_fn(|i, j| own[(i, j)]);
    let by_gain = SMatrix::<f64, 6, 1>::from_fn(|i, _| by_gain[(i, 0)]);
    (subtract * own * subtract.transpose(), of_sweep(&sweeps[1]) - of_sweep(&sweeps[0]), subtract * by_gain)
}
