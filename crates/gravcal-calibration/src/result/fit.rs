//! How well a model explains readings, and predicts others.

use serde::Serialize;

use super::residuals::ReadingResidual;

/// How well a model explains the readings.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Sum of squared residuals in standard deviations, outliers included, where the readings are explained best: where much is open, the
    /// estimate rests beside that.
    pub chi_squared: f64,
    /// Rows less the number of parameters that the data determine.
    pub degrees_of_freedom: usize,
    /// Probability of a χ² at least as large if the model and the stated noise hold; `null` where the noise was
    /// estimated from the residuals. Where only some channels state their noise it is that of their own residuals. Under a loss, which lets χ² be
    /// anything, it is that of as many residuals beyond the median of normal noise.
    pub p_value: Option<f64>,
    /// How many times as large as their stated noise makes them those residuals are; `null` where `p_value` is.
    pub times_noise: Option<f64>,
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

/// Errors of a joint's readings beyond their noise, as `unexplained_std` of `[readings.torque]` allows for them.
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
    /// `std` as a share of that, or of a tenth of the largest like it of any joint, where that is more; `null` where nothing feels
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
    /// Standard deviation of errors that stay the same while the joint stands, as static friction does; where residuals show any. A stay of several readings
    /// has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lasting_std: Option<f64>,
    /// Largest less smallest reading of that joint in the fitted tables.
    pub range: f64,
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
