//! What an estimator answers. Values in SI (angles in rad); torque readings in the unit of their sensor.
//!
//! The types serialize as they stand in `calibration.json`; what is undetermined has no value, never a number.

mod concern;
mod detail;
mod inertia;
mod joint_sensors;
mod parameter;
mod payload;
mod positions;
mod residual_tests;
mod residuals;

use std::fmt;

use gravcal_estimation::IterationRecord;
use gravcal_robot_model::EstimatorName;
use gravcal_robot_model::parameter::SensorParameter;
use serde::Serialize;

pub use concern::Concern;
pub use detail::Detail;
pub use inertia::LinkInertiaResult;
pub use joint_sensors::JointSensors;
pub use parameter::ParameterResult;
pub use payload::{PayloadNumber, PayloadResult};
pub use positions::{DeflectionResult, PositionErrorResult};
pub use residual_tests::{ResidualTest, ResidualTestKind};
pub use residuals::{ReadingResidual, TorqueParts};

/// One estimator's answer.
#[derive(Clone, Debug, Serialize)]
pub struct EstimatorResult {
    /// `sequential`, `joint`, …
    pub name: String,
    /// Whether everything asked for is determined.
    pub verdict: Verdict,
    /// Why the solver stopped, in words.
    pub termination: String,
    /// Iterations of the solver (of all steps, for the sequential estimator).
    pub iterations: usize,
    /// The way of the last solve, its start first; empty for the sequential estimator, whose steps are many small ones.
    pub trace: Vec<Iteration>,
    /// Gravity in base coordinates; absent where it is undetermined.
    pub gravity: Option<GravityResult>,
    /// Every sensor parameter.
    pub parameters: Vec<ParameterResult>,
    /// Covariance of what is determined: gravity, sensor parameters and combinations of moments.
    pub covariance: CovarianceResult,
    /// Combinations of the links' masses and moments and of load placements that the data determine.
    pub moments: Vec<MomentResult>,
    /// How far standing joints were from where their sensors say, sweep by sweep, where the session has that unknown.
    pub deflections: Vec<DeflectionResult>,
    /// The same pose by pose, in short.
    pub position_errors: Vec<PositionErrorResult>,
    /// Each model of a joint's sensor beyond gain and bias, and of what an instrument's biases drift with, tested against its absence.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensor_models: Vec<SensorModelTest>,
    /// Tests on residuals, what they name first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub residual_tests: Vec<ResidualTest>,
    /// What the data do not determine.
    pub undetermined: Vec<Undetermined>,
    /// Constraints of the session on which the estimate leans.
    pub active_constraints: Vec<ActiveConstraint>,
    /// Combinations of sensor parameters that are known a thousand times worse than the others.
    pub weak: Vec<WeakCombination>,
    /// What was fixed while the rest was solved for; empty for the sequential estimator, which has several problems.
    pub held: Vec<FixedBlock>,
    /// Where standard deviations, intervals and covariance come from; absent where there are none.
    pub uncertainty: Option<UncertaintyResult>,
    /// How torque readings far beyond their noise were counted; absent where as any other.
    pub loss: Option<LossResult>,
    /// Torque readings that the loss counted less than half, those that count least first.
    pub outliers: Vec<Outlier>,
    /// How well the model explains the readings; absent where nothing could be fitted.
    pub fit: Option<Fit>,
    /// Loads of unknown mass.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub payloads: Vec<PayloadResult>,
    /// The links' inertias as a rigid body can have them; absent unless `[constraints]` asks for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub consistent_model: Option<ConsistentModel>,
    /// What does not fit although there are values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub concerns: Vec<Concern>,
    /// Remarks a person should read.
    pub notes: Vec<String>,
    /// How many of the notes, the first ones, say why the verdict is no better.
    pub reasons: usize,
    /// What pictures need besides; no part of any file.
    #[serde(skip)]
    pub detail: Detail,
}

impl EstimatorResult {
    /// With nothing in it yet.
    pub fn blank(name: impl Into<String>, verdict: Verdict, termination: impl Into<String>) -> EstimatorResult {
        EstimatorResult {
            name: name.into(),
            verdict,
            termination: termination.into(),
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
            concerns: Vec::new(),
            notes: Vec::new(),
            reasons: 0,
            detail: Detail::default(),
        }
    }

