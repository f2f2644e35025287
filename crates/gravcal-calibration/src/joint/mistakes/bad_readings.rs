//! Single readings that contradict all others: spikes, rows that were read before the arm stood, a pose with another load than its table says.
//!
//! Least squares spread what they are off over all readings. A loss that forgets outliers does not: where it explains most readings as well as their stated
//! noise lets them be explained, and few are far off, these few are bad, and the model is not.

use std::collections::BTreeMap;

use gravcal_estimation::{Loss, LossName};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::variables::State;

/// A residual of so many standard deviations is none of the noise.
const FAR: f64 = 6.0;
/// Where more of a channel's readings are that far off, and more than one, it is not single ones.
const FEW: f64 = 0.1;
/// The others are explained where the rms of their residuals is no larger, in standard deviations.
const EXPLAINED: f64 = 1.5;
/// So many of one channel, at least every second of the first or the last ones, are a drift.
const ONE_AFTER_THE_OTHER: usize = 3;
/// So many rows are named.
const TOLD: usize = 5;

/// Looks for them behind a solution that the readings contradict. Where noise is found from residuals, or a loss forgets outliers already, there is nothing
/// to look for.
pub(in crate::joint) fn bad_readings(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    // Unknowns of single poses would take outliers up.
    let by_pose = solved.built.problem.blocks().iter().any(|block| block.eliminated);
    let hidden = by_pose || solved.readings().order != Order::Together;
    if hidden || solved.built.loss != Loss::None || session.noise_estimated().contains(&true) || environment.stopped() {
        return Ok(None);
    }
    environment.report("looking for single bad readings");
    let readings = MeasurementSet { loss: LossName::Tukey.efficient(), ..solved.readings().clone() };
    let robust = solve_from(session, &readings, solved.state(&State::nominal(session)), environment);
    // What has no answer names nothing.
    let Some(robust) = robust.ok().filter(|robust| robust.estimate.termination.converged()) else { return Ok(None) };
    let residuals = robust.built.problem.residuals(&robust.estimate.values)?;
    let rows: Vec<(ReadingId, f64)> = robust.built.rows.iter().copied().zip(residuals).collect();
    Ok(few_bad(&rows, robust.analysis.rank()).map(|bad| report(session, &bad, rows.len())))
}

/// The readings that are far off, if they are few and the others are explained.
fn few_bad(rows: &[(ReadingId, f64)], rank: usize) -> Option<Vec<(ReadingId, f64)>> {
    let (bad, good): (Vec<_>, Vec<_>) = rows.iter().copied().partition(|(_, residual)| residual.abs() > FAR);
    let freedom = good.len().checked_sub(rank).filter(|freedom| *freedom > 0)?;
    let squares: f64 = good.iter().map(|(_, residual)| residual * residual).sum();
    let explained = squares < EXPLAINED * EXPLAINED * freedom as f64;
    let of = |rows: &[(ReadingId, f64)], channel: usize| rows.iter().filter(|(id, _)| id.channel == channel).count();
    let few = bad.iter().all(|(id, _)| of(&bad, id.channel) as f64 <= (FEW * of(rows, id.channel) as f64).max(1.0));
    (explained && few && !bad.is_empty() && !drifts(rows, &bad)).then_some(bad)
}

/// Whether what is far off is one channel's, in one stretch at the beginning or the end, and to one side: its zero drifts then, and no reading is bad by itself.
fn drifts(rows: &[(ReadingId, f64)], bad: &[(ReadingId, f64)]) -> bool {
    let [(first, side), ..] = bad else { return false };
    let own: Vec<f64> =
        rows.iter().filter(|(id, _)| id.channel == first.channel).map(|(_, residual)| *residual).collect();
    let alike = bad.iter().all(|(id, residual)| id.channel == first.channel && residual * side > 0.0);
    let within = |mut stretch: Vec<f64>| {
        stretch.truncate(2 * bad.len());
        stretch.iter().filter(|residual| residual.abs() > FAR).count() == bad.len()
    };
    bad.len() >= ONE_AFTER_THE_OTHER && alike && (within(own.clone()) || within(own.into_iter().rev().collect()))
}

