//! `[uncertainty]`: where the joint estimator's standard deviations come from.

use gravcal_estimation::statistics::SampleBlocks;
use gravcal_robot_model::session::{Pose, PoseBlocks, Session, UncertaintyChoice};
use gravcal_robot_model::sweeps::{find_sweeps, stand_alike};
use serde::Deserialize;

use super::context::Context;
use crate::document::{Document, Field, FileError};

/// Replicates of a bootstrap where nothing is said, and the fewest whose outermost fortieths mean anything.
const REPLICATES: usize = 500;
const FEWEST_REPLICATES: usize = 100;
/// Seed of a bootstrap where nothing is said.
const SEED: u64 = 1;

/// `[uncertainty]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct UncertaintyTable {
    /// See [Where standard deviations come from](../explanation/uncertainty.md).
    ///
    /// Default: `"noise"`; in motion `"jackknife"` with blocks of 1.5 s.
    /// Example: `kind = "jackknife"`
    kind: Option<Kind>,
    /// Neighbouring poses that may share an error. Not with `"noise"`.
    ///
    /// Unit: poses.
    /// Default: found by `"jackknife"`; the others require it.
    /// Example: `block_poses = 10`
    block_poses: Option<usize>,
    /// With `"jackknife"`: the same in time. Needs `readings.time`.
    ///
    /// Default: found.
    /// Example: `block_s = 1.5`
    block_s: Option<f64>,
    /// With `"jackknife"`: blocks are sweeps, or pairs of the same pose from two sides.
    ///
    /// Default: neighbouring poses.
    /// Example: `blocks = "sweeps"`
    blocks: Option<Blocks>,
    /// With `"bootstrap"`: how often it solves again.
    ///
    /// Unit: none.
    /// Default: 500.
    /// Example: `replicates = 500`
    replicates: Option<usize>,
    /// With `"bootstrap"`: seed of the draws.
    ///
    /// Unit: none.
    /// Default: 1.
    /// Example: `seed = 2`
    seed: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Noise,
    Jackknife,
    Sandwich,
    Bootstrap,
}

/// Blocks that poses make by themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Blocks {
    Sweeps,
    Pairs,
}

/// What `[uncertainty]` comes to for these poses.
pub(super) fn resolve(
    context: &Context<'_>,
    table: &UncertaintyTable,
    poses: &[Pose],
) -> Result<UncertaintyChoice, FileError> {
    let section = Section { context, table };
    let moves = poses.iter().any(|pose| pose.course.is_some());
    let kind = table.kind.unwrap_or(if moves { Kind::Jackknife } else { Kind::Noise });
    if kind != Kind::Bootstrap {
        let message = "only a bootstrap draws anything: write kind = \"bootstrap\", or leave it out";
        section.refuse("replicates", table.replicates.is_some(), message)?;
        section.refuse("seed", table.seed.is_some(), message)?;
    }
    if kind == Kind::Noise {
        let message =
            "the noise knows no blocks: write kind = \"jackknife\", \"sandwich\" or \"bootstrap\", or leave it out";
        section.refuse("block_poses", table.block_poses.is_some(), message)?;
    }
    if kind != Kind::Jackknife {
        let message = "only a jackknife has such blocks: write kind = \"jackknife\", or leave it out";
        section.refuse("block_s", table.block_s.is_some(), message)?;
        section.refuse("blocks", table.blocks.is_some(), message)?;
    }
    if kind == Kind::Noise {
        return Ok(UncertaintyChoice::Noise);
    }
    if kind == Kind::Jackknife {
        return Ok(UncertaintyChoice::Jackknife { blocks: section.pose_blocks(poses)? });
    }
    let block_poses = section.block_poses(poses)?;
    if kind == Kind::Sandwich {
        return Ok(UncertaintyChoice::Sandwich { block_poses });
    }
    let replicates = table.replicates.unwrap_or(REPLICATES);
    let message = format!("an interval of 95 % needs {FEWEST_REPLICATES} replicates at least, better some hundreds");
    section.refuse("replicates", replicates < FEWEST_REPLICATES, &message)?;
    Ok(UncertaintyChoice::Bootstrap { block_poses, replicates, seed: table.seed.unwrap_or(SEED) })
}