    /// The parameter of this name (`joint1.torque_gain`).
    pub fn parameter(&self, name: &str) -> Option<&ParameterResult> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// One of the four parameters of a joint's sensors. Nothing where the robot has no such joint.
    ///
    /// ```no_run
    /// # fn report(result: &gravcal_calibration::result::EstimatorResult) {
    /// use gravcal_robot_model::parameter::SensorParameter;
    ///
    /// if let Some((gain, std)) = result.sensor("joint2", SensorParameter::TorqueGain).and_then(|gain| gain.estimate()) {
    ///     println!("{gain} ± {std}");
    /// }
    /// # }
    /// ```
    pub fn sensor(&self, joint: &str, quantity: SensorParameter) -> Option<&ParameterResult> {
        self.parameter(&quantity.name(joint))
    }

    /// The sensors of every joint that has a coordinate of its own, in the robot's order.
    ///
    /// ```no_run
    /// # fn report(result: &gravcal_calibration::result::EstimatorResult) {
    /// for sensors in result.joints() {
    ///     if let Some((gain, std)) = sensors.torque_gain.estimate() {
    ///         println!("{}: {gain} ± {std} {}", sensors.joint, sensors.torque_gain.unit);
    ///     }
    /// }
    /// # }
    /// ```
    pub fn joints(&self) -> impl Iterator<Item = JointSensors<'_>> {
        joint_sensors::sensors_of_joints(&self.parameters)
    }
}

/// The result that decides what a calibration comes to: the joint one where it ran, otherwise the worst.
pub fn deciding(results: &[EstimatorResult]) -> Option<&EstimatorResult> {
    let joint = results.iter().find(|result| result.name == EstimatorName::Joint.as_str());
    // Of several that are as bad the first.
    joint.or_else(|| results.iter().rev().max_by_key(|result| result.verdict))
}

/// What an estimator says of sensors and gravity alone: for batches.
#[derive(Clone, Debug)]
pub struct Brief {
    /// Whether everything asked for is determined.
    pub verdict: Verdict,
    /// Why the solver stopped, or what is wrong, in words.
    pub termination: String,
    /// Iterations of the solver (of all steps, for the sequential estimator).
    pub iterations: usize,
    /// Gravity in base coordinates; absent where it is undetermined.
    pub gravity: Option<GravityResult>,
    /// Every sensor parameter.
    pub parameters: Vec<ParameterResult>,
}

/// One iteration of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Iteration {
    /// Cost ½ Σ r² of the residuals in standard deviations after it.
    pub cost: f64,
    /// Largest |cosine| between the residual and a column of the Jacobian there: 0 at a solution.
    pub largest_cosine: f64,
    /// Length of the step, relative to what it moves.
    pub step: f64,
    /// Damping of the step; 0 for methods without.
    pub damping: f64,
}

impl From<&IterationRecord> for Iteration {
    fn from(record: &IterationRecord) -> Iteration {
        let IterationRecord { iteration: _, cost, cosine, step, damping } = *record;
        Iteration { cost, largest_cosine: cosine, step, damping }
    }
}

/// The estimator's verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Everything asked for is determined.
    Determined,
    /// Solved, but something asked for is undetermined.
    PartlyDetermined,
    /// No answer.
    Failed,
}

/// Gravity in base coordinates.
#[derive(Clone, Debug, Serialize)]
pub struct GravityResult {
    /// m/s².
    pub vector_m_per_s2: [f64; 3],
    /// Standard deviation of each component, m/s².
    pub std_m_per_s2: [f64; 3],
    /// 95 % interval of each component, m/s².
    pub ci95_m_per_s2: [[f64; 2]; 3],
    /// Half-angle of the cone about the vector that holds the true direction with 95 % probability, degrees.
    pub cone95_deg: f64,
    /// Whether it was asked for.
    pub asked: bool,
}

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

