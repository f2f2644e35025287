//! What an estimator answers. Values in SI (angles in rad); torque readings in the unit of their sensor.
//!
//! The types serialize as they stand in `calibration.json`; what is undetermined has no value, never a number.

mod concern;
mod detail;
mod fit;
mod inertia;
mod joint_sensors;
mod parameter;
mod payload;
mod positions;
mod residual_tests;
mod residuals;
mod sensor_models;
mod taken_as_exact;
mod uncertainty;

use std::fmt;

use gravcal_estimation::IterationRecord;
use gravcal_robot_model::EstimatorName;
use gravcal_robot_model::parameter::SensorParameter;
use serde::Serialize;

pub use concern::Concern;
pub use detail::Detail;
pub use fit::{Fit, HeldOut, JointFit, SmallerModel, SmallerModelKind, UnexplainedResult};
pub use inertia::{ConsistentModel, LinkInertiaResult};
pub use joint_sensors::JointSensors;
pub use parameter::ParameterResult;
pub use payload::{PayloadNumber, PayloadResult};
pub use positions::{DeflectionResult, PositionErrorResult};
pub use residual_tests::{ResidualTest, ResidualTestKind};
pub use residuals::{ReadingResidual, TorqueParts};
pub use sensor_models::{SensorModelTest, TestAgainstZero, TestKind};
pub use taken_as_exact::TakenAsExact;
pub use uncertainty::{CorrelatedBlocks, JackknifeResult, NoiseSource, UncertaintyResult};

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
    /// Gravity in base coordinates; `null` where it is undetermined.
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
    /// What the session takes as exact and numbers hang on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub taken_as_exact: Vec<TakenAsExact>,
    /// What the data do not determine.
    pub undetermined: Vec<Undetermined>,
    /// Constraints of the session on which the estimate leans.
    pub active_constraints: Vec<ActiveConstraint>,
    /// Combinations of sensor parameters that are known a thousand times worse than the others.
    pub weak: Vec<WeakCombination>,
    /// What was fixed while the rest was solved for; empty for the sequential estimator, which has several problems.
    pub held: Vec<FixedBlock>,
    /// Where standard deviations, intervals and covariance come from; `null` where there are none.
    pub uncertainty: Option<UncertaintyResult>,
    /// How torque readings far beyond their noise were counted; `null` where as any other.
    pub loss: Option<LossResult>,
    /// Torque readings that the loss counted less than half, those that count least first.
    pub outliers: Vec<Outlier>,
    /// How well the model explains the readings; `null` where nothing could be fitted.
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
            taken_as_exact: Vec::new(),
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
    /// Gravity in base coordinates; `null` where it is undetermined.
    pub gravity: Option<GravityResult>,
    /// Every sensor parameter.
    pub parameters: Vec<ParameterResult>,
}

impl Brief {
    /// The parameter of this name (`joint1.torque_gain`).
    pub fn parameter(&self, name: &str) -> Option<&ParameterResult> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }
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
