//! Errors that are large beside what gravity makes a sensor read, in words: a wrong model makes such errors.

use std::collections::BTreeMap;

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::mistakes::hypothesis::Mistake;
use crate::joint::model_error::unexplained_size::{BesideGravity, LARGE, WARNING, err_as_neighbours};
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::instruments::of_instruments;
use crate::joint::reporting::findings::verdict::Findings;
use crate::result::UnexplainedResult;

/// So large a share of all squared residuals, in so small a share of the poses, is of few poses; so many are named.
const MOST: f64 = 0.8;
const FEW: f64 = 0.15;
const NAMED: usize = 5;
/// The errors of one channel.
struct Errors {
    /// Of what gravity makes the channel read.
    share: f64,
    /// The channel and their size.
    text: String,
}

impl Errors {
    fn of(session: &Session, channel: usize, std: f64, share: f64) -> Errors {
        let (name, unit) = (session.channel_name(channel), session.channel_unit(channel));
        Errors { share, text: format!("{name} ({} {unit}, {:.0} %)", significant(std, 2), 100.0 * share) }
    }
}

impl Answer {
    /// Says where unexplained errors are large beside what gravity makes a sensor read. A stated size is judged as the noise is.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint::reporting) fn remark_on_unexplained(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<(), EvaluateError> {
        let beside = |size: &Option<UnexplainedResult>| BesideGravity::of(size.filter(|size| size.estimated)?);
        let errors: Vec<Option<BesideGravity>> = self.unexplained.iter().map(beside).collect();
        let excused = err_as_neighbours(session, &errors);
        let (mut failing, mut warned) = (Vec::new(), Vec::new());
        for (channel, own) in errors.iter().enumerate() {
            let Some(BesideGravity { std, share, .. }) = own.filter(|own| own.share > WARNING) else { continue };
            let group = if share > LARGE && !excused[channel] { &mut failing } else { &mut warned };
            group.push(Errors::of(session, channel, std, share));
        }
        if !warned.is_empty() {
            findings.remark(format!(
                "Errors that the noise does not explain, beside what gravity makes the sensor read: {}. Intervals allow for them \
                 as far as they differ from pose to pose; what is the same in many poses (friction from one side, a drift, a \
                 wrong length or load mass) shifts values beyond their intervals.",
                listed(warned)
            ));
        }
        if !failing.is_empty() {
            findings.fail(Mistake {
                what: format!("the model contradicts the readings of {}", listed(failing)),
                advice: format!(
                    "So large a share of what gravity makes these sensors read is explained neither by gravity nor by noise. \
                         What to look at: the sign of a torque sensor (torque_sign = \"reversed\"), units, swapped columns, the \
                         hemisphere of gravity, the loads' masses, distances and poses, values given as fixed, what touches the arm or \
                         pulls at it, single bad rows.{}{}",
                    self.few_poses(session)?.unwrap_or_default(),
                    of_instruments(session)
                ),
            });
        }
        Ok(())
    }

    /// Names the poses in which the errors are, where these are few.
    fn few_poses(&self, session: &Session) -> Result<Option<String>, EvaluateError> {
        let solved = &self.solved;
        let mut of_pose: BTreeMap<usize, f64> = BTreeMap::new();
        for (id, row) in solved.built.rows.iter().zip(solved.row_residuals()?) {
            *of_pose.entry(id.pose).or_default() += row.whitened * row.whitened;
        }
        let all: f64 = of_pose.values().sum();
        let poses = of_pose.len();
        let mut worst: Vec<(usize, f64)> = of_pose.into_iter().collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1));
        let held = worst.iter().scan(0.0, |held, (_, own)| Some(std::mem::replace(held, *held + own)));
        let few = held.take_while(|before| *before < MOST * all).count();
        if few == 0 || few as f64 > FEW * poses as f64 || session.loss != Loss::None {
            return Ok(None);
        }
        let row = |pose: usize| {
            let (file, line) = session.row_of(pose);
            format!("{file}:{line}")
        };
        let named: Vec<String> = worst.iter().take(few.min(NAMED)).map(|(pose, _)| row(*pose)).collect();
        let more = if few > NAMED { format!(" and {} more", few - NAMED) } else { String::new() };
        Ok(Some(format!(
            " Most of it is in few poses ({}{more}): leave them out, or count what is far off less, [loss] kind = \"huber\".",
            named.join(", ")
        )))
    }

    /// Says where noise that nobody stated is so large beside what gravity makes a sensor read that something else is wrong, and whether
    /// it is.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint::reporting) fn remark_on_noise_found(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<bool, EvaluateError> {
        if !self.solved.estimate.termination.converged() {
            return Ok(false);
        }
        let sizes = self.solved.noise_beside_gravity(session)?;
        let excused = err_as_neighbours(session, &sizes);
        let large = sizes.iter().enumerate().filter_map(|(channel, size)| {
            let BesideGravity { std, share, .. } = size.filter(|size| size.share > LARGE && !excused[channel])?;
            Some(Errors::of(session, channel, std, share))
        });
        let large: Vec<Errors> = large.collect();
        if large.is_empty() {
            return Ok(false);
        }
        let large = listed(large);
        if self.solved.leaves_all_unexplained(session, &self.judgement)? {
            findings.fail(Mistake {
                what: format!("the torques of gravity are smaller than what they leave unexplained: {large}"),
                advice: "Residuals so large are no noise. What to look at: whether the arm stood in each pose (rows of an arm in motion are no static \
                         poses: see readings.still and readings.motion), the order of columns, units, the robot's file, its base and its tip."
                    .into(),
            });
            return Ok(true);
        }
        findings.doubt_for(match session.has_windows() {
            true => format!(
                "Residuals are large beside the torque of gravity and inertia: {large}. They are taken \
                 for noise. Noise of windows is seldom so large: look at friction that is more than a Coulomb and a viscous term, at the \
                 clock, at what the recorder did to torques (torque_lag_s, recorded_filter_hz), at units, signs and swapped columns."
            ),
            false => format!(
                "Residuals are large beside the torque of gravity: {large}. They are taken for \
                 noise, as no std is stated. Noise so large is rare: look at units, signs, swapped columns, a rotation or an order of \
                 quaternions that is another, load masses, poses that are not static, single bad rows ([loss] finds these). State \
                 the std that the sensors have: what it does not explain is then told."
            ),
        });
        Ok(true)
    }
}

