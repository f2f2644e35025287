//! Tables of `[[validation]]` that contradict the result.
//!
//! What fitted readings leave open predicts others badly, and contradicts nothing. So both are explained together, and that must not cost much more than the
//! fitted ones alone (Chow, *Econometrica* 28, 1960): with `n` readings that the fit did not see, they contradict it by the factor
//!
//! ```text
//!     √([χ²(fitted and unseen) − χ²(fitted)] / n)
//! ```
//!
//! beside which the fit's own misfit is no news.

use gravcal_estimation::Loss;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::Session;

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::held_out::of_validation;
use crate::joint::solved::Solved;
use crate::joint::solving::fit::fit;
use crate::joint::variables::State;
use crate::result::HeldOut;

/// Residuals so many times larger than noise, errors and what was left open allow: those of another day are larger, too, and contradict nothing.
const CONTRADICTED: f64 = 3.0;
/// So many iterations tell a contradiction: the last digits of a sum of squares do not matter.
const ITERATIONS: usize = 100;

impl Answer {
    /// What contradicts it, and what to look at.
    ///
    /// # Errors
    /// Where a problem cannot be built or solved.
    pub(in crate::joint::reporting) fn contradicted_validation(
        &self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<String>, EstimateError> {
        if session.validation.is_empty() || environment.stopped() {
            return Ok(None);
        }
        let found = self.solved.state(&State::nominal(session));
        let Some(predicted) = of_validation(session, self.solved.readings(), found)? else { return Ok(None) };
        let allowed = CONTRADICTED * self.misfit.unwrap_or(1.0).max(1.0);
        let times = |chi_squared: f64| (chi_squared / predicted.readings as f64).sqrt();
        if times(predicted.chi_squared) < allowed {
            return Ok(None);
        }
        let more = self.solved.costs_more_with_validation(session, environment)?;
        Ok((times(2.0 * more) > allowed).then(|| in_words(&predicted, times(2.0 * more))))
    }
}

impl Solved {
    /// By how much ½ χ² of the fitted readings grows where those of validation are to be explained as well.
    fn costs_more_with_validation(
        &self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<f64, EstimateError> {
        let poses: Vec<_> = session.poses.iter().chain(&session.validation).cloned().collect();
        let mut repeated = session.repeated.clone();
        repeated.resize(poses.len(), false);
        let both = Session { poses, validation: Vec::new(), repeated, ..session.clone() };
        let start = self.state(&State::nominal(session));
        let start = State { deflections: Vec::new(), static_friction: Vec::new(), ..start };
        let readings = MeasurementSet { loss: Loss::None, ..self.readings().of_other_poses(&both) };
        let environment = &environment.within(ITERATIONS);
        let cost = |readings: &MeasurementSet| {
            let (_, estimate) = fit(&build_with_constraints(&both, readings, &start)?, environment)?;
            Ok::<_, EstimateError>(estimate.cost)
        };
        Ok(cost(&readings)? - cost(&readings.only(|id| id.pose < session.poses.len()))?)
    }
}

fn in_words(predicted: &HeldOut, times: f64) -> String {
    let share = |range: f64, rms: f64| if range > 0.0 { rms / range } else { 0.0 };
    let worst = predicted.joints.iter().max_by(|a, b| share(a.range, a.rms).total_cmp(&share(b.range, b.rms)));
    let most = worst.map_or_else(String::new, |worst| {
        let of_range = significant(100.0 * share(worst.range, worst.rms), 2);
        format!(
            ", most in {}: {} {}, {of_range} % of the range of its fitted readings",
            worst.joint,
            significant(worst.rms, 2),
            worst.unit
        )
    });
    format!(
        "{} of [[validation]] contradicts the result: its residuals are {} times as large as noise and what is left open allow{most}. Look at its columns, units \
         and load; or the arm, its load or its base was changed between the recordings.",
        predicted.files.join(", "),
        significant(times, 2),
    )
}

#[cfg(test)]
mod tests {
    use crate::result::Verdict;
    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::estimate;
    use gravcal_robot_model::session::Session;

    /// The reference protocol, of which two tables are only predicted; each without a load.
    fn validated() -> Session {
        let mut session = sarcos_shoulder().session(0);
        let (unseen, seen) = session.poses.into_iter().partition(|pose| pose.table < 2);
        (session.poses, session.validation) = (seen, unseen);
        session
    }

    #[test]
    fn tables_that_are_as_predicted_contradict_nothing() {
        let result = estimate(&validated());
        assert!(!result.notes.iter().any(|note| note.contains("[[validation]]")), "{:?}", result.notes);
    }

    #[test]
    fn exchanged_columns_of_validation_leave_the_result_in_doubt() {
        let mut session = validated();
        session.validation.iter_mut().for_each(|pose| pose.torque.swap(1, 2));
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::PartlyDetermined);
        let reason = &result.notes[0];
        assert!(
            reason.contains("of [[validation]] contradicts the result") && reason.contains("most in joint"),
            "{reason}"
        );
    }

    /// Of an arm of which only the last joint moved before, the torques of the others are predicted badly, and contradict nothing.
    #[test]
    fn what_fitted_readings_leave_open_contradicts_nothing() {
        let mut session = sarcos_shoulder().session(0);
        let mut poses: Vec<_> = session.poses.iter().filter(|pose| pose.load.is_none()).cloned().collect();
        session.validation = poses.split_off(poses.len() / 2);
        let first = poses[0].clone();
        for pose in &mut poses {
            for joint in 0..2 {
                pose.position[joint] = first.position[joint];
                pose.torque[joint] = None;
            }
        }
        session.poses = poses;
        let result = estimate(&session);
        assert!(!result.notes.iter().any(|note| note.contains("[[validation]]")), "{:?}", result.notes);
    }
}
