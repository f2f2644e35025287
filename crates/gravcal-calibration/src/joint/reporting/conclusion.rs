//! What an answer is worth, and what a reader must know of it, for reports and batches alike.

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::mistakes::bad_readings::bad_readings;
use crate::joint::mistakes::hypothesis::{Cause, Mistake};
use crate::joint::mistakes::search::{contradicting_mistake, hidden_mistake};
use crate::joint::order::Order;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::joint::solved::Solved;
use crate::judgement::{far_off, off_together};
use crate::result::Verdict;

/// Said where there was no time for all.
const STOPPED: &str = "Stopped before all was looked over: other starting values and likely mistakes may not have been tried, so that the \
                       numbers may be those of a local minimum. Calibrate again, and let it end.";

/// An answer, and what it is worth.
pub(in crate::joint) struct Conclusion {
    pub answer: Answer,
    pub verdict: Verdict,
    /// Why the solver ended, or why there is no answer to rely on.
    pub termination: String,
    /// Why the verdict is no better.
    pub reasons: Vec<String>,
    /// What else a reader must know before any number.
    pub remarks: Vec<String>,
}

impl Conclusion {
    /// What was found of an answer comes to a verdict. A failed one has no values.
    pub fn of(session: &Session, mut answer: Answer, findings: Findings) -> Conclusion {
        let verdict = findings.verdict(answer.is_complete(session));
        if verdict == Verdict::Failed {
            answer.withdraw_values();
        }
        let (failure, [reasons, remarks]) = findings.reported();
        let termination = failure.unwrap_or_else(|| report_termination(&answer.solved));
        Conclusion { answer, verdict, termination, reasons, remarks }
    }
}

