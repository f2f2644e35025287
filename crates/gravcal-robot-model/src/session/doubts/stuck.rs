//! Torque sensors whose reading stays the same where gravity changes: they are stuck, or the column is another quantity.

use gravcal_recording::file_name;

use super::torques::gravity_torques;
use crate::parameter::SensorParameter;
use crate::session::Session;
use crate::session::stuck::{Run, longest_run};

/// Gravity changes a torque where it does so by more than this share of what it does to the joint that it changes most, and by more than so
/// many steps of the sensor: readings in coarse steps may be equal.
const CHANGES: f64 = 0.1;
const STEPS: f64 = 10.0;
/// The same share of a reading that is one number in all poses: no sensor is without noise.
const CHANGES_OF_ALL: f64 = 1e-3;

/// One sentence for each.
pub(super) fn doubts(session: &Session) -> Vec<String> {
    let runs: Vec<(usize, Run)> =
        (0..session.joints.len()).filter_map(|joint| Some((joint, longest_run(readings(session, joint))?))).collect();
    if runs.is_empty() {
        return Vec::new();
    }
    let torques = gravity_torques(session, 0..session.poses.len(), session.gravity.assumed());
    let most = torques.iter().map(|of_joint| half_range(of_joint)).fold(0.0, f64::max);
    runs.into_iter().filter_map(|(joint, run)| doubt(session, joint, &run, (&torques[joint], most))).collect()
}

fn doubt(session: &Session, joint: usize, run: &Run, (torques, most): (&[f64], f64)) -> Option<String> {
    let gain = session.joints[joint].of(SensorParameter::TorqueGain).nominal;
    let within: Vec<f64> = readings(session, joint)
        .map(|(pose, _)| pose)
        .filter(|pose| (run.first..=run.last).contains(pose))
        .map(|pose| torques[pose])
        .collect();
    let changes = half_range(&within);
    let of_all = readings(session, joint).count();
    let (share, step) = match run.poses == of_all {
        false => (CHANGES, step(session, joint)),
        true => (CHANGES_OF_ALL, step_of_others(session, joint)),
    };
    if changes <= share * most || (gain * changes).abs() <= STEPS * step {
        return None;
    }
    let name = &session.robot.chain.joints()[joint].name;
    let (first, last) = (&session.poses[run.first], &session.poses[run.last]);
    let file = |table: usize| file_name(&session.tables[table].path);
    let place = match run.poses {
        poses if poses == of_all => format!("all {poses} poses"),
        poses => {
            let (begin, end) = (file(first.table), file(last.table));
            format!("{poses} poses one after another (line {} of {begin} to line {} of {end})", first.line, last.line)
        }
    };
    Some(format!(
        "Torque readings of {name} are the same number ({}) in {place}, where gravity should change them by ±{:.1} {}: the sensor is \
         stuck, at an end of its range (lowest, highest in readings.torque), or its column is another quantity. Name another column, leave \
         these poses out, or, where a joint has no sensor, say \"\" for its column.",
        run.at,
        (gain * changes).abs(),
        session.channel_unit(joint)
    ))
}

/// Torque readings of a joint, with the indices of their poses.
fn readings(session: &Session, joint: usize) -> impl Iterator<Item = (usize, f64)> {
    let poses = session.poses.iter().enumerate();
    poses.filter_map(move |(index, pose)| Some((index, pose.torque.get(joint)?.as_ref()?.value)))
}

/// The smallest difference of two readings, which is the step of a converter where there is one; 0 where all are equal.
fn step(session: &Session, joint: usize) -> f64 {
    let mut numbers: Vec<f64> = readings(session, joint).map(|(_, reading)| reading).collect();
    numbers.sort_by(f64::total_cmp);
    let steps = numbers.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    steps.reduce(f64::min).unwrap_or(0.0)
}

/// The largest step of other joints that read in the same unit, and the same number more than once: one that always reads the same does not show its own.
fn step_of_others(session: &Session, joint: usize) -> f64 {
    let unit = &session.joints[joint].torque_unit;
    let others =
        (0..session.joints.len()).filter(|other| *other != joint && session.joints[*other].torque_unit == *unit);
    let in_steps = |other: &usize| {
        let mut numbers: Vec<f64> = readings(session, *other).map(|(_, reading)| reading).collect();
        numbers.sort_by(f64::total_cmp);
        numbers.windows(2).any(|pair| pair[0] == pair[1])
    };
    others.filter(in_steps).map(|other| step(session, other)).fold(0.0, f64::max)
}

fn half_range(numbers: &[f64]) -> f64 {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = numbers.iter().fold(ends, |[low, high], number| [number.min(low), number.max(high)]);
    (0.5 * (high - low)).max(0.0)
}