/// A covariance matrix with the names of its rows.
#[derive(Clone, Debug, Default, Serialize)]
pub struct CovarianceResult {
    /// `gravity.x`, `joint1.torque_gain`, …, and `moments[0]` for the first of the result's `moments`.
    pub order: Vec<String>,
    /// Rows of the matrix, in the products of the parameters' units.
    pub matrix: Vec<Vec<f64>>,
}

/// A combination `Σ coefficient · parameter` of masses, moments and placements that the data determine.
#[derive(Clone, Debug, Serialize)]
pub struct MomentResult {
    /// Parameter and coefficient; `link1.mass` (kg), `link1.first_moment.x` (kg·m), `load.plate-a.position.x` (m).
    /// `load.plate-b.displacement_from.plate-a.x` (m) is the position of plate-b less that of plate-a.
    pub terms: Vec<(String, f64)>,
    /// Value of the combination.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// A combination of sensor parameters that the data do not determine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Undetermined {
    /// The combination in words, such as `common scale of all torque gains`.
    pub combination: String,
    /// The parameters in it.
    pub parameters: Vec<String>,
    /// Why.
    pub why: String,
    /// Which pose or load would determine it.
    pub cure: String,
}

/// A step of the sensor parameters that changes the readings hardly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeakCombination {
    /// In words: `1.00 joint1.torque_gain − 0.35 joint2.torque_gain`.
    pub combination: String,
    /// Parameter, unit and how far it moves.
    pub terms: Vec<(String, String, f64)>,
    /// How many times the standard deviation along it exceeds that of the median direction, in units of what each
    /// parameter does to the readings.
    pub times_worse: f64,
}

/// A block of the joint problem that was fixed while the rest was solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FixedBlock {
    /// `joint1.position_offset`.
    pub name: String,
    /// At which values, in SI or the unit of the reading.
    pub value: Vec<f64>,
    /// Why: a choice of frame or gauge, exact knowledge, too little information.
    pub why: String,
}

/// Where standard deviations, intervals and covariance come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum UncertaintyResult {
    /// From the noise of the readings, if the model holds.
    Noise {
        /// How large it is.
        source: NoiseSource,
        /// By how much it was widened because the residuals exceed it.
        widened_by: Option<f64>,
    },
    /// From what the estimate would be without each of some blocks of poses.
    Jackknife(JackknifeResult),
    /// The larger of what the noise tells and of the same.
    LargerOfNoiseAndJackknife {
        /// How large the noise is.
        source: NoiseSource,
        /// By how much what it tells was widened because the residuals exceed it.
        widened_by: Option<f64>,
        /// What leaving out poses tells.
        jackknife: JackknifeResult,
    },
    /// From the scatter of blocks of neighbouring poses.
    Sandwich {
        /// How many.
        blocks: usize,
        /// Poses in a block, at least.
        block_poses: usize,
    },
    /// From solving again with such blocks drawn at random.
    Bootstrap {
        /// How many.
        blocks: usize,
        /// Poses in a block, at least.
        block_poses: usize,
        /// Replicates that count.
        replicates: usize,
        /// Replicates that did not converge.
        not_converged: usize,
        /// Replicates whose poses determine less than all poses do.
        undetermined: usize,
    },
}

/// Blocks of poses, each left out in its turn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JackknifeResult {
    /// How many.
    pub blocks: usize,
    /// Poses in the shortest and in the longest of them.
    pub block_poses: [usize; 2],
    /// Correlation of the residuals of neighbouring poses, where the length of blocks was found by it.
    pub correlation: Option<f64>,
    /// Poses that a block should have for that correlation, where there are too few for such blocks.
    pub too_short_for: Option<usize>,
    /// Channels whose errors outlast blocks: the jackknife takes neighbouring blocks to be independent.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub correlated_blocks: Vec<CorrelatedBlocks>,
    /// Parameters that were asked for, and gravity, of which one block alone tells a part: no scatter tells how well.
    pub told_by_one_block: Vec<String>,
}

/// A channel whose errors outlast blocks of poses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CorrelatedBlocks {
    /// A joint, or an axis of an instrument.
    pub channel: String,
    /// Correlation of the sums of its residuals over neighbouring blocks.
    pub correlation: f64,
}

