//! The joint estimator's answer: from readings to what they determine.

use gravcal_estimation::Termination;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::ends::other_ends::or_other_end;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::reporting::payloads::payloads;
use crate::joint::reporting::report::report_parameters;
use crate::joint::solved::Solved;
use crate::joint::solving::solve::solve;
use crate::joint::variables::State;
use crate::judgement::{Asked, Judgement, ResidualTests, TestsWanted, residual_tests};
use crate::result::{GravityResult, ParameterResult, ResidualTest, UncertaintyResult, UnexplainedResult, Verdict};

/// The solution, judged.
pub(in crate::joint) struct Answer {
    pub solved: Solved,
    pub judgement: Judgement,
    /// Where its standard deviations come from.
    pub uncertainty: UncertaintyResult,
    pub gravity: Option<GravityResult>,
    pub parameters: Vec<ParameterResult>,
    /// Whether residuals have a shape that noise has not, as far as that is told.
    pub residual_tests: Vec<ResidualTest>,
    /// How many times worse than their stated noise the readings are explained, where that is no accident.
    pub misfit: Option<f64>,
    /// Errors of each channel beyond its noise.
    pub unexplained: Vec<Option<UnexplainedResult>>,
}

/// What it is worth.
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

/// The solution after a look at where else the truth may lie, and with what is known there. One method looks, whichever found the solution: where
/// the readings say next to nothing, methods end at different places of the same valley, and what is told must not depend on that.
fn looked_at_by_one_method(
    solved: Solved,
    session: &Session,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let judge = environment.solver().judge().filter(|judge| judge.check(&solved.built.problem).is_ok());
    let by_judge = judge.as_ref().map(|judge| environment.by(judge.as_ref()));
    let environment = by_judge.as_ref().unwrap_or(environment);
    let solved = or_other_end(solved, session, environment)?;
    environment.report("judging what is determined");
    solved.with_nearby(session, environment)?.with_profiles(session, environment)
}

impl Answer {
    /// Solves for everything, looks where else the truth may lie, and judges what is determined, and how well. `wanted`: which tests on residuals.
    ///
    /// # Errors
    /// Where there is no answer at all.
    pub fn of(
        session: &Session,
        readings: &MeasurementSet,
        known: Option<&State>,
        wanted: TestsWanted,
        environment: &SolveEnvironment<'_>,
    ) -> Result<Answer, EstimateError> {
        let solved = solve(session, readings, known, environment)?;
        let solved = looked_at_by_one_method(solved, session, environment)?;
        // What was stopped on its way explains the readings badly whatever the model.
        let unexplained = solved.unexplained_sizes(session)?;
        let misfit = solved.misfit(session)?.filter(|_| solved.estimate.termination != Termination::Stopped);
        let (uncertainty, reported) = solved.chosen_uncertainty(session, misfit, environment)?;
        let solved = Solved { uncertainty, ..solved }.widened_beyond_linear(session);
        let mut judgement = solved.judge(session);
        if solved.freedom_of_noise(session).is_some() {
            judgement.leave_unsaid(session.parameters().into_iter().map(Asked::from).chain([Asked::Gravity]));
        }
        environment.report("judging residuals");
        // What readings determine they determine; a term that the model lacks widens its interval.
        let ResidualTests { tests, moved } = residual_tests(session, &solved, &reported, wanted)?;
        let solved = solved.widened_by_missing_terms(&moved);
        Ok(Answer {
            gravity: judgement.determines(Asked::Gravity).then(|| solved.gravity(session)),
            parameters: report_parameters(session, &solved, &judgement),
            residual_tests: tests,
            uncertainty: reported,
            judgement,
            misfit,
            unexplained,
            solved,
        })
    }

    /// Whether all that is asked for is determined.
    pub fn is_complete(&self, session: &Session) -> bool {
        let gravity = self.gravity.is_some() || !session.asks("gravity");
        let loads = payloads(session, &self.solved).iter().all(|load| load.undetermined.is_none());
        self.parameters.iter().all(|p| p.determined || !p.asked) && gravity && loads
    }

    /// Takes the values of a failed estimate back: only what was fixed has one.
    pub fn withdraw_values(&mut self) {
        self.gravity = None;
        for parameter in self.parameters.iter_mut().filter(|parameter| parameter.held.is_none()) {
            parameter.determined = false;
            (parameter.value, parameter.std, parameter.ci95) = (None, None, None);
        }
    }
}
