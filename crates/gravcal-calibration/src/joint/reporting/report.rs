//! A solved problem in words and numbers.

use gravcal_estimation::statistics::stored_coordinates;
use gravcal_estimation::{BlockId, EvaluateError};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use crate::joint::building::constraints;
use crate::joint::error::EstimateError;
use crate::joint::identifiability::model_tests::ModelTests;
use crate::joint::order::Order;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::conclusion::Conclusion;
use crate::joint::reporting::consistent::consistent_model;
use crate::joint::reporting::notes::notes;
use crate::joint::reporting::payloads::payloads;
use crate::joint::reporting::undetermined::undetermined;
use crate::joint::solved::Solved;
use crate::judgement::{
    Asked, DeterminedMoment, Judgement, concerns, deflections, determined_moments, held, keep_determined, loss,
    outliers, position_errors, weak_combinations,
};
use crate::result::{Concern, CovarianceResult, Detail, EstimatorResult, Fit, Iteration, SensorModelTest, Verdict};

/// Tells a conclusion in words and numbers.
pub(in crate::joint) fn report(
    session: &Session,
    name: &str,
    conclusion: Conclusion,
    mut fit: Fit,
    environment: &SolveEnvironment<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let Conclusion { answer, verdict, termination, reasons, remarks } = conclusion;
    keep_determined_torques(&answer, &mut fit);
    let (consistent_model, of_model) = match verdict {
        Verdict::Failed => (None, Vec::new()),
        Verdict::Determined | Verdict::PartlyDetermined => consistent_model(session, &answer.solved)?,
    };
    let sensor_models = match verdict {
        Verdict::Failed => Vec::new(),
        Verdict::Determined | Verdict::PartlyDetermined => report_model_tests(session, &answer, &fit, environment)?,
    };
    let blank = EstimatorResult::blank(name, verdict, termination);
    let mut result = EstimatorResult {
        undetermined: undetermined(session, &answer),
        sensor_models,
        consistent_model,
        fit: Some(fit),
        reasons: reasons.len(),
        ..with_solution(session, &answer, blank)?
    };
    result.notes = [reasons, remarks, of_model, notes(session, &answer.solved, &result)?].concat();
    let from_one_side = match verdict {
        Verdict::Failed => Vec::new(),
        Verdict::Determined | Verdict::PartlyDetermined => answer.solved.joints_from_one_side(session),
    };
    let from_one_side: Vec<String> = from_one_side.into_iter().map(|joint| session.channel_name(joint)).collect();
    result.concerns = concerns(&result);
    result.concerns.extend((!from_one_side.is_empty()).then_some(Concern::OneSidedApproach { joints: from_one_side }));
    if verdict == Verdict::Failed || answer.solved.freedom_of_noise(session).is_some() {
        withdraw_all_but_parameters(&mut result);
    }
    Ok(result)
}

/// Leaves of each reading's torque what gravity and biases that are determined say.
fn keep_determined_torques(answer: &Answer, fit: &mut Fit) {
    let bias = |joint: usize| answer.judgement.determines(ParameterId::Sensor(joint, SensorParameter::TorqueBias));
    keep_determined(&mut fit.residuals, answer.gravity.is_some(), bias);
}

/// Models of sensors and of links beside their absence.
fn report_model_tests(
    session: &Session,
    answer: &Answer,
    fit: &Fit,
    environment: &SolveEnvironment<'_>,
) -> Result<Vec<SensorModelTest>, EstimateError> {
    let Answer { solved, judgement, uncertainty, .. } = answer;
    ModelTests { session, solved, judgement, fit, uncertainty }.all(environment)
}

