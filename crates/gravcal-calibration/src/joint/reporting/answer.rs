//! The joint estimator's answer: a solution, and what the readings determine of it.

use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::mistakes::hypothesis::Cause;
use crate::joint::model_error::pose_errors::PoseErrors;
use crate::joint::reporting::payloads::payloads;
use crate::joint::solved::Solved;
use crate::judgement::{Asked, Judgement};
use crate::result::{GravityResult, ParameterResult, ResidualTest, TakenAsExact, UncertaintyResult, UnexplainedResult};

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
    /// What errs from pose to pose.
    pub pose_errors: Option<PoseErrors>,
    /// What hangs on that which the session takes as exact.
    pub taken_as_exact: Vec<TakenAsExact>,
    /// Errors of each channel beyond its noise.
    pub unexplained: Vec<Option<UnexplainedResult>>,
    /// What readings still settle, in words, and whether intervals that allow for it hold.
    pub settles: Option<(bool, String)>,
    /// How badly is known what bending does in motion, in words, and whether intervals that allow for it hold.
    pub bends: Option<(bool, String)>,
    /// Sweeps that run faster one way than the other, in words.
    pub uneven: Option<String>,
    /// What the session may have got wrong.
    pub mistakes: LookedForMistakes,
}

/// Mistakes that were looked for before intervals were.
#[derive(Clone, Debug, Default)]
pub(in crate::joint) struct LookedForMistakes {
    /// Whether the fit said nothing for the session, so that any were looked for.
    pub doubtful: bool,
    pub found: Option<Cause>,
}

impl Answer {
    /// A solution in numbers, as far as it is determined; `origin`: where its standard deviations come from, with the tests on its residuals.
    pub fn of(
        session: &Session,
        solved: Solved,
        judgement: Judgement,
        (misfit, pose_errors): (Option<f64>, Option<PoseErrors>),
        (origin, residual_tests): (UncertaintyResult, Vec<ResidualTest>),
    ) -> Result<Answer, EstimateError> {
        Ok(Answer {
            gravity: judgement.determines(Asked::Gravity).then(|| solved.gravity(session)),
            parameters: report_parameters(session, &solved, &judgement),
            unexplained: solved.unexplained_sizes(session)?,
            uncertainty: origin,
            residual_tests,
            judgement,
            misfit,
            pose_errors,
            taken_as_exact: Vec::new(),
            settles: None,
            bends: None,
            uneven: None,
            mistakes: LookedForMistakes::default(),
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

/// The session's parameters as they are told: of what is determined value, standard deviation and interval.
fn report_parameters(session: &Session, solved: &Solved, judgement: &Judgement) -> Vec<ParameterResult> {
    let mut parameters = Vec::new();
    for parameter in session.parameters() {
        let id = solved.built.variables.block(parameter);
        let value = solved.estimate.values.scalar(id);
        let mut reported = ParameterResult::blank(session, parameter);
        reported.determined = judgement.determines(parameter) && reported.determined;
        if reported.determined {
            reported.value = Some(value);
            reported.std = Some(solved.parameter_std(parameter));
            let own: Vec<(usize, f64)> = solved.built.problem.columns_of(id).map(|column| (column, 1.0)).collect();
            reported.ci95 = Some(solved.uncertainty.interval(value, &own));
        }
        parameters.push(reported);
    }
    parameters
}