/// The channels, that of the largest share first.
fn listed(mut errors: Vec<Errors>) -> String {
    errors.sort_by(|a, b| b.share.total_cmp(&a.share));
    errors.into_iter().map(|errors| errors.text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use gravcal_estimation::Termination;
    use gravcal_robot_model::parameter::{ParameterId, SensorParameter};

    use super::*;
    use crate::joint::reporting::findings::testing::{answer, found};
    use crate::joint::{Solved, State, build_problem};
    use crate::judgement::Asked;
    use crate::testing::sarcos_shoulder;

    fn errors(estimated: bool, share: f64) -> Option<UnexplainedResult> {
        let (std, gravity_std) = (share * 100.0, 100.0);
        Some(UnexplainedResult { std, estimated, times_noise: 1.0, gravity_std, share_of_gravity: Some(share) })
    }

    #[test]
    fn unexplained_errors_are_told_from_three_percent_of_gravity_and_contradict_from_ten() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let mut told = |unexplained: [Option<UnexplainedResult>; 3]| {
            answer.unexplained = unexplained.to_vec();
            found(|findings| answer.remark_on_unexplained(&session, findings).unwrap())
        };
        assert_eq!(told([errors(true, 0.029), None, errors(false, 0.5)]), (None, [vec![], vec![]]));
        let (failure, [reasons, remarks]) = told([errors(true, 0.031), None, errors(true, 0.099)]);
        assert!(failure.is_none() && reasons.is_empty() && remarks.len() == 1, "{failure:?} {reasons:?}");
        // The largest share first.
        assert!(remarks[0].contains("joint3 (9.9 count, 10 %), joint1 (3.1 count, 3 %)"), "{remarks:?}");
        let (failure, [reasons, remarks]) = told([errors(true, 0.101), errors(true, 0.05), None]);
        let failure = failure.unwrap();
        assert!(failure.contains("joint1") && !failure.contains("joint2"), "{failure}");
        assert!(reasons.len() == 1 && remarks.len() == 1 && remarks[0].contains("joint2"), "{reasons:?} {remarks:?}");
    }

    /// A touched arm, or a bad row, and not the model: what to leave out is said.
    #[test]
    fn where_few_poses_hold_the_errors_these_are_named() {
        let advice = |touched: usize| {
            let mut session = sarcos_shoulder().session(0);
            for pose in session.poses.iter_mut().take(touched) {
                pose.torque.iter_mut().flatten().for_each(|reading| reading.value += 200.0);
            }
            let mut answer = answer(&session);
            answer.unexplained = vec![errors(true, 0.5), None, None];
            let (_, [reasons, _]) = found(|findings| answer.remark_on_unexplained(&session, findings).unwrap());
            (session.poses[0].line, reasons.concat())
        };
        let (line, few) = advice(3);
        assert!(few.contains("Most of it is in few poses (") && few.contains(&format!(":{line}")), "{few}");
        assert!(few.contains("[loss] kind = \"huber\""), "{few}");
        for poses in [0, 200] {
            let (_, many) = advice(poses);
            assert!(!many.contains("few poses"), "{many}");
        }
    }

    #[test]
    fn a_gain_that_is_open_counts_as_the_nominal_one() {
        let session = sarcos_shoulder().session(0);
        let mut answer = answer(&session);
        let id = ParameterId::Sensor(1, SensorParameter::TorqueGain);
        let nominal = session.prior(id).nominal;
        assert!(answer.solved.gain_or_nominal(&session, &answer.judgement, 1) != nominal);
        answer.judgement.leave_unsaid([Asked::from(id)]);
        assert_eq!(answer.solved.gain_or_nominal(&session, &answer.judgement, 1), nominal);
    }

    #[test]
    fn noise_that_was_found_is_doubted_from_a_tenth_of_gravity() {
        let mut session = sarcos_shoulder().session(0);
        session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|r| r.std = None);
        let mut answer = answer(&session);
        let BesideGravity { std: own, share: share_of_own, .. } =
            answer.solved.noise_beside_gravity(&session).unwrap()[1].unwrap();
        let state = answer.solved.state(&State::nominal(&session));
        let mut doubts = |share: f64| {
            let mut readings = answer.solved.readings().clone();
            readings.noise[1] = own * share / share_of_own;
            let built = build_problem(&session, &readings, &state).unwrap();
            answer.solved = Solved::at_start(built).unwrap();
            answer.solved.estimate.termination = Termination::ZeroResidual;
            let mut large = false;
            let told = found(|findings| large = answer.remark_on_noise_found(&session, findings).unwrap());
            (large, told.1[0].concat())
        };
        assert_eq!(doubts(0.099), (false, String::new()));
        let (large, reason) = doubts(0.101);
        assert!(large && reason.contains("joint2") && !reason.contains("joint1"), "{reason}");
    }
}
