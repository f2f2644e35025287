//! What a check tells.

use serde::Serialize;

use crate::result::Undetermined;

/// What a session can determine.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// What the session says that can hardly be so, to be looked at before all else.
    pub doubts: Vec<String>,
    /// Where it was judged, in words.
    pub judged_at: String,
    /// Whether gravity was taken to be that of an upright base, as nothing says where it points.
    pub assumes_upright: bool,
    /// Poses by load (`none` first), as `(load, poses)`.
    pub poses: Vec<(String, usize)>,
    /// By joint: name and usable torque readings.
    pub torque_readings: Vec<(String, usize)>,
    /// What was found in recordings in motion, in words.
    pub standstills: Vec<String>,
    /// How many torque readings of each joint the limits of motion leave, in words; absent where they leave all.
    pub selection: Option<String>,
    /// Joints whose position reading never changes while others move, in words; absent where there are none.
    pub unmoved: Option<String>,
    /// Rule by which sweeps are detected, in words.
    pub sweep_rule: String,
    /// Sweeps found.
    pub sweeps: Vec<SweepReport>,
    /// What each step of the sequential procedure will read, or why it cannot work; empty of a robot that is no serial
    /// chain, along which the steps go.
    pub steps: Vec<StepReport>,
    /// Errors that the noise does not explain, as the predicted standard deviations allow for them: a share of the largest torque that each joint carries. Absent
    /// where there are none, or the session states them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supposed_errors: Option<f64>,
    /// Every sensor parameter and gravity, as the joint estimator can know them.
    pub parameters: Vec<CheckedParameter>,
    /// Loads of unknown mass, as the joint estimator can know them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub payloads: Vec<CheckedPayload>,
    /// What the joint estimator cannot determine, and what would cure it.
    pub undetermined: Vec<Curable>,
    /// What tilting the base would bring to the first joint; empty unless gravity is nearly parallel to its axis.
    pub tilts: Vec<TiltReport>,
    /// Whether everything asked for can be determined.
    pub complete: bool,
}

/// One sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweepReport {
    /// File name of its table.
    pub table: String,
    /// Lines of its first and last pose.
    pub lines: [u64; 2],
    /// The joint that moves.
    pub joint: String,
    /// Number of poses.
    pub poses: usize,
    /// From where to where, degrees (nominal position gain, no offset).
    pub range_deg: [f64; 2],
    /// Load attached, if any.
    pub load: Option<String>,
    /// Steps of the sequential procedure that read it.
    pub steps: Vec<u8>,
}

/// One step of the sequential procedure for one joint.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// 1, 2 or 3.
    pub step: u8,
    /// What it finds: `joint1.torque_bias, joint1.position_gain`.
    pub finds: String,
    /// Number of sweeps it reads.
    pub sweeps: usize,
    /// Why it cannot work, if it cannot.
    pub problem: Option<String>,
}

/// What can be known of one parameter.
#[derive(Clone, Debug, Serialize)]
pub struct CheckedParameter {
    /// `joint1.torque_gain`, `gravity`.
    pub name: String,
    /// Unit of the standard deviation; degrees for gravity's direction.
    pub unit: String,
    /// Whether it is asked for.
    pub asked: bool,
    /// Whether it can be determined.
    pub determined: bool,
    /// Why it is fixed, if it is.
    pub held: Option<String>,
    /// Predicted standard deviation, where it can be determined and is not held; absent too where the noise of a
    /// torque reading is not stated.
    pub predicted_std: Option<f64>,
}

/// What can be known of a load of unknown mass.
#[derive(Clone, Debug, Serialize)]
pub struct CheckedPayload {
    /// Name of the load.
    pub load: String,
    /// Predicted standard deviation of its mass, kg, where that can be determined; absent too where the noise of a reading is not stated.
    pub predicted_mass_std_kg: Option<f64>,
    /// What of it cannot be determined, why, and what to do.
    pub undetermined: Option<String>,
}

/// Something undetermined, with the smallest additions to the session that were found to determine it.
#[derive(Clone, Debug, Serialize)]
pub struct Curable {
    /// What and why; its `cure` is the first of `cures`, or a rule of thumb where there is none.
    #[serde(flatten)]
    pub undetermined: Undetermined,
    /// In the order of effort, smallest first; at most three. Empty where neither one of the additions that are tried nor two
    /// of them together determine it.
    pub cures: Vec<Cure>,
}

/// An addition to the session that would determine something, as judged with hypothetical poses at nominal values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cure {
    /// What to do, in words.
    pub addition: String,
    /// What would then be known of each parameter: standard deviation.
    pub predicted: Vec<PredictedStd>,
}

/// How well a parameter would be known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PredictedStd {
    /// `joint1.torque_gain`, `gravity`.
    pub name: String,
    /// Unit of the standard deviation; degrees for gravity's direction.
    pub unit: String,
    /// Standard deviation; absent where the noise of a reading is not stated.
    pub std: Option<f64>,
}

/// What a tilt of the base brings.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TiltReport {
    /// Angle between gravity and the first axis, degrees.
    pub tilt_deg: f64,
    /// Of the first joint's torque gain.
    pub torque_gain: TiltedGain,
    /// Of its position gain.
    pub position_gain: TiltedGain,
}

/// What a tilt of the base brings to a gain of the first joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TiltedGain {
    /// Whether it can be determined.
    pub determined: bool,
    /// Predicted standard deviation relative to its value, where it can be determined; absent too where the noise of a torque
    /// reading is not stated.
    pub relative_std: Option<f64>,
}