impl fmt::Display for JackknifeResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let poses = match self.block_poses {
            [1, 1] => "a pose each".to_owned(),
            [least, most] if least == most => format!("{least} poses"),
            [least, most] => format!("{least} to {most} poses"),
        };
        write!(f, "jackknife over {} blocks of {poses}", self.blocks)
    }
}

impl UncertaintyResult {
    /// What leaving out poses tells, where that is a part of it.
    pub fn jackknife(&self) -> Option<&JackknifeResult> {
        match self {
            UncertaintyResult::Jackknife(jackknife)
            | UncertaintyResult::LargerOfNoiseAndJackknife { jackknife, .. } => Some(jackknife),
            _ => None,
        }
    }
}

/// Where the size of the noise is known from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseSource {
    /// The session.
    Stated,
    /// The residuals.
    Residuals,
    /// The session or the recordings, and the residuals what that does not explain, joint by joint.
    StatedAndUnexplained,
}

impl fmt::Display for UncertaintyResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UncertaintyResult::Noise { source: NoiseSource::Residuals, .. } => {
                write!(f, "from the noise that the residuals show")
            }
            UncertaintyResult::Noise { source: NoiseSource::StatedAndUnexplained, .. } => {
                write!(f, "from the stated noise and what of each joint's residuals it does not explain")
            }
            UncertaintyResult::Noise { widened_by: None, .. } => write!(f, "from the stated noise"),
            UncertaintyResult::Noise { widened_by: Some(factor), .. } => {
                write!(f, "from the stated noise, widened {factor:.1} times")
            }
            UncertaintyResult::Jackknife(jackknife) => write!(f, "robust to model error ({jackknife})"),
            UncertaintyResult::LargerOfNoiseAndJackknife { source, widened_by, jackknife } => {
                let noise = UncertaintyResult::Noise { source: *source, widened_by: *widened_by };
                write!(f, "{noise}, or robust to model error ({jackknife}) where that is larger")
            }
            UncertaintyResult::Sandwich { blocks, block_poses } => {
                write!(f, "robust to model error (sandwich over {blocks} blocks of {block_poses} poses)")
            }
            UncertaintyResult::Bootstrap { blocks, block_poses, replicates, not_converged, undetermined } => {
                write!(
                    f,
                    "robust to model error (bootstrap of {blocks} blocks of {block_poses} poses, {replicates} replicates; \
                     {not_converged} did not converge, {undetermined} lacked poses that determine everything)"
                )
            }
        }
    }
}

/// A robust loss.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LossResult {
    /// `huber`, `cauchy`, `tukey` or `geman-mcclure`.
    pub kind: &'static str,
    /// In standard deviations.
    pub width: f64,
}

/// A torque reading that a loss counted less than half.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outlier {
    /// File name of the table.
    pub table: String,
    /// Line in it.
    pub line: u64,
    /// The joint.
    pub joint: String,
    /// Prediction less reading, in standard deviations of the reading.
    pub residual_in_std: f64,
    /// From 0 (not at all) to 1 (as any other).
    pub weight: f64,
}

impl fmt::Display for Outlier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Outlier { table, line, joint, residual_in_std, weight } = self;
        write!(f, "{table}:{line} {joint} ({residual_in_std:+.1} std, weight {weight:.2})")
    }
}

/// A constraint of the session on which an estimate leans.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ActiveConstraint {
    /// In words, such as `link2.mass is at least 0`.
    pub constraint: String,
    /// By how much ½ χ² would fall for each unit by which the constraint gives way.
    pub multiplier: f64,
    /// That unit: of the mass, of the gain, or of the moment about the origin of the link's frame.
    pub unit: String,
}

