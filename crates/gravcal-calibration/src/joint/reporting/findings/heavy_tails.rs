//! Says so where few readings are many times as far off as all others (`model_error/heavy_tails.rs`).

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::model_error::heavy_tails::HeavyTails;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;

/// Rows that are named.
const NAMED: usize = 5;

impl Answer {
    /// Windows of an arm in motion turn round, and have tails by friction; what a loss forgets has been told.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint::reporting) fn remark_on_heavy_tails(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<(), EvaluateError> {
        let Some(HeavyTails { channels, poses }) = self.solved.heavy_tails(session)? else { return Ok(()) };
        let listed = channels.into_iter().map(|(channel, sizes)| {
            let [rms, usual] = sizes.map(|size| significant(size, 2));
            format!("{} (rms {rms} {}, usually {usual})", session.channel_name(channel), session.channel_unit(channel))
        });
        let listed: Vec<String> = listed.collect();
        let named: Vec<String> = poses
            .iter()
            .take(NAMED)
            .map(|pose| {
                let (file, line) = session.row_of(*pose);
                format!("{file}:{line}")
            })
            .collect();
        // With hardly any beyond the limit, residuals are of two kinds all the same.
        let more = if poses.len() > NAMED { format!(" and {} more", poses.len() - NAMED) } else { String::new() };
        let at = if named.is_empty() {
            " at the largest".to_owned()
        } else {
            format!(" at {}{more} first,", named.join(", "))
        };
        findings.doubt_for(format!(
            "Some readings are many times farther off than the others: {}. They are no noise: a wrong load label, spikes, wrong cells. Look{} \
             and leave out what is wrong; or count what is far off less ([loss] kind = \"tukey\"), or state the std that the sensors have.",
            listed.join(", "),
            at
        ));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::joint::reporting::findings::testing::{answer, found};
    use crate::testing::sarcos_shoulder;

    #[test]
    fn few_readings_that_are_far_off_are_told_with_their_rows_and_noise_is_not() {
        let told = |every: usize| {
            let mut session = sarcos_shoulder().session(0);
            for (place, pose) in session.poses.iter_mut().enumerate() {
                pose.torque.iter_mut().flatten().for_each(|reading| {
                    reading.std = None;
                    reading.value += if place % every == every - 1 { 80.0 } else { 0.0 };
                });
            }
            let line = session.poses[every.min(session.poses.len()) - 1].line;
            let answer = answer(&session);
            let (failure, [reasons, _]) = found(|findings| answer.remark_on_heavy_tails(&session, findings).unwrap());
            assert_eq!(failure, None);
            (line, reasons)
        };
        let (line, reasons) = told(50);
        assert!(reasons.len() == 1 && reasons[0].contains("joint1 (rms "), "{reasons:?}");
        let (_, named) = reasons[0].split_once("Look at ").unwrap();
        let named: Vec<u64> = named.split(&[':', ',', ' '][..]).filter_map(|word| word.parse().ok()).collect();
        assert!(named.contains(&line), "{line}: {reasons:?}");
        assert_eq!(told(usize::MAX).1, Vec::<String>::new());
    }
}
