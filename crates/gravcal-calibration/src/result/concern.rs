//! What does not fit although there are values.

use serde::Serialize;

/// Something to weigh before values are used.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Concern {
    /// Residuals are so many times as large as the stated noise makes them, and that is no accident.
    Misfit {
        /// Residual over noise.
        times_noise: f64,
    },
    /// Residuals are so many times as large as the stated noise makes them, less than once: it is stated too large, and so are standard
    /// deviations.
    NoiseStatedTooLarge {
        /// Residual over noise.
        times_noise: f64,
    },
    /// Residuals show what the model lacks, of a size that intervals do not hold.
    ResidualShape {
        /// Channel and kind of each test: `joint2 (trend)`.
        tests: Vec<String>,
    },
    /// Joints came to their poses from one side: if they have friction, their torque biases hold it, and no residual shows it.
    OneSidedApproach {
        /// Their names.
        joints: Vec<String>,
    },
    /// A position gain came out so many times its nominal value.
    FarPositionGain {
        /// `joint2.position_gain`.
        parameter: String,
        /// Size of the value over that of the nominal one.
        ratio: f64,
    },
}
