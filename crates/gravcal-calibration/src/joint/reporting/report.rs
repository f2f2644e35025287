//! A solved problem in words and numbers.

use gravcal_estimation::BlockId;
use gravcal_estimation::statistics::stored_coordinates;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{EarlierCalibration, LAST_FRAME_CHOICE, PriorKind, Session};

use crate::joint::building::{constraints, modelled, sweep_moments};
use crate::joint::error::EstimateError;
use crate::joint::judging::model_tests::ModelTests;
use crate::joint::judging::uncertainty::LEAST_FREEDOM;
use crate::joint::order::Order;
use crate::joint::reporting::answer::{Answer, Conclusion};
use crate::joint::reporting::consistent::consistent_model;
use crate::joint::reporting::payloads::payloads;
use crate::joint::solved::Solved;
use crate::judgement::{
    Asked, DeterminedMoment, Judgement, concerns, deflections, determined_moments, driving_friction_notes, held,
    keep_determined, loss, negative_rotor_notes, outlier_note, outliers, position_errors, too_large, tool_notes,
    weak_combinations, weak_note,
};
use crate::result::{
    CovarianceResult, Detail, EstimatorResult, Fit, Iteration, ParameterResult, Undetermined, Verdict,
};

/// Tells a conclusion in words and numbers.
pub(in crate::joint) fn report(
    session: &Session,
    name: &str,
    conclusion: Conclusion,
    mut fit: Fit,
    environment: &SolveEnvironment<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let Conclusion { answer, verdict, termination, reasons, remarks } = conclusion;
    let Answer { solved, judgement, uncertainty, gravity, parameters, residual_tests, .. } = answer;
    let solved = &solved;
    let bias = |joint: usize| judgement.determines(ParameterId::Sensor(joint, SensorParameter::TorqueBias));
    keep_determined(&mut fit.residuals, gravity.is_some(), bias);
    let situation = solved.situation(session);
    let moments = report_moments(session, solved, &judgement);
    let mut undetermined: Vec<Undetermined> = unknown_noise(session, solved, &parameters).into_iter().collect();
    undetermined.extend(judgement.combinations.iter().map(|c| situation.report(&c.into())));
    undetermined.extend(unknown_sign(session, solved, &solved.readings.spreads));
    undetermined.extend(last_frame_choices(session));
    let tests = ModelTests { session, solved, judgement: &judgement, fit: &fit, uncertainty: &uncertainty };
    let sensor_models = tests.all(environment)?;
    let outliers = outliers(session, solved)?;
    let weak = weak_combinations(solved);
    let (consistent_model, of_model) = match verdict {
        Verdict::Failed => (None, Vec::new()),
        Verdict::Determined | Verdict::PartlyDetermined => consistent_model(session, solved)?,
    };
    let (reason_count, mut notes) = (reasons.len(), reasons);
    notes.extend(remarks);
    notes.extend(of_model);
    notes.extend(fit.held_out_missing.iter().map(no_held_out_note));
    notes.extend(report_session(session, solved, &parameters));
    notes.extend(modelled::notes(session, solved)?);
    notes.extend(outlier_note(solved.built.loss, solved.built.rows.len(), &outliers));
    notes.extend(untested_note(solved));
    // Where the solver stopped anywhere, so did these.
    notes.extend(weak.iter().filter(|_| solved.estimate.termination.converged()).map(weak_note));
    let mut result = EstimatorResult {
        iterations: solved.estimate.iterations.len().saturating_sub(1),
        trace: report_trace(solved),
        covariance: report_covariance(session, solved, &judgement, &moments),
        moments: moments.into_iter().map(|moment| moment.reported).collect(),
        deflections: deflections(session, solved),
        position_errors: position_errors(session, solved),
        gravity,
        parameters,
        sensor_models,
        residual_tests,
        undetermined,
        active_constraints: constraints::report(&solved.built.problem, &solved.estimate.active),
        weak,
        held: held(solved),
        uncertainty: Some(uncertainty),
        loss: loss(solved.built.loss),
        outliers,
        fit: Some(fit),
        payloads: payloads(session, solved),
        consistent_model,
        reasons: reason_count,
        notes,
        detail: Detail {
            singular_values: solved.analysis.singular_values().to_vec(),
            iterates: report_iterates(session, solved),
        },
        ..EstimatorResult::blank(name, verdict, termination)
    };
    result.concerns = concerns(&result);
    if verdict == Verdict::Failed || solved.freedom_of_noise(session).is_some() {
        withdraw(&mut result);
    }
    Ok(result)
}

