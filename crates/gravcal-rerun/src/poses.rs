//! When poses were read: their number, their time, the table they stand in, and where they stand in a recording in motion.

use std::collections::BTreeMap;

use gravcal_robot_model::Session;
use gravcal_robot_model::session::Searched;
use re_sdk::log::TimeColumn;
use re_sdk::{EntityPath, RecordingStream, RecordingStreamError, entity_path};
use re_sdk_types::archetypes::StateChange;

use crate::contents::CalibrationRecording;
use crate::plot::sequence;

/// The timelines of poses.
pub struct PoseTimes {
    /// Since the first pose, s; of none, where any pose lacks it.
    times: Option<Vec<f64>>,
}

impl PoseTimes {
    pub fn of(session: &Session) -> PoseTimes {
        PoseTimes { times: session.poses.iter().map(|pose| pose.conditions.time).collect() }
    }

    /// Columns of some poses.
    pub fn columns(&self, poses: impl IntoIterator<Item = usize> + Clone) -> Vec<TimeColumn> {
        let numbers = sequence("pose", poses.clone());
        let of = |times: &Vec<f64>| {
            TimeColumn::new_duration_secs("time", poses.into_iter().map(|pose| times[pose]).collect::<Vec<_>>())
        };
        let times = self.times.as_ref().map(of);
        [numbers].into_iter().chain(times).collect()
    }
}

/// Logs table and load over poses, and standstills and slow sweeps over time.
pub fn log(stream: &RecordingStream, calibration: &CalibrationRecording<'_>) -> Result<(), RecordingStreamError> {
    let session = calibration.session;
    let table = |pose: usize| file_name(&session.tables[session.poses[pose].table].path);
    states(stream, entity_path!["poses", "file"], session, table)?;
    let load = |pose: usize| session.poses[pose].load.map_or("nothing".into(), |load| session.loads[load].name.clone());
    states(stream, entity_path!["poses", "load"], session, load)?;
    let start = first_time(&session.searched);
    for searched in &session.searched {
        let name = file_name(&searched.path);
        let standstills = searched.standstills.iter().flat_map(|all| &all.found).map(|found| found.interval);
        segments(stream, entity_path!["standstills", name], start, "still", standstills)?;
        let sweeps = searched.sweeps.iter().flat_map(|all| &all.found);
        let sweeps: Vec<(String, [f64; 2])> = sweeps.map(|found| (found.column.clone(), found.interval)).collect();
        for column in sweeps.iter().map(|(column, _)| column).collect::<std::collections::BTreeSet<_>>() {
            let own = sweeps.iter().filter(|(other, _)| other == column).map(|(_, interval)| *interval);
            segments(stream, entity_path!["slow_sweeps", name, column], start, column, own)?;
        }
    }
    Ok(())
}

/// A state of every pose, where it changes.
fn states(
    stream: &RecordingStream,
    path: EntityPath,
    session: &Session,
    state: impl Fn(usize) -> String,
) -> Result<(), RecordingStreamError> {
    let mut poses: Vec<(usize, String)> = (0..session.poses.len()).map(|pose| (pose, state(pose))).collect();
    poses.dedup_by(|(_, later), (_, before)| later == before);
    let times = sequence("pose", poses.iter().map(|(pose, _)| *pose));
    let states = poses.into_iter().map(|(_, state)| state);
    stream.send_columns(path, [times], StateChange::new().with_state(states).columns_of_unit_batches()?)
}

/// Intervals as a state that begins and ends.
fn segments(
    stream: &RecordingStream,
    path: EntityPath,
    start: f64,
    name: &str,
    intervals: impl Iterator<Item = [f64; 2]>,
) -> Result<(), RecordingStreamError> {
    // Where one begins as another ends, the beginning counts.
    let mut changes: BTreeMap<i64, String> = BTreeMap::new();
    for (number, [from, until]) in intervals.enumerate() {
        changes.insert(nanoseconds(from - start), format!("{name} {}", number + 1));
        changes.entry(nanoseconds(until - start)).or_default();
    }
    if changes.is_empty() {
        return Ok(());
    }
    let times = TimeColumn::new_duration_nanos("time", changes.keys().copied());
    let states = StateChange::new().with_state(changes.into_values());
    stream.send_columns(path, [times], states.columns_of_unit_batches()?)
}

fn nanoseconds(seconds: f64) -> i64 {
    (1e9 * seconds).round() as i64
}

/// Time of the first pose on the clock of the recordings: the session counts from it.
fn first_time(searched: &[Searched]) -> f64 {
    let standing = searched.iter().flat_map(|file| &file.standstills).flat_map(|all| &all.found);
    let standing = standing.filter_map(|found| found.pose.conditions.time);
    let sweeping = searched.iter().flat_map(|file| &file.sweeps).flat_map(|all| &all.found);
    let sweeping = sweeping.flat_map(|sweep| &sweep.bins).flat_map(|bin| &bin.sides);
    let sweeping = sweeping.filter_map(|side| side.conditions.time);
    standing.chain(sweeping).reduce(f64::min).unwrap_or(0.0)
}

/// Name of a file without its folder.
fn file_name(path: &std::path::Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