/// Whether there are blocks of the kind that the jackknife is to leave out.
pub(super) fn check_blocks(document: &Document, session: &Session) -> Result<(), FileError> {
    let UncertaintyChoice::Jackknife { blocks } = session.uncertainty else { return Ok(()) };
    let pair = |pose: usize| {
        session.poses[pose].table == session.poses[pose + 1].table && stand_alike(session, pose, pose + 1)
    };
    let pairs = || (0..session.poses.len().saturating_sub(1)).any(pair);
    let message = match blocks {
        PoseBlocks::Pairs if !pairs() => {
            "no two rows that follow each other are of the same pose: leave blocks out, and their length is found"
        }
        PoseBlocks::Sweeps if find_sweeps(session).is_empty() => {
            "no table has a sweep, in which one joint moves and the others stand: leave blocks out, and their length is found"
        }
        _ => return Ok(()),
    };
    Err(document.error(&Field::new("uncertainty").key("blocks"), message))
}

struct Section<'a> {
    context: &'a Context<'a>,
    table: &'a UncertaintyTable,
}

impl Section<'_> {
    fn error(&self, key: &str, message: impl std::fmt::Display) -> FileError {
        self.context.document.error(&Field::new("uncertainty").key(key), message)
    }

    fn refuse(&self, key: &str, wrong: bool, message: &str) -> Result<(), FileError> {
        if wrong { Err(self.error(key, message)) } else { Ok(()) }
    }

    /// Which poses a jackknife leaves out together. That there are enough blocks is seen once it is known which poses enter.
    fn pose_blocks(&self, poses: &[Pose]) -> Result<PoseBlocks, FileError> {
        let UncertaintyTable { block_poses, block_s, blocks, .. } = *self.table;
        let only_one = "blocks are of poses (block_poses), of seconds (block_s), or those of blocks = \"sweeps\" or \"pairs\": keep one";
        self.refuse("block_s", block_s.is_some() && block_poses.is_some(), only_one)?;
        self.refuse("blocks", blocks.is_some() && (block_poses.is_some() || block_s.is_some()), only_one)?;
        if let Some(length) = block_s {
            let what = "the length of a block";
            self.context.document.positive(&Field::new("uncertainty").key("block_s"), length, what, "seconds")?;
            let without = poses.iter().any(|pose| pose.conditions.time.is_none());
            self.refuse(
                "block_s",
                without,
                "some poses have no time: name their column ([readings] time), or state block_poses",
            )?;
        }
        if let Some(length) = block_poses {
            let read = count_read(poses);
            SampleBlocks::within(std::slice::from_ref(&(0..read)), length)
                .map_err(|error| self.error("block_poses", error))?;
        }
        Ok(match (block_poses, block_s, blocks) {
            (Some(length), ..) => PoseBlocks::Poses(length),
            (_, Some(length), _) => PoseBlocks::Seconds(length),
            (.., Some(Blocks::Sweeps)) => PoseBlocks::Sweeps,
            (.., Some(Blocks::Pairs)) => PoseBlocks::Pairs,
            (None, None, None) if poses.iter().any(|pose| pose.course.is_some()) => {
                PoseBlocks::Seconds(block_of(poses))
            }
            (None, None, None) => PoseBlocks::Found,
        })
    }

    /// The length of a block, if the poses make enough of them.
    fn block_poses(&self, poses: &[Pose]) -> Result<usize, FileError> {
        let key = "block_poses";
        let length = self.table.block_poses.ok_or_else(|| {
            self.error(key, "how many neighbouring poses may share an error? add block_poses, 10 for ten of them")
        })?;
        SampleBlocks::new(0..count_read(poses), length).map_err(|error| self.error(key, error))?;
        Ok(length)
    }
}

/// Blocks of an arm in motion: neighbouring windows overlap, and errors of the model last.
const BLOCK: f64 = 1.5;
/// At least so many.
const BLOCKS: f64 = 12.0;

/// Their length, s.
fn block_of(poses: &[Pose]) -> f64 {
    let mut covered = 0.0;
    for pair in poses.windows(2).filter(|pair| pair[0].table == pair[1].table) {
        let [before, after] = [0, 1].map(|of| pair[of].conditions.time.unwrap_or(0.0));
        covered += (after - before).clamp(0.0, BLOCK);
    }
    f64::min(BLOCK, covered / (BLOCKS + 1.0)).max(f64::MIN_POSITIVE)
}

/// How many poses have any reading.
fn count_read(poses: &[Pose]) -> usize {
    poses.iter().filter(|pose| pose.torque.iter().chain(&pose.instruments).any(Option::is_some)).count()
}
