//! What readings come to: the solution, what of it is determined, and what a reader must know of it, for reports and batches alike.

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::mistakes::hypotheses::find_mistake;
use crate::joint::reporting::answer::{Answer, Conclusion};
use crate::joint::reporting::findings::verdict::Findings;
use crate::joint::reporting::report::report_termination;
use crate::joint::variables::State;
use crate::judgement::{TestsWanted, far_off};
use crate::result::Verdict;

/// Solves and judges the joint problem of these readings. `wanted`: which tests on residuals.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub(in crate::joint) fn conclude(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    wanted: TestsWanted,
    environment: &SolveEnvironment<'_>,
) -> Result<Conclusion, EstimateError> {
    let mut answer = Answer::of(session, readings, known, wanted, environment)?;
    let mut findings = answer.looked_over(session, environment)?;
    if environment.stopped() {
        findings.doubt();
        findings.reason_first([
            "Stopped before all was looked over: other starting values and likely mistakes may not have been tried, \
                                so that the numbers may be those of a local minimum. Calibrate again, and let it end."
                .to_owned(),
        ]);
    }
    let verdict = findings.verdict(answer.is_complete(session));
    if verdict == Verdict::Failed {
        answer.withdraw_values();
    }
    let (failure, [reasons, remarks]) = findings.reported();
    let termination = failure.unwrap_or_else(|| report_termination(&answer.solved));
    Ok(Conclusion { answer, verdict, termination, reasons, remarks })
}

impl Answer {
    /// What a reader must know of it before any number.
    fn looked_over(&self, session: &Session, environment: &SolveEnvironment<'_>) -> Result<Findings, EstimateError> {
        let mut findings = Findings::none(self.solved.estimate.termination.converged());
        if !self.explains_its_readings() || !far_off(session, &self.parameters).is_empty() {
            findings.doubt();
        }
        self.remark_on_noise(session, &mut findings)?;
        self.remark_on_blocks(&mut findings);
        self.solved.contradicted_priors(session).into_iter().for_each(|reason| findings.doubt_for(reason));
        self.remark_on_residuals(session, &mut findings);
        self.solved.biases_that_hold_friction(session).into_iter().for_each(|remark| findings.remark(remark));
        self.solved.gains_that_hold_bending(session).into_iter().for_each(|remark| findings.remark(remark));
        self.remark_on_contradictions(session, &mut findings)?;
        self.remark_on_unexplained(session, &mut findings);
        let noisy = self.remark_on_noise_found(session, &mut findings)?;
        self.remark_on_gravity_upwards(session, &mut findings);
        self.remark_on_earlier(session, &mut findings, environment)?;
        let excused = self.has_large_unexplained_errors();
        let doubtful = session.noise_estimated().contains(&true) || excused || findings.failed();
        if let Some(mistake) = find_mistake(session, &self.solved, doubtful, environment)? {
            self.forget_mirrored(session, &mut findings);
            findings.fail_first(mistake);
        } else if self.contradiction(session)?.is_some() || noisy || excused {
            findings.reason_first(session.stuck_positions_remark());
        }
        Ok(findings)
    }
}
