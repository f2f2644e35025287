//! What readings still settle after stops, where all standstills of a recording together show it and none shows it alone
//! ([`gravcal_recording::Settling`]).
//!
//! It is in the means of all of them with one sign, or with that of the last motion, and passes for a bias or for friction. So every number may be
//! off by what such errors of the readings make of it.

use gravcal_estimation::statistics::StatisticsError;
use gravcal_recording::{RemainingSettling, Settling};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::{Pose, Session};

use crate::joint::solved::Solved;

/// What settling does to the numbers.
#[derive(Clone, Debug, Default)]
pub(in crate::joint) struct LeftToSettle {
    /// By how much each column of the problem that is judged is off, one entry a cause.
    pub moved: Vec<Vec<f64>>,
    /// What is told of it: whether its end is seen, so that intervals that allow for it hold, and words.
    pub told: Option<(bool, String)>,
}

/// One cause: a channel of a recording.
struct Cause {
    channel: usize,
    left: RemainingSettling,
    errors: Vec<f64>,
}

impl Solved {
    /// What is left of settling, and what it does.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(in crate::joint) fn left_to_settle(&self, session: &Session) -> Result<LeftToSettle, StatisticsError> {
        let causes = self.causes(session);
        let errors: Vec<Vec<f64>> = causes.iter().map(|cause| cause.errors.clone()).collect();
        let shifted = self.shifted_by(session, &errors)?;
        let telling = causes.iter().zip(&shifted).filter(|(_, shifted)| shifted.matters);
        let telling: Vec<&Cause> = telling.map(|(cause, _)| cause).collect();
        let ends = telling.iter().all(|cause| cause.left.ends);
        let told = (!telling.is_empty()).then(|| (ends, in_words(session, &telling)));
        Ok(LeftToSettle { moved: shifted.into_iter().map(|shifted| shifted.moved).collect(), told })
    }

    fn causes(&self, session: &Session) -> Vec<Cause> {
        let mut causes = Vec::new();
        for searched in session.fitted_recordings() {
            let Some(found) = &searched.standstills else { continue };
            let stood =
                |pose: &Pose| pose.table == searched.table && pose.sweep_label.is_none() && pose.course.is_none();
            let of_joints = found.torque_settling.iter().enumerate();
            let axes = found.instrument_settling.iter().enumerate();
            let of_axes = axes.map(|(axis, own)| (session.joints.len() + axis, own));
            for (channel, Settling { common, by_direction }) in of_joints.chain(of_axes) {
                let side = |pose: &Pose| pose.conditions.direction.get(channel).copied().unwrap_or(0.0);
                for (left, goes_with_side) in [(common, false), (by_direction, true)] {
                    let Some(left) = *left else { continue };
                    let errors = self.errors_of(session, |id| {
                        let pose = &session.poses[id.pose];
                        let sign = if goes_with_side { side(pose) } else { 1.0 };
                        if id.channel == channel && stood(pose) { left.size * sign } else { 0.0 }
                    });
                    causes.extend(errors.map(|errors| Cause { channel, left, errors }));
                }
            }
        }
        causes
    }
}

fn in_words(session: &Session, causes: &[&Cause]) -> String {
    let largest = |channel: usize| {
        let own = causes.iter().filter(|cause| cause.channel == channel).map(|cause| cause.left.size.abs());
        own.fold(0.0, f64::max)
    };
    let mut channels: Vec<usize> = causes.iter().map(|cause| cause.channel).collect();
    channels.sort_unstable();
    channels.dedup();
    let listed: Vec<String> = channels
        .into_iter()
        .map(|channel| {
            format!(
                "{} ({} {})",
                session.channel_name(channel),
                significant(largest(channel), 2),
                session.channel_unit(channel)
            )
        })
        .collect();
    let end = match causes.iter().all(|cause| cause.left.ends) {
        true => "Intervals allow for it.",
        false => {
            "The arm does not stand long enough to see how it ends: what is left may be larger, and intervals, which allow for so much, need \
             not hold."
        }
    };
    format!(
        "Readings still settle while the arm is taken to stand, which all standstills together show and none shows alone: in the means is left, of {}. It \
         passes for a bias, or for friction. {end} Let the arm stand longer after each motion.",
        listed.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::LossName;
    use gravcal_recording::Standstills;
    use gravcal_robot_model::parameter::SensorParameter;
    use gravcal_robot_model::session::Searched;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// Readings of a joint that are all off by so much have their bias off by that, and nothing else, with and without a loss.
    #[test]
    fn what_is_left_in_all_readings_of_a_joint_is_in_its_bias() {
        for loss in [None, Some(LossName::Huber)] {
            let mut session = sarcos_shoulder().session(0);
            session.poses.iter_mut().for_each(|pose| pose.sweep_label = None);
            session.loss = loss.map_or(session.loss, LossName::efficient);
            let left = RemainingSettling { size: 2.0, ends: true };
            let second = Settling { common: Some(left), by_direction: None };
            let found = Standstills {
                torque_settling: vec![Settling::default(), second, Settling::default()],
                ..Standstills::default()
            };
            // All of one file, each a part of it: what is left is in each of them once.
            session.tables.iter_mut().for_each(|table| table.path = "recording.csv".into());
            let searched = |table| Searched { table, standstills: Some(found.clone()), ..Searched::default() };
            session.searched = (0..session.tables.len()).map(searched).collect();
            let readings = select(&session, Signals::All);
            let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
            let LeftToSettle { moved, told } = solved.left_to_settle(&session).unwrap();
            let sum = |column: usize| moved.iter().map(|own| own[column]).sum::<f64>();
            for (joint, off) in [(0, 0.0), (1, 2.0), (2, 0.0)] {
                let bias = solved.built.variables.sensors[joint][SensorParameter::TorqueBias as usize];
                let columns = solved.judged_problem().columns_of(bias);
                columns
                    .for_each(|column| assert!((sum(column) - off).abs() < 1e-6, "{loss:?} {joint}: {}", sum(column)));
            }
            assert!(told.is_some_and(|(ends, words)| ends && words.contains("of joint2 (2")), "{loss:?}");
        }
    }
}
