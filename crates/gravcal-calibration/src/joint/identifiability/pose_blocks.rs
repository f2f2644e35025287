//! Which poses may share an error of the model: blocks of neighbouring ones, never of two tables.

use std::ops::Range;

use gravcal_estimation::statistics::{
    MIN_BLOCKS_LEFT_OUT, SampleBlocks, StatisticsError, TooFewBlocks, block_length, neighbour_correlation,
};
use gravcal_robot_model::session::{PoseBlocks, ReadingId, Session};
use gravcal_robot_model::sweeps::{find_sweeps, stand_alike};

use crate::joint::solved::Solved;

/// More blocks tell no more: in long recordings they are as much longer.
const MOST_BLOCKS: usize = 400;

/// Blocks of the poses whose readings enter.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::joint) struct BlocksOfPoses {
    /// By factors, which are the poses in their order.
    pub blocks: SampleBlocks,
    /// Correlation of the residuals of neighbouring poses, where the length was found by it.
    pub correlation: Option<f64>,
    /// Poses that a block should have for that, where there are too few for such blocks.
    pub too_short_for: Option<usize>,
}

impl BlocksOfPoses {
    fn stated(blocks: SampleBlocks) -> Self {
        BlocksOfPoses { blocks, correlation: None, too_short_for: None }
    }
}

impl Solved {
    /// The blocks that a session chooses.
    pub(in crate::joint) fn blocks(
        &self,
        session: &Session,
        choice: PoseBlocks,
    ) -> Result<BlocksOfPoses, StatisticsError> {
        let poses = self.poses(session);
        match choice {
            PoseBlocks::Found => self.found_blocks(session, &poses),
            PoseBlocks::Poses(length) => {
                Ok(BlocksOfPoses::stated(SampleBlocks::within(&tables(session, &poses), length)?))
            }
            _ => Ok(BlocksOfPoses::stated(SampleBlocks::given(&blocks_of(session, &poses, choice))?)),
        }
    }

    /// The poses of the factors.
    pub(in crate::joint) fn poses(&self, session: &Session) -> Vec<usize> {
        (0..session.poses.len()).filter(|pose| !self.readings().used[*pose].is_empty()).collect()
    }

    fn found_blocks(&self, session: &Session, poses: &[usize]) -> Result<BlocksOfPoses, StatisticsError> {
        let correlation = self.neighbours_correlation(session)?;
        let wanted = block_length(correlation, poses.len()).max(poses.len().div_ceil(MOST_BLOCKS));
        let stretches = tables(session, poses);
        let mut length = wanted.min(poses.len() / MIN_BLOCKS_LEFT_OUT).max(1);
        loop {
            match SampleBlocks::within_about(&stretches, length) {
                Err(TooFewBlocks { .. }) if length > 1 => length -= 1,
                blocks => {
                    let too_short_for = (length < wanted).then_some(wanted);
                    return Ok(BlocksOfPoses { blocks: blocks?, correlation: Some(correlation), too_short_for });
                }
            }
        }
    }

    /// Correlation of the errors of neighbouring poses; 0 where there is none but by chance.
    pub(in crate::joint) fn neighbours_correlation(&self, session: &Session) -> Result<f64, StatisticsError> {
        neighbour_correlation(&self.solution(), &self.neighbours(session))
    }

    /// Of each channel, the rows of its readings in the poses of each table.
    fn neighbours(&self, session: &Session) -> Vec<Vec<Vec<usize>>> {
        let mut channels = vec![vec![Vec::new(); session.tables.len()]; session.channel_count()];
        for (row, ReadingId { pose, channel }) in self.built.rows.iter().enumerate() {
            channels[*channel][session.poses[*pose].table].push(row);
        }
        channels.retain(|tables| tables.iter().any(|rows| rows.len() > 1));
        channels
    }
}

/// The blocks that a choice makes of some poses, where it cuts them itself; else their tables.
fn blocks_of(session: &Session, poses: &[usize], choice: PoseBlocks) -> Vec<Range<usize>> {
    match choice {
        PoseBlocks::Found | PoseBlocks::Poses(_) => tables(session, poses),
        PoseBlocks::Seconds(length) => {
            let time = |pose: usize| session.poses[pose].conditions.time.unwrap_or(0.0);
            runs(session, poses, |first, pose| (0.0..length).contains(&(time(pose) - time(first))))
        }
        PoseBlocks::Sweeps => {
            let mut sweep_of = vec![None; session.poses.len()];
            for (index, sweep) in find_sweeps(session).iter().enumerate() {
                sweep.poses.iter().for_each(|pose| sweep_of[*pose] = Some(index));
            }
            runs(session, poses, |first, pose| sweep_of[pose].is_some() && sweep_of[pose] == sweep_of[first])
        }
        PoseBlocks::Pairs => runs(session, poses, |first, pose| stand_alike(session, first, pose)),
    }
}

/// Stretches of poses of one table.
fn tables(session: &Session, poses: &[usize]) -> Vec<Range<usize>> {
    runs(session, poses, |_, _| true)
}

/// Cuts poses into runs of one table, each as long as `continues(first of the run, pose)`.
fn runs(session: &Session, poses: &[usize], continues: impl Fn(usize, usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (place, pose) in poses.iter().enumerate() {
        match runs.last_mut() {
            Some(run)
                if session.poses[poses[run.start]].table == session.poses[*pose].table
                    && continues(poses[run.start], *pose) =>
            {
                run.end = place + 1;
            }
            _ => runs.push(place..place + 1),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::sarcos_shoulder;

    #[test]
    fn blocks_are_of_one_table_and_of_what_belongs_together() {
        let session = sarcos_shoulder().session(0);
        let poses: Vec<usize> = (0..session.poses.len()).collect();
        let tables = blocks_of(&session, &poses, PoseBlocks::Found);
        assert_eq!((tables.len(), tables[1].clone()), (11, 37..74));
        assert_eq!(blocks_of(&session, &poses, PoseBlocks::Sweeps), tables, "each table is a sweep");
        assert_eq!(blocks_of(&session, &poses, PoseBlocks::Pairs).len(), poses.len(), "all stand elsewhere");
        let mut pairs = session.clone();
        for k in (0..pairs.poses.len() - 1).step_by(2) {
            pairs.poses[k + 1].position = pairs.poses[k].position.clone();
        }
        let of_pairs = blocks_of(&pairs, &poses, PoseBlocks::Pairs);
        assert!(
            of_pairs
                .iter()
                .all(|block| block.len() <= 2 && pairs.poses[block.start].table == pairs.poses[block.end - 1].table)
        );
        assert_eq!(of_pairs[0], 0..2);
        let mut timed = session;
        timed.poses.iter_mut().enumerate().for_each(|(k, pose)| pose.conditions.time = Some(0.5 * k as f64));
        let seconds = blocks_of(&timed, &poses, PoseBlocks::Seconds(2.0));
        assert_eq!(seconds[..2], [0..4, 4..8]);
        assert_eq!(seconds[9..11], [36..37, 37..41], "a table ends a block");
    }
}
