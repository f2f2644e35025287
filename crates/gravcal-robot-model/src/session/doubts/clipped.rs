//! Sensors of torque, and axes of instruments, whose largest or smallest reading is one number in several poses: they may be at the end of their range.
//!
//! Readings of a sensor that tells many digits hardly ever agree but there. Those of one that reads in steps do anywhere in its range, and often at its
//! ends, as the torque of a turning joint hardly changes where it is largest. Means of many samples never agree, and show nothing.

use crate::session::{Pose, ReadingId, Session};

/// Fewer readings show nothing.
const LEAST: usize = 10;
/// Two equal readings of many digits may be chance, where torques hardly change.
const EQUAL: usize = 3;
/// Hardly any arm keeps a sensor at its end in a larger part of the poses.
const MANY: f64 = 0.2;
/// As many times as often as any reading within: of a cosine in steps the last one is 2.4 times as frequent as the next.
const OFTENER: usize = 4;

/// One sentence for each.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let of_channels = (0..session.channel_count()).flat_map(|channel| of_channel(session, channel));
    of_channels.chain(mostly_left_out(session)).collect()
}

/// Joints of which so large a part is beyond the stated ends of the range that these can hardly be the sensor's.
fn mostly_left_out(session: &Session) -> Option<String> {
    let named: Vec<String> = session
        .saturated
        .iter()
        .zip(session.robot.chain.joints())
        .enumerate()
        .filter_map(|(joint, (saturated, described))| {
            let read = session.poses.iter().filter(|pose| pose.torque.get(joint).is_some_and(Option::is_some)).count();
            let all = read + saturated;
            (*saturated as f64 > MANY * all as f64).then(|| format!("{} of {all} of {}", saturated, described.name))
        })
        .collect();
    (!named.is_empty()).then(|| {
        format!(
            "Many torque readings are beyond the stated ends of the sensors' range, and left out: {}. Are lowest and highest in [readings] torque right, \
             and in the unit of the readings?",
            named.join(", ")
        )
    })
}

fn of_channel(session: &Session, channel: usize) -> Vec<String> {
    let reading = if session.axis(channel).is_none() { "torque reading" } else { "reading" };
    let table = session.readings_table(channel);
    let told = |end: ClippedEnd| {
        let [which, key] = end.words();
        format!(
            "The {which} {reading} of {}, {}, is the same number in {} different poses: the sensor may be at the end of its range there. If so, say \
             where that is ({key} in {table}): readings there are left out then.",
            session.channel_name(channel),
            end.at,
            end.poses
        )
    };
    session.clipped_ends(channel).into_iter().map(told).collect()
}

/// A reading at which a sensor may be at an end of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClippedEnd {
    /// In the unit of the reading.
    pub at: f64,
    /// Whether it is the largest and not the smallest.
    pub is_highest: bool,
    /// How many poses have it.
    pub poses: usize,
}

impl ClippedEnd {
    /// What it is among the readings, and the key by which a session states such an end.
    pub fn words(&self) -> [&'static str; 2] {
        if self.is_highest { ["largest", "highest"] } else { ["smallest", "lowest"] }
    }
}

impl Session {
    /// Readings of a channel, the smallest or the largest, that are one number in so many poses that the sensor may be at an end of its range there.
    pub fn clipped_ends(&self, channel: usize) -> Vec<ClippedEnd> {
        let read = self
            .poses
            .iter()
            .enumerate()
            .filter_map(|(place, pose)| Some((self.reading(ReadingId { pose: place, channel })?.value, pose)));
        let mut read: Vec<(f64, &Pose)> = read.collect();
        read.sort_by(|a, b| a.0.total_cmp(&b.0));
        let runs: Vec<&[(f64, &Pose)]> = read.chunk_by(|a, b| a.0 == b.0).collect();
        let [lowest, within @ .., highest] = &runs[..] else { return Vec::new() };
        if within.is_empty() || read.len() < LEAST {
            return Vec::new();
        }
        let common = within.iter().map(|run| run.len()).fold(0, usize::max);
        let fewest = if common == 1 { EQUAL } else { OFTENER * common + 1 };
        // Of a pose that is read again and again without noise nothing is known.
        let stands = |pose: &Pose| (pose.position.clone(), pose.orientation);
        let apart = |run: &[(f64, &Pose)]| run.iter().any(|(_, pose)| stands(pose) != stands(run[0].1));
        let clipped = |run: &&[(f64, &Pose)]| run.len() >= fewest && apart(run);
        let ends = [(lowest, false), (highest, true)].into_iter().filter(|(run, _)| clipped(run));
        ends.map(|(run, is_highest)| ClippedEnd { at: run[0].0, is_highest, poses: run.len() }).collect()
    }

    /// Where a session states what the sensor of a channel reads.
    pub fn readings_table(&self, channel: usize) -> &'static str {
        if self.axis(channel).is_none() { "[readings] torque" } else { "its readings" }
    }
}