/// How well a model explains the readings.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Sum of squared residuals in standard deviations, outliers included.
    pub chi_squared: f64,
    /// Rows less the number of parameters that the data determine.
    pub degrees_of_freedom: usize,
    /// Probability of a χ² at least as large if the model and the stated noise hold; absent where the noise was
    /// estimated from the residuals. Under a loss, which lets χ² be anything, it is that of as many residuals beyond the
    /// median of normal noise.
    pub p_value: Option<f64>,
    /// Median |residual| over that of normal noise as stated; only under a loss, and with stated noise.
    pub median_ratio: Option<f64>,
    /// By joint, torque readings only.
    pub joints: Vec<JointFit>,
    /// The same for poses that a fit did not see: those of `[[validation]]`, else stretches, a tenth of all poses, that a second fit
    /// did not see.
    pub held_out: Option<HeldOut>,
    /// Why no poses were predicted, if that failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out_missing: Option<String>,
    /// How well smaller models predict these poses, the smallest first; where the arm was read in motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub smaller_models: Vec<SmallerModel>,
    /// Every reading beside what the model makes of it, in the order of the poses; not in `calibration.json`.
    #[serde(skip)]
    pub residuals: Vec<ReadingResidual>,
}

/// A smaller model than the session's, fitted to the same readings.
#[derive(Clone, Debug, Serialize)]
pub struct SmallerModel {
    /// What it has.
    pub kind: SmallerModelKind,
    /// How well it predicts readings that it has not seen.
    pub held_out: HeldOut,
}

/// What a model of an arm in motion may be without.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SmallerModelKind {
    /// Gravity and biases; neither friction nor inertia.
    Gravity,
    /// The same with friction, but without inertia.
    GravityAndFriction,
}

/// Errors of a joint's readings beyond their noise: see [`UnexplainedError`](gravcal_robot_model::session::UnexplainedError).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnexplainedResult {
    /// Standard deviation, unit of the reading; 0 where the noise explains the residuals.
    pub std: f64,
    /// Whether it was estimated from the residuals.
    pub estimated: bool,
    /// How many times the noise of the readings that is.
    pub times_noise: f64,
    /// Standard deviation over the poses of what gravity makes the joint read, unit of the reading.
    pub gravity_std: f64,
    /// `std` as a share of that, or of a tenth of the largest like it of any joint, where that is more; absent where nothing feels
    /// gravity.
    pub share_of_gravity: Option<f64>,
}

/// Residuals of one joint's torque readings.
#[derive(Clone, Debug, Serialize)]
pub struct JointFit {
    /// The joint.
    pub joint: String,
    /// Unit of what follows.
    pub unit: String,
    /// How many.
    pub readings: usize,
    /// Root mean square.
    pub rms: f64,
    /// Largest |residual|.
    pub largest: f64,
    /// Standard deviation of the noise that the fit assumed (mean over the readings), without unexplained errors.
    pub noise_std: f64,
    /// Whether that was estimated from the residuals.
    pub noise_estimated: bool,
    /// Errors beyond that noise, where the session has such; told of the fit alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unexplained: Option<UnexplainedResult>,
    /// Largest less smallest reading of that joint in the fitted tables.
    pub range: f64,
}

/// The links' inertias for simulations and controllers: those of rigid bodies, nearest to what the robot's file assumes and to what the
/// readings say. Sensors and gravity are those of the estimate without it.
#[derive(Clone, Debug, Serialize)]
pub struct ConsistentModel {
    /// Every link that a joint moves, without loads.
    pub links: Vec<LinkInertiaResult>,
    /// How well each link of the robot's file was taken to be known, relative to it.
    pub relative_std: Vec<f64>,
    /// Whether the arm moved; if not, tensors are those of the robot's file.
    pub tensors_from_readings: bool,
    /// By how much the readings were taken to say less than their noise alone makes them: told variances over those of the noise.
    pub variance_inflation: f64,
    /// By how much worse the readings are explained than without it: growth of χ², in told standard deviations.
    pub chi_squared_growth: f64,
    /// How well it predicts the tables of `[[validation]]`, with the sensors and the gravity that go best with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
}

/// Prediction of poses that were left out of the fit.
#[derive(Clone, Debug, Serialize)]
pub struct HeldOut {
    /// How many poses.
    pub poses: usize,
    /// In how many stretches of consecutive ones.
    pub stretches: usize,
    /// The files of `[[validation]]` that they stand in; none where they are a part of the fitted tables.
    pub files: Vec<String>,
    /// Sum of squared prediction errors in standard deviations of the readings.
    pub chi_squared: f64,
    /// How many readings.
    pub readings: usize,
    /// By joint.
    pub joints: Vec<JointFit>,
}