impl Answer {
    /// What a reader must know of it before any number.
    pub fn looked_over(
        &self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Findings, EstimateError> {
        let mut findings = Findings::none(self.solved.estimate.termination.converged());
        let far_off = !far_off(session, &self.parameters).is_empty();
        if !self.explains_its_readings() || far_off || session.is_of_two_sources() {
            findings.doubt();
        }
        self.remark_on_noise(session, &mut findings)?;
        self.remark_on_blocks(&mut findings);
        self.remark_on_pose_errors(&mut findings);
        self.solved.contradicted_priors(session).into_iter().for_each(|reason| findings.doubt_for(reason));
        self.solved.contradicted_description(session).into_iter().for_each(|reason| findings.doubt_for(reason));
        self.remark_on_residuals(session, &mut findings);
        let solved = &self.solved;
        let of_joints = solved
            .biases_that_hold_friction(session)
            .into_iter()
            .chain(solved.biases_that_may_hold_friction(session))
            .chain(solved.errors_that_last(session))
            .chain(solved.gains_that_hold_bending(session))
            .chain(solved.gains_that_hold_friction_of_load(session))
            .chain(solved.lengths_found(session))
            .chain(solved.tilts_found(session));
        of_joints.for_each(|remark| findings.remark(remark));
        self.remark_on_shifted_readings(&mut findings);
        off_together(session, &self.parameters).into_iter().for_each(|remark| findings.remark(remark));
        self.remark_on_exact().into_iter().for_each(|remark| findings.remark(remark));
        self.remark_on_contradictions(session, &mut findings)?;
        self.remark_on_unexplained(session, &mut findings)?;
        self.remark_on_heavy_tails(session, &mut findings)?;
        let noisy = self.remark_on_noise_found(session, &mut findings)?;
        self.remark_on_gravity_upwards(session, &mut findings);
        self.remark_on_earlier(session, &mut findings, environment)?;
        let excused = self.solved.has_large_unexplained_errors(session)?;
        if let Some(cause) = self.cause(session, &findings, environment)? {
            self.forget_mirrored(session, &mut findings);
            findings.fail_because_of(cause);
        } else if let Some(bad) = self.bad_readings(session, environment)? {
            match self.contradicted_noise(session)? {
                Some(contradicted) => {
                    findings.forget(&[contradicted.advice]);
                    findings.fail_first(bad);
                }
                None => {
                    findings.doubt();
                    findings.reason_first([format!("{}. {}", bad.what, bad.advice)]);
                }
            }
        } else if self.contradiction(session)?.is_some() || noisy || excused {
            findings.reason_first(session.stuck_positions_remark());
        }
        if !findings.failed() {
            findings.reason_first(self.half_turned_zeros(session));
            if let Some(reason) = self.contradicted_validation(session, environment)? {
                findings.doubt();
                findings.reason_first([reason]);
            }
        }
        let stopped = environment.stopped().then(|| STOPPED.to_owned());
        for doubt in session.positions_too_far().into_iter().chain(stopped) {
            findings.doubt();
            findings.reason_first([doubt]);
        }
        Ok(findings)
    }

    /// Readings that are off in ways of which residuals say nothing.
    fn remark_on_shifted_readings(&self, findings: &mut Findings) {
        for (holds, told) in [&self.settles, &self.bends].into_iter().flatten().cloned() {
            if holds { findings.remark(told) } else { findings.doubt_for(told) }
        }
        self.uneven.clone().into_iter().for_each(|remark| findings.remark(remark));
    }

    /// What the session may have got wrong.
    fn cause(
        &self,
        session: &Session,
        findings: &Findings,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Cause>, EstimateError> {
        let contradicting = match (self.mistakes.doubtful, findings.failed()) {
            (false, true) => contradicting_mistake(session, &self.solved, environment)?,
            _ => self.mistakes.found.clone(),
        };
        match contradicting {
            None => hidden_mistake(session, &self.solved, environment),
            found => Ok(found),
        }
    }

    /// What hangs on that which the session takes as exact.
    fn remark_on_exact(&self) -> Option<String> {
        let taken: Vec<String> = self.taken_as_exact.iter().map(ToString::to_string).collect();
        (!taken.is_empty()).then(|| {
            format!(
                "Some things are taken as exact, and residuals need not show that they are not. If {}. Intervals include only what is stated.",
                taken.join("; if ")
            )
        })
    }

    /// Single readings that contradict all others, where the readings contradict the model.
    fn bad_readings(
        &self,
        session: &Session,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Option<Mistake>, EstimateError> {
        match self.misfit.is_some() && self.solved.estimate.termination.converged() {
            true => bad_readings(session, &self.solved, environment),
            false => Ok(None),
        }
    }
}

/// Why the solver ended, in words.
fn report_termination(solved: &Solved) -> String {
    let termination = solved.estimate.termination;
    let last = if termination.converged() { "the last" } else { "one" };
    match &solved.readings().order {
        Order::Together => termination.to_string(),
        Order::StepByStep(steps) => {
            format!("{} steps, each with the covariance of those before; {last} {termination}", steps.len())
        }
        Order::PoseByPose { .. } => {
            let (first, all) = (solved.readings().first().poses(), solved.readings().poses());
            format!("{first} poses together, then {} one by one; {last} {termination}", all - first)
        }
    }
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter;
    use gravcal_robot_model::session::PriorKind;

    use super::*;
    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::estimate;

    /// Full turns more change no torque: only how far joints turn tells that these are no radians.
    #[test]
    fn positions_beyond_what_joints_turn_leave_all_in_doubt_however_well_they_fit() {
        let mut simulation = sarcos_shoulder();
        simulation.truth.sensors[1][SensorParameter::PositionGain as usize] = 1.0;
        simulation.template.joints[1].parameters[SensorParameter::PositionGain as usize].kind = PriorKind::Fixed;
        let concluded = |turns: f64| {
            let mut session = simulation.session(0);
            let more = session.poses.iter_mut().step_by(2);
            more.for_each(|pose| pose.position[1] += turns * std::f64::consts::TAU);
            let result = estimate(&session);
            (result.verdict, result.notes[..result.reasons].to_vec())
        };
        assert_eq!(concluded(0.0), (Verdict::Determined, vec![]));
        let (verdict, reasons) = concluded(3.0);
        assert_eq!(verdict, Verdict::PartlyDetermined, "{reasons:?}");
        assert!(reasons[0].contains("angles of joint2 reach") && reasons[0].contains("farther than joints turn"));
    }
}
