//! Rows that repeat another one exactly: they are no new readings.

use gravcal_recording::file_name;

use std::collections::HashSet;

use super::contents::Session;
use super::reading_id::ReadingId;

/// Repeats are left out where they are more than this share of the poses, and more than so many. With a converter's round readings some
/// poses may agree by chance.
const BY_CHANCE: f64 = 0.02;
const FEW: usize = 2;

impl Session {
    /// By pose, whether it repeats an earlier one in every number that was read; all `false` where that may be chance.
    pub fn find_repeated(&self) -> Vec<bool> {
        let mut seen: HashSet<(Option<usize>, Vec<u64>)> = HashSet::new();
        let channels = 0..self.channel_count();
        let of_pose = |index: usize| {
            let pose = &self.poses[index];
            let value = |channel| self.reading(ReadingId { pose: index, channel }).map_or(f64::NAN, |r| r.value);
            let readings = channels.clone().map(value);
            let conditions = &pose.conditions;
            let lists =
                [&conditions.temperature, &conditions.velocity, &conditions.acceleration, &conditions.direction];
            let conditions = conditions.time.iter().chain(lists.into_iter().flatten());
            let numbers = pose
                .position
                .iter()
                .chain(pose.orientation.iter().flatten().flatten())
                .chain(conditions)
                .copied()
                .chain(readings);
            (pose.load, numbers.map(f64::to_bits).collect::<Vec<u64>>())
        };
        let repeated: Vec<bool> = (0..self.poses.len()).map(|pose| !seen.insert(of_pose(pose))).collect();
        let count = repeated.iter().filter(|repeated| **repeated).count();
        let by_chance = count <= FEW || count as f64 <= BY_CHANCE * self.poses.len() as f64;
        if by_chance { vec![false; self.poses.len()] } else { repeated }
    }

    /// The same in words.
    pub fn repeated_note(&self) -> Option<String> {
        let repeated = &self.repeated;
        let count = repeated.iter().filter(|repeated| **repeated).count();
        let pose = &self.poses[repeated.iter().position(|repeated| *repeated)?];
        let file = file_name(&self.tables[pose.table].path);
        Some(format!(
            "{count} of {} rows repeat another one in every number (the first is line {} of {file}), and count once: a copy is \
             no new reading.",
            self.poses.len(),
            pose.line
        ))
    }
}