fn report(session: &Session, bad: &[(ReadingId, f64)], readings: usize) -> Mistake {
    let mut by_pose: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for (ReadingId { pose, channel }, residual) in bad {
        let off = format!("{} by {:.0} standard deviations", session.channel_name(*channel), residual.abs());
        by_pose.entry(*pose).or_default().push(off);
    }
    let named = by_pose.iter().take(TOLD).map(|(pose, off)| {
        let (file, line) = session.row_of(*pose);
        format!("line {line} of {file} ({})", off.join(", "))
    });
    let named: Vec<String> = named.collect();
    let more = by_pose.len().checked_sub(TOLD).filter(|more| *more > 0);
    let more = more.map_or_else(String::new, |more| format!(", and {more} more"));
    let whole_row = by_pose.values().any(|off| off.len() > 1);
    let whole_row = if whole_row {
        " Where several joints of one row are off, its load or its positions may be others."
    } else {
        ""
    };
    Mistake {
        what: format!("{} of {readings} readings contradict all others", bad.len()),
        advice: format!(
            "They are in {}{more}. All other readings agree with the model. Take these rows out, or let [loss] kind = \"tukey\" forget \
             them.{whole_row}",
            named.join("; ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Signals, estimate_jointly};
    use crate::result::{EstimatorResult, Verdict};
    use crate::testing::{sarcos_shoulder, with_environment};

    fn estimate(session: &Session) -> EstimatorResult {
        with_environment(|environment| estimate_jointly(session, Signals::All, None, environment)).unwrap()
    }

    /// The reference protocol with some readings of the second joint off by so many standard deviations: in each pose of this stride.
    fn spoilt(every: usize, times: f64) -> Session {
        let mut session = sarcos_shoulder().session(0);
        for reading in session.poses.iter_mut().step_by(every).filter_map(|pose| pose.torque[1].as_mut()) {
            reading.value += times * reading.std.unwrap();
        }
        session
    }

    #[test]
    fn spikes_are_named_with_their_rows_and_a_loss_is_the_cure() {
        let session = spoilt(40, 200.0);
        let (file, line) = session.row_of(40);
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
        assert!(result.termination.ends_with("readings contradict all others"), "{}", result.termination);
        assert!(result.notes[0].contains(&format!("line {line} of {file} (joint2 by ")), "{:?}", result.notes);
        assert!(!result.notes.concat().contains("What to look at"), "{:?}", result.notes);
        let cured = estimate(&Session { loss: LossName::Tukey.efficient(), ..session });
        assert_eq!(cured.verdict, Verdict::Determined, "{:?}", cured.notes);
    }

    /// What is too small to contradict the model leaves its numbers, and is named all the same.
    #[test]
    fn a_small_spike_is_named_beside_the_numbers() {
        let mut session = sarcos_shoulder().session(0);
        let count = session.poses.len();
        for reading in session.poses.iter_mut().step_by(count / 2).filter_map(|pose| pose.torque[1].as_mut()) {
            reading.value += 25.0 * reading.std.unwrap();
        }
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::PartlyDetermined, "{:?}", result.notes);
        assert!(result.parameters.iter().any(|parameter| parameter.value.is_some()));
        assert!(result.notes[0].contains(" readings contradict all others. They are in line "), "{:?}", result.notes);
    }

    #[test]
    fn a_pose_with_another_load_than_stated_is_named() {
        let mut session = sarcos_shoulder().session(0);
        let pose = session.poses.iter().position(|pose| pose.load.is_some()).unwrap() + 2;
        session.poses[pose].load = None;
        let (file, line) = session.row_of(pose);
        let result = estimate(&session);
        assert!(result.notes[0].contains(&format!("line {line} of {file} (")), "{:?}", result.notes);
    }

    #[test]
    fn a_sensor_that_is_off_in_many_poses_is_no_single_reading() {
        let result = estimate(&spoilt(3, 200.0));
        assert!(!result.termination.contains("contradict all others"), "{}", result.termination);
    }

    #[test]
    fn readings_are_bad_where_the_others_are_explained() {
        let rows = |residuals: &[f64]| -> Vec<(ReadingId, f64)> {
            residuals.iter().enumerate().map(|(pose, residual)| (ReadingId { pose, channel: 0 }, *residual)).collect()
        };
        let mut residuals = [1.0, -1.0].repeat(10);
        assert!(few_bad(&rows(&residuals), 4).is_none());
        residuals[3] = 7.0;
        assert_eq!(few_bad(&rows(&residuals), 4).unwrap().len(), 1);
        residuals[7..9].fill(-7.0);
        assert!(few_bad(&rows(&residuals), 4).is_none(), "more than a tenth");
        let rough: Vec<f64> = residuals.iter().map(|residual| 1.6 * residual.signum()).collect();
        let one_bad = [&rough[1..], &[30.0]].concat();
        assert!(few_bad(&rows(&one_bad), 4).is_none(), "what is not explained accuses nobody");
        let mut drifting = [1.0, -1.0].repeat(20);
        drifting[..3].copy_from_slice(&[12.0, 9.0, 7.0]);
        assert!(few_bad(&rows(&drifting), 4).is_none(), "one after the other");
        drifting[1] = -9.0;
        assert_eq!(few_bad(&rows(&drifting), 4).unwrap().len(), 3, "to both sides");
        drifting[1] = 9.0;
        drifting.swap(2, 9);
        assert_eq!(few_bad(&rows(&drifting), 4).unwrap().len(), 3, "not in one stretch");
        drifting.rotate_left(30);
        assert_eq!(few_bad(&rows(&drifting), 4).unwrap().len(), 3, "in the middle");
        assert!(few_bad(&rows(&[1.0, 9.0]), 1).is_none() && few_bad(&rows(&[9.0]), 1).is_none());
        assert_eq!(few_bad(&rows(&[1.0, 9.0, -1.0, 0.5]), 1).unwrap().len(), 1, "one of few");
    }
}
