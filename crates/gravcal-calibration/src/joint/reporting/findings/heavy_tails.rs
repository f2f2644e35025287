//! Noise that was found from residuals of which few are many times as large as all others: these are no noise.
//!
//! A load that some rows do not carry, spikes and wrong cells make the standard deviation many times what the median of the residuals says
//! (`1.48 median |r|`, the same for a normal distribution). They weigh with all others then, and shift what they pull at.

use gravcal_estimation::{EvaluateError, Loss};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;

/// From this ratio of the two on readings are of two kinds: beside a normal distribution the squares of few make up eight ninths of all.
const OF_TWO_KINDS: f64 = 3.0;
/// Fewer readings tell no tails.
const FEWEST: usize = 30;
/// Median deviations from which a reading is far off, and rows that are named.
const FAR: f64 = 6.0;
const NAMED: usize = 5;

impl Answer {
    /// Says so. Windows of an arm in motion turn round, and have tails by friction; what a loss forgets has been told.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint::reporting) fn remark_on_heavy_tails(
        &self,
        session: &Session,
        findings: &mut Findings,
    ) -> Result<(), EvaluateError> {
        let solved = &self.solved;
        if solved.built.loss != Loss::None || session.has_windows() || !solved.estimate.termination.converged() {
            return Ok(());
        }
        let rows = solved.row_residuals()?;
        let (usual, found) = (solved.median_noise(session, &rows), session.noise_estimated());
        let (mut listed, mut far) = (Vec::new(), Vec::new());
        for channel in (0..session.channel_count()).filter(|channel| found[*channel]) {
            let own = || solved.built.rows.iter().zip(&rows).filter(|(id, _)| id.channel == channel);
            let count = own().count();
            let squares: f64 =
                own().map(|(id, row)| (row.whitened * solved.readings().std(session, *id)).powi(2)).sum();
            let (rms, usual) = ((squares / count.max(1) as f64).sqrt(), usual[channel]);
            if count < FEWEST || usual <= 0.0 || rms < OF_TWO_KINDS * usual {
                continue;
            }
            let [rms, half] = [rms, usual].map(|size| significant(size, 2));
            listed.push(format!(
                "{} (rms {rms} {}, usually {half})",
                session.channel_name(channel),
                session.channel_unit(channel)
            ));
            far.extend(own().filter_map(|(id, row)| {
                let off = row.whitened.abs() * solved.readings().std(session, *id) / usual;
                (off > FAR).then_some((off, id.pose))
            }));
        }
        if listed.is_empty() {
            return Ok(());
        }
        far.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut poses: Vec<usize> = Vec::new();
        for (_, pose) in far {
            if !poses.contains(&pose) {
                poses.push(pose);
            }
        }
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
