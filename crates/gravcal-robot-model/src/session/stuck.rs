//! Readings that are one and the same number in many poses, as those of a sensor that is stuck are.
//!
//! A torque sensor is one where gravity moves it (`doubts/stuck.rs`). A position that stays says nothing by itself: a joint may be held.

use std::collections::BTreeSet;

use gravcal_recording::file_name;

use super::contents::Session;

/// Readings of fewer poses may be equal by chance.
pub(super) const POSES: usize = 8;
/// Readings are the same where they differ by less than this share of them: means of equal samples differ in their last digits.
const SAME: f64 = 1e-9;
/// A joint moves where it goes farther than this share of how far the joint goes that goes farthest.
const MOVES: f64 = 0.1;

/// Poses one after another in which a reading is the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    /// The reading.
    pub at: f64,
    /// How many poses, and the indices of the first and the last.
    pub poses: usize,
    pub first: usize,
    pub last: usize,
}

/// The longest of them, of readings with the indices of their poses.
pub(super) fn longest_run(readings: impl Iterator<Item = (usize, f64)>) -> Option<Run> {
    let (mut longest, mut run): (Option<Run>, Option<Run>) = (None, None);
    for (pose, reading) in readings {
        let next = match run {
            Some(run) if (reading - run.at).abs() <= SAME * run.at.abs() => {
                Run { poses: run.poses + 1, last: pose, ..run }
            }
            _ => Run { at: reading, poses: 1, first: pose, last: pose },
        };
        run = Some(next);
        if longest.is_none_or(|longest| next.poses > longest.poses) {
            longest = run;
        }
    }
    longest.filter(|run| run.poses >= POSES)
}

impl Session {
    /// Joints whose position reading is the same in all poses while others move, in a sentence.
    pub fn unmoved_note(&self) -> Option<String> {
        let unmoved: Vec<String> = (0..self.joints.len()).filter_map(|joint| self.unmoved(joint)).collect();
        (!unmoved.is_empty()).then(|| {
            format!(
                "Position readings that are the same in all {} poses: {}. Where such a joint moved, its sensor is stuck or its column is \
                 another quantity; where it was held, its position gain stays open.",
                self.poses.len(),
                unmoved.join(", ")
            )
        })
    }

    fn unmoved(&self, joint: usize) -> Option<String> {
        let run = longest_run(self.positions(joint, 0..self.poses.len()))?;
        let others_move = (0..self.joints.len()).any(|other| other != joint && self.moves(other, 0..self.poses.len()));
        (run.poses == self.poses.len() && others_move).then(|| {
            let unit = self.joints[joint].position_unit.si();
            format!("{} ({:.6} {unit})", self.robot.chain.joints()[joint].name, run.at)
        })
    }

    /// What looks like a position sensor that got stuck, where something is wrong: readings of a joint that are the same in all poses, or
    /// in many of a table in which it moves elsewhere, while two others move at least.
    pub fn stuck_positions_remark(&self) -> Option<String> {
        let tables: BTreeSet<usize> = self.poses.iter().map(|pose| pose.table).collect();
        let within = tables
            .into_iter()
            .flat_map(|table| (0..self.joints.len()).filter_map(move |joint| self.stuck(joint, table)));
        let reported: Vec<String> =
            (0..self.joints.len()).filter_map(|joint| self.unmoved(joint)).chain(within).collect();
        (!reported.is_empty()).then(|| {
            format!(
                "Look at this first: position readings that do not change while other joints move: {}. Where such a joint moved, its \
                 sensor is stuck: leave these poses out, or mend the column. Where it was held, nothing is wrong with that.",
                reported.join("; ")
            )
        })
    }

    fn stuck(&self, joint: usize, table: usize) -> Option<String> {
        // In a slow sweep all joints rest but one.
        let own = |pose: &usize| self.poses[*pose].table == table && self.poses[*pose].sweep_label.is_none();
        let of_table = || (0..self.poses.len()).filter(own);
        let run = longest_run(self.positions(joint, of_table()))?;
        let inside = || of_table().filter(|pose| (run.first..=run.last).contains(pose));
        let others = (0..self.joints.len()).filter(|other| *other != joint && self.moves(*other, inside())).count();
        (others >= 2 && self.moves(joint, of_table())).then(|| {
            let line = |pose: usize| self.poses[pose].line;
            let file = file_name(&self.tables[table].path);
            let name = &self.robot.chain.joints()[joint].name;
            format!(
                "{name} in {} poses one after another (lines {} to {} of {file})",
                run.poses,
                line(run.first),
                line(run.last)
            )
        })
    }

    fn positions(&self, joint: usize, poses: impl Iterator<Item = usize>) -> impl Iterator<Item = (usize, f64)> {
        poses.filter_map(move |pose| Some((pose, *self.poses[pose].position.get(joint)?)))
    }

    /// Whether a joint moves in these poses as far as joints do in this session.
    fn moves(&self, joint: usize, poses: impl Iterator<Item = usize>) -> bool {
        let ends = |joint: usize, poses: &mut dyn Iterator<Item = usize>| {
            let ends = [f64::INFINITY, f64::NEG_INFINITY];
            let [low, high] =
                self.positions(joint, poses).fold(ends, |[low, high], (_, at)| [at.min(low), at.max(high)]);
            (high - low).max(0.0)
        };
        let unit = |other: usize| self.joints[other].position_unit.si();
        let alike = (0..self.joints.len()).filter(|other| unit(*other) == unit(joint));
        let most = alike.map(|other| ends(other, &mut (0..self.poses.len()))).fold(0.0, f64::max);
        let mut poses = poses;
        let way = ends(joint, &mut poses);
        way > 0.0 && way > MOVES * most
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn runs_of_equal_readings_are_found() {
        let run = |readings: &[f64]| super::longest_run(readings.iter().copied().enumerate());
        assert_eq!(run(&[1.0; 7]), None);
        let third = 1.0 / 3.0;
        let mut readings = vec![0.5; 3];
        readings.extend([third, third * (1.0 + 1e-12)].repeat(5));
        readings.push(2.0);
        let run = run(&readings).unwrap();
        assert_eq!((run.at, run.poses, run.first, run.last), (third, 10, 3, 12));
    }
}