/// The same with the solution's numbers, how well they are known, and how it was found.
fn with_solution(session: &Session, answer: &Answer, blank: EstimatorResult) -> Result<EstimatorResult, EvaluateError> {
    let Answer { solved, judgement, uncertainty, gravity, parameters, residual_tests, taken_as_exact, .. } = answer;
    let moments = report_moments(session, solved, judgement);
    Ok(EstimatorResult {
        iterations: solved.estimate.iterations.len().saturating_sub(1),
        trace: report_trace(solved),
        covariance: report_covariance(session, solved, judgement, &moments),
        moments: moments.into_iter().map(|moment| moment.reported).collect(),
        deflections: deflections(session, solved),
        position_errors: position_errors(session, solved),
        gravity: gravity.clone(),
        parameters: parameters.clone(),
        residual_tests: residual_tests.clone(),
        taken_as_exact: taken_as_exact.clone(),
        active_constraints: constraints::report(&solved.built.problem, &solved.estimate.active),
        weak: weak_combinations(solved),
        held: held(solved),
        uncertainty: Some(uncertainty.clone()),
        loss: loss(solved.built.loss),
        outliers: outliers(session, solved)?,
        payloads: payloads(session, solved),
        detail: Detail {
            singular_values: solved.analysis.singular_values().to_vec(),
            iterates: report_iterates(session, solved),
        },
        ..blank
    })
}

/// Takes back what a failed estimate says besides gravity and its parameters, which the answer does not have any more.
fn withdraw_all_but_parameters(result: &mut EstimatorResult) {
    result.covariance = CovarianceResult::default();
    result.moments.clear();
    result.payloads.clear();
    result.deflections.clear();
    result.position_errors.clear();
    result.sensor_models.clear();
    result.taken_as_exact.clear();
    result.detail.iterates.clear();
    result.uncertainty = None;
}

/// Costs from start to end; of no meaning where every update has a cost of its own.
fn report_trace(solved: &Solved) -> Vec<Iteration> {
    match solved.readings().order {
        Order::Together => solved.estimate.iterations.iter().map(Iteration::from).collect(),
        Order::StepByStep(_) | Order::PoseByPose { .. } => Vec::new(),
    }
}

/// The sensors' parameters after each iteration of the trace.
fn report_iterates(session: &Session, solved: &Solved) -> Vec<Vec<f64>> {
    let blocks: Vec<BlockId> = session.parameters().into_iter().map(|id| solved.built.variables.block(id)).collect();
    solved.estimate.iterates.iter().map(|values| blocks.iter().map(|block| values.scalar(*block)).collect()).collect()
}

/// Combinations of moments and placements. Where gravity's sign is open, so is the sign of all of them.
fn report_moments(session: &Session, solved: &Solved, judgement: &Judgement) -> Vec<DeterminedMoment> {
    if !solved.sign_known {
        return Vec::new();
    }
    determined_moments(
        &solved.built.problem,
        &solved.estimate.values,
        &solved.built.variables,
        &solved.analysis,
        solved.covariance(),
        &open_columns(session, solved, judgement),
    )
}

/// Columns of gravity and of the parameters, as far as they are not determined.
fn open_columns(session: &Session, solved: &Solved, judgement: &Judgement) -> Vec<usize> {
    let variables = &solved.built.variables;
    let gravity = (!judgement.determines(Asked::Gravity)).then_some(variables.gravity);
    let open = session.parameters().into_iter().filter(|id| !judgement.determines(*id)).map(|id| variables.block(id));
    gravity.into_iter().chain(open).flat_map(|id| solved.built.problem.columns_of(id)).collect()
}

/// The covariance of what is determined: gravity, sensor parameters, and the combinations of moments by their place.
fn report_covariance(
    session: &Session,
    solved: &Solved,
    judgement: &Judgement,
    moments: &[DeterminedMoment],
) -> CovarianceResult {
    let variables = &solved.built.variables;
    let mut blocks = Vec::new();
    if judgement.determines(Asked::Gravity) {
        blocks.push(variables.gravity);
    }
    let free = session.parameters().into_iter().filter(|id| session.fixed(*id).is_none());
    blocks.extend(free.filter(|id| judgement.determines(*id)).map(|id| variables.block(id)));
    let problem = &solved.built.problem;
    let mut functions = stored_coordinates(problem, &solved.estimate.values, &blocks);
    functions.extend(moments.iter().map(|moment| moment.function.clone()));
    let stored = solved.covariance().of(&functions);
    let components =
        blocks.iter().flat_map(|id| (0..problem.block(*id).len()).map(|i| problem.block(*id).component_name(i)));
    let order: Vec<String> = components.chain((0..moments.len()).map(|index| format!("moments[{index}]"))).collect();
    CovarianceResult { matrix: stored.chunks(order.len().max(1)).map(<[f64]>::to_vec).collect(), order }
}