/// Noise that no std states, where too few readings are left to tell it: then nothing tells how well anything is known.
fn unknown_noise(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Option<Undetermined> {
    let freedom = solved.freedom_of_noise(session)?;
    let (rows, rank) = (solved.judged_problem().rows(), solved.analysis.rank());
    let open = parameters.iter().filter(|parameter| parameter.asked && !parameter.determined);
    Some(Undetermined {
        combination: "the size of the noise".into(),
        parameters: open.map(|parameter| parameter.name.clone()).collect(),
        why: format!(
            "the noise is not stated, and {rows} readings that determine {rank} numbers leave {freedom} degrees of freedom to estimate it from; \
             at least {LEAST_FREEDOM} are needed. Without it nothing tells how well anything is known"
        ),
        cure: "state the std of the torque readings (readings.torque.std), or record more poses".into(),
    })
}

/// Says where residuals are not tested as there are too many readings and unknowns.
fn untested_note(solved: &Solved) -> Option<String> {
    let (rows, columns) = (solved.judged_problem().rows(), solved.judged_problem().columns().len());
    too_large(solved).then(|| {
        format!(
            "Residuals were not tested for drifts, harmonics and neighbours: {rows} readings with {columns} unknowns are \
             too many. Calibrate fewer poses, or without unknowns of each pose (readings.position.std), for a test."
        )
    })
}

fn no_held_out_note(why: &String) -> String {
    format!("Held-out poses were not predicted: the second fit was {why}.")
}

/// What a reader needs to know of a session and of what it held.
fn report_session(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Vec<String> {
    let mut notes: Vec<String> = session_notes(session).into_iter().collect();
    notes.extend(session.earlier.iter().flat_map(EarlierCalibration::notes));
    notes.extend(sweep_moments::left_out_note(session));
    notes.extend(driving_friction_notes(session, parameters));
    notes.extend(negative_rotor_notes(session, parameters));
    notes.extend(tool_notes(session, solved, parameters));
    notes.extend((!solved.estimate.active.is_empty()).then(|| ALONG_CONSTRAINTS.to_owned()));
    notes
}

/// Takes back what a failed estimate says besides its parameters.
fn withdraw(result: &mut EstimatorResult) {
    result.covariance = CovarianceResult::default();
    result.moments.clear();
    result.payloads.clear();
    result.deflections.clear();
    result.position_errors.clear();
    result.sensor_models.clear();
    result.detail.iterates.clear();
    result.uncertainty = None;
}

pub(in crate::joint) fn report_termination(solved: &Solved) -> String {
    let termination = solved.estimate.termination;
    let last = if termination.converged() { "the last" } else { "one" };
    match &solved.readings.order {
        Order::Together => termination.to_string(),
        Order::StepByStep(steps) => {
            format!("{} steps, each with the covariance of those before; {last} {termination}", steps.len())
        }
        Order::PoseByPose { .. } => {
            let (first, all) = (solved.readings.first().poses(), solved.readings.poses());
            format!("{first} poses together, then {} one by one; {last} {termination}", all - first)
        }
    }
}

/// Costs from start to end; of no meaning where every update has a cost of its own.
fn report_trace(solved: &Solved) -> Vec<Iteration> {
    match solved.readings.order {
        Order::Together => solved.estimate.iterations.iter().map(Iteration::from).collect(),
        Order::StepByStep(_) | Order::PoseByPose { .. } => Vec::new(),
    }
}

/// The sensors' parameters after each iteration of the trace.
fn report_iterates(session: &Session, solved: &Solved) -> Vec<Vec<f64>> {
    let blocks: Vec<BlockId> = session.parameters().into_iter().map(|id| solved.built.variables.block(id)).collect();
    solved.estimate.iterates.iter().map(|values| blocks.iter().map(|block| values.scalar(*block)).collect()).collect()
}

pub(in crate::joint) fn report_parameters(
    session: &Session,
    solved: &Solved,
    judgement: &Judgement,
) -> Vec<ParameterResult> {
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

const ALONG_CONSTRAINTS: &str = "Standard deviations hold along the active constraints: what these hold is taken as \
                                 known exactly.";

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

/// The choices of the last links' frames, told as something undetermined.
pub(crate) fn last_frame_choices(session: &Session) -> Vec<Undetermined> {
    let chain = &session.robot.chain;
    let chosen =
        |joint: &usize| session.fixed_reason(*joint, SensorParameter::PositionOffset) == Some(LAST_FRAME_CHOICE);
    let report = |joint: usize| {
        let name = SensorParameter::PositionOffset.name(&chain.joints()[joint].name);
        let of_branch = chain.links_of(joint).map(|link| format!("link {}", chain.links()[link].name));
        let link = if chain.is_serial() { "the last link".into() } else { of_branch.collect::<Vec<_>>().join(" or ") };
        Undetermined {
            combination: name.clone(),
            parameters: vec![name],
            why: "a choice of the last link's frame: turning it turns the unknown moments and placements along".into(),
            cure: format!("state a load's position in {link} (position_m)"),
        }
    };
    (0..session.joints.len()).filter(chosen).map(report).collect()
}

/// That the readings do not tell gravity from its opposite, where that is so; with the parameters that would turn with it.
pub(crate) fn unknown_sign(session: &Session, solved: &Solved, spreads: &[f64]) -> Option<Undetermined> {
    let turning = solved.turning_with_gravity(session, spreads).into_iter().map(|id| session.parameter_name(id));
    let [why, cure] = match session.gravity.hemisphere {
        None => [
            "gravity the other way up, with all masses and moments negative, explains the readings as well",
            "state gravity's rough direction ([gravity] hemisphere), or attach a load of known mass at the end of known lengths",
        ],
        Some(_) => [
            "the readings are explained best with gravity outside of its declared hemisphere, and hardly worse on the border of it",
            "add poses that move the joints over a wider range, or attach a load of known mass",
        ],
    };
    (!solved.sign_known).then(|| Undetermined {
        combination: "sign of gravity".into(),
        parameters: std::iter::once("gravity".into()).chain(turning).collect(),
        why: why.into(),
        cure: cure.into(),
    })
}

/// What every estimator's reader should know of frames, positions and loads.
pub(crate) fn session_notes(session: &Session) -> Vec<String> {
    let mut notes: Vec<String> = session.repeated_note().into_iter().collect();
    notes.extend(session.unmoved_note());
    notes.extend(base_frame_note(session));
    notes.extend(load_mass_note(session));
    notes.extend(mimic_notes(session));
    for (joint, count) in session.robot.chain.joints().iter().zip(&session.saturated).filter(|(_, count)| **count > 0) {
        notes.push(format!(
            "{count} torque readings of {} are at an end of the sensor's range: left out, as the true ones may be \
             anything beyond.",
            joint.name
        ));
    }
    notes.extend(session.searched.iter().flat_map(|searched| searched.notes(&session.readings)));
    notes.extend(session.motion_notes());
    notes.extend(session.selection_note());
    let cut = session.robot.chain.cut_joints();
    if !cut.is_empty() {
        let end =
            if session.robot.chain.is_serial() { "The chain ends at its tip" } else { "Branches end at their tips" };
        notes.push(format!("{end}: what hangs there by {} is left out.", cut.join(", ")));
    }
    notes
}

/// What the torque gains take over from the loads.
fn load_mass_note(session: &Session) -> Option<String> {
    let open = session.joints.iter().any(|joint| joint.of(SensorParameter::TorqueGain).kind == PriorKind::Flat);
    let exact = |load: usize| !session.loads[load].is_unknown() && session.load_mass(load).is_none();
    let carried = session.poses.iter().any(|pose| pose.load.is_some_and(exact));
    (open && carried).then(|| {
        "Torque gains are measured against the loads' masses, taken as exact: a mass that is 1 % off puts every torque gain \
         1 % off, and no standard deviation here says so. If it was weighed with an error, say so: mass_kg = { nominal = …, std = … }."
            .to_owned()
    })
}

/// What the frame of the base is, where a joint defines it.
fn base_frame_note(session: &Session) -> Option<String> {
    let root = session.robot.chain.root_joint()?;
    let name = SensorParameter::PositionOffset.name(&session.robot.chain.joints()[root].name);
    Some(match session.joints[root].of(SensorParameter::PositionOffset).nominal {
        0.0 => format!("{name} is zero by definition of the base frame."),
        given => format!("{name} is held at {given:.6}, which defines the base frame."),
    })
}

/// Whose torque holds the joints that have no sensor of their own because they mimic another.
fn mimic_notes(session: &Session) -> Vec<String> {
    let chain = &session.robot.chain;
    let followers = |joint: usize| {
        let name = &chain.joints()[joint].name;
        let movers = chain.links_of(joint).map(|link| chain.movers()[link].name.clone());
        movers.filter(|mover| mover != name).collect::<Vec<_>>().join(", ")
    };
    let note = |joint: usize| {
        let (leader, followers) = (&chain.joints()[joint].name, followers(joint));
        (!followers.is_empty()).then(|| {
            format!("The torque of {leader} is also that of {followers}, which mimics it, times the multiplier.")
        })
    };
    (0..session.joints.len()).filter_map(note).collect()
}
