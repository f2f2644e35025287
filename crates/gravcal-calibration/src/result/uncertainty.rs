//! Where standard deviations come from.

use std::fmt;

use serde::Serialize;

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
