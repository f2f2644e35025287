//! The joint estimator: every torque reading once, all unknowns together.

mod constraints;
mod earlier;
mod hold;
mod idle;
mod linear_part;
mod model_tests;
mod placements;
mod position_unknowns;
mod problem;
mod readings;
mod reversed;
mod robust;
mod solve;
mod start;
mod sweep_moments;
mod torques;
mod twins;
mod uncertainty;
mod unknowns;

use gravcal_estimation::statistics::{LinearFunction, StatisticsError, TooFewBlocks, stored_coordinates};
use gravcal_estimation::{EvaluateError, SolveError, Termination};
use gravcal_kinematics::JointKind;
use thiserror::Error;

use crate::judgement::{
    Combination, DeterminedMoment, Judgement, Situation, deflections, determined_moments, gravity_result, held, judge,
    loss, outlier_note, outliers, position_errors, weak_combinations, weak_note,
};
use crate::parameter::Quantity;
use crate::result::{
    CovarianceResult, EstimatorResult, Fit, GravityResult, Iteration, ParameterResult, UncertaintyResult, Undetermined,
    Verdict,
};
use crate::sequential::Plan;
use crate::session::{EarlierCalibration, LAST_FRAME_CHOICE, Session};
use crate::workbench::Workbench;

use hold::SetAside;
pub(crate) use hold::judge_at_start;
use model_tests::ModelTests;
pub use position_unknowns::PositionUnknown;
pub(crate) use position_unknowns::sweeping;
pub use problem::{JointProblem, PosingError, pose};
pub use readings::Readings;
pub(crate) use robust::{GAUGE, NORMAL_MEDIAN, median};
pub use solve::{Solved, solve};
pub(crate) use solve::{fit_with_held_out, solve_posed};
pub(crate) use start::start_around;
use sweep_moments::SweepMoments;
pub(crate) use twins::DECISIVE;
pub use unknowns::{Layout, Unknowns};

/// The joint problem could not be solved.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EstimateError {
    /// It could not be posed.
    #[error(transparent)]
    Posing(#[from] PosingError),
    /// It could not be solved.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// It could not be judged.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// How uncertain it is could not be told.
    #[error("no standard deviations: {0}")]
    Statistics(#[from] StatisticsError),
}

impl From<TooFewBlocks> for EstimateError {
    fn from(error: TooFewBlocks) -> Self {
        EstimateError::Statistics(error.into())
    }
}

/// Which torque readings an estimator may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signals {
    /// All of them.
    All,
    /// Only those that the paper's steps read.
    PaperSteps,
}

/// Solves the joint problem, from `known` values (the sequential estimator's) if they start it better than the
/// nominal ones.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub fn estimate_jointly(
    session: &Session,
    signals: Signals,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let name = match signals {
        Signals::All => "joint",
        Signals::PaperSteps => "joint-paper-signals",
    };
    let solved = solve(session, &select(session, signals), known, workbench)?;
    let fit = solve::fit_with_held_out(session, &solved, workbench)?;
    // What was stopped on its way explains the readings badly whatever the model.
    let misfit = fit.misfit().filter(|_| solved.estimate.termination != Termination::Stopped);
    let (uncertainty, told) = solved.chosen_uncertainty(session, misfit, workbench)?;
    let solved = Solved { uncertainty, ..solved };
    let mut result = tell(session, name, &solved, fit, told, workbench)?;
    if let Some(misfit) = misfit {
        tell_misfit(misfit, &mut result);
    }
    let doubtful = session.noise_estimated().contains(&true) || result.verdict == Verdict::Failed;
    if let Some(reversed) = reversed::reversed_sensors(session, &solved, doubtful, workbench)? {
        tell_reversed(session, &reversed, &mut result);
    }
    if result.verdict == Verdict::Failed {
        withdraw(&mut result);
    }
    Ok(result)
}

/// Takes the values of a failed estimate back: only what was held has one.
fn withdraw(result: &mut EstimatorResult) {
    result.gravity = None;
    result.covariance = CovarianceResult::default();
    result.moments.clear();
    result.deflections.clear();
    result.position_errors.clear();
    result.sensor_models.clear();
    result.uncertainty = None;
    for parameter in result.parameters.iter_mut().filter(|parameter| parameter.held.is_none()) {
        parameter.determined = false;
        (parameter.value, parameter.std, parameter.ci95) = (None, None, None);
    }
}

/// Readings explained this many times worse than their stated noise contradict the model: no number can be relied on.
const CONTRADICTION: f64 = 3.0;

/// Says that the stated noise does not explain the residuals; beyond [`CONTRADICTION`] the estimate has failed.
fn tell_misfit(misfit: f64, result: &mut EstimatorResult) {
    let consequence = match result.uncertainty {
        Some(UncertaintyResult::Noise { widened_by: Some(_), .. }) => {
            "All standard deviations are widened by that factor."
        }
        _ => "Standard deviations come from the residuals, and need no widening.",
    };
    result.notes.push(format!(
        "The readings are explained {misfit:.1} times worse than their stated noise (p < 0.001). {consequence}"
    ));
    if misfit > CONTRADICTION {
        result.verdict = Verdict::Failed;
        result.termination =
            format!("the model contradicts the readings: residuals {misfit:.0} times the stated noise");
        result.notes.push(
            "What to look at: the sign of a torque sensor (torque_sign = \"reversed\"), units, swapped columns, the \
             hemisphere of gravity, the loads' masses and distances, values given as fixed, poses that are not static, \
             single bad rows. If the model is known to be this rough, leave std away: the noise is then estimated from \
             the residuals."
                .into(),
        );
    }
}

/// Says which torque sensors are reversed; values for the wrong signs are none.
fn tell_reversed(session: &Session, reversed: &reversed::Reversed, result: &mut EstimatorResult) {
    let names: Vec<&str> = reversed.joints.iter().map(|j| session.robot.chain.joints()[*j].name.as_str()).collect();
    let (names, sensors, each) = match names.as_slice() {
        [only] => ((*only).to_owned(), "sensor", "in its [[joint]]"),
        several => (several.join(", "), "sensors", "in the [[joint]] of each"),
    };
    result.verdict = Verdict::Failed;
    result.termination = format!("reversed torque {sensors}: {names}");
    result.notes.insert(
        0,
        format!(
            "The torque {sensors} of {names} read the other way: {}. Say torque_sign = \"reversed\" {each}; or \
             \"normal\", if that is how it is.",
            reversed.why
        ),
    );
}

/// The torque readings that an estimator may use, with a first guess of unstated noise.
pub fn select(session: &Session, signals: Signals) -> Readings {
    let noise = solve::first_noise(session);
    let moments = sweep_moments::by_sweep(session).then(|| SweepMoments::of(session));
    let entering = |pose: usize, channel: usize| {
        channel >= session.joints.len() || moments.as_ref().is_none_or(|moments| moments.of_pose(pose).is_some())
    };
    match signals {
        Signals::All => Readings::select(session, noise, entering),
        Signals::PaperSteps => {
            let read = Plan::new(session).readings();
            Readings::select(session, noise, |pose, joint| read.contains(&(pose, joint)) && entering(pose, joint))
        }
    }
}

/// The joint problem at nominal values, with its constraints: what a solver must be able to take.
pub(crate) fn pose_at_nominal(session: &Session) -> Result<JointProblem, EstimateError> {
    hold::pose_with(session, &select(session, Signals::All), &Unknowns::nominal(session), &[])
}

/// Tells a solved problem in words and numbers.
fn tell(
    session: &Session,
    name: &str,
    solved: &Solved,
    fit: Fit,
    uncertainty: UncertaintyResult,
    workbench: &Workbench<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let judgement = solved.judge(session);
    let situation = solved.situation(session);
    let gravity = judgement.gravity.then(|| solved.gravity(session));
    let parameters = tell_parameters(session, solved, &judgement);
    let moments = determined_moments(
        &solved.posed.problem,
        &solved.estimate.values,
        &solved.posed.layout,
        &solved.spectrum,
        solved.covariance(),
    );
    let mut undetermined: Vec<Undetermined> = judgement.combinations.iter().map(|c| situation.tell(c)).collect();
    undetermined.extend((!solved.sign_known).then(unknown_sign));
    undetermined.extend(last_frame_choice(session));
    let converged = solved.estimate.termination.converged();
    let complete =
        parameters.iter().all(|p| p.determined || !p.asked) && (gravity.is_some() || !session.asks("gravity"));
    let mirrored = if converged { mirrored_gains(session, solved, &parameters) } else { Vec::new() };
    let mut notes = session_notes(session);
    notes.extend(session.earlier.as_ref().map(EarlierCalibration::note));
    notes.extend(set_aside_notes(session, solved));
    notes.extend(sweep_moments::left_out_note(session));
    notes.extend(mirrored.iter().cloned());
    notes.extend((!solved.estimate.active.is_empty()).then(|| ALONG_CONSTRAINTS.to_owned()));
    let tests = ModelTests { session, solved, judgement: &judgement, fit: &fit, uncertainty: &uncertainty };
    let sensor_models = tests.all(workbench)?;
    let outliers = outliers(session, solved)?;
    notes.extend(outlier_note(solved.posed.loss, solved.posed.rows.len(), &outliers));
    let weak = weak_combinations(solved);
    notes.extend(weak.iter().map(weak_note));
    Ok(EstimatorResult {
        name: name.to_owned(),
        verdict: match (converged && mirrored.is_empty(), complete) {
            (false, _) => Verdict::Failed,
            (true, true) => Verdict::Determined,
            (true, false) => Verdict::PartlyDetermined,
        },
        termination: solved.estimate.termination.to_string(),
        iterations: solved.estimate.iterations.len().saturating_sub(1),
        trace: solved.estimate.iterations.iter().map(Iteration::from).collect(),
        covariance: tell_covariance(session, solved, &judgement, &moments),
        moments: moments.into_iter().map(|moment| moment.told).collect(),
        deflections: deflections(session, solved),
        position_errors: position_errors(session, solved),
        gravity,
        parameters,
        sensor_models,
        undetermined,
        active_constraints: constraints::tell(&solved.posed.problem, &solved.estimate.active),
        weak,
        held: held(solved),
        uncertainty: Some(uncertainty),
        loss: loss(solved.posed.loss),
        outliers,
        fit: Some(fit),
        notes,
    })
}

fn tell_parameters(session: &Session, solved: &Solved, judgement: &Judgement) -> Vec<ParameterResult> {
    let mut parameters = Vec::new();
    for parameter in session.parameters() {
        let id = solved.posed.layout.block(parameter);
        let value = solved.estimate.values.scalar(id);
        let mut told = session.blank_parameter(parameter);
        told.determined = judgement.determines(parameter) && told.determined;
        if told.determined {
            told.value = Some(value);
            told.std = Some(solved.parameter_std(parameter));
            let own: Vec<(usize, f64)> = solved.posed.problem.columns_of(id).map(|column| (column, 1.0)).collect();
            told.ci95 = Some(solved.uncertainty.interval(value, &own));
        }
        parameters.push(told);
    }
    parameters
}

const ALONG_CONSTRAINTS: &str = "Standard deviations hold along the active constraints: what these hold is taken as \
                                 known exactly.";

/// A gain of the other sign than declared is the mirror image of a solution, not an answer.
fn mirrored_gains(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Vec<String> {
    let mut mirrored = Vec::new();
    for (joint, ids) in solved.posed.layout.sensors.iter().enumerate() {
        for quantity in [Quantity::TorqueGain, Quantity::PositionGain] {
            let name = quantity.name(&session.robot.chain.joints()[joint].name);
            let value = solved.estimate.values.scalar(ids[quantity as usize]);
            let determined = parameters.iter().any(|p| p.name == name && p.determined);
            if determined && value * session.joints[joint].of(quantity).nominal < 0.0 {
                mirrored.push(format!(
                    "{name} came out as {value:.4}, of the other sign than declared: if the sensor is mounted \
                     reversed, say so ({}_sign = \"reversed\" in its [[joint]])",
                    if quantity == Quantity::TorqueGain { "torque" } else { "position" },
                ));
            }
        }
    }
    mirrored
}

/// The covariance of what is determined: gravity, sensor parameters, and the combinations of moments by their place.
fn tell_covariance(
    session: &Session,
    solved: &Solved,
    judgement: &Judgement,
    moments: &[DeterminedMoment],
) -> CovarianceResult {
    let layout = &solved.posed.layout;
    let mut blocks = Vec::new();
    if judgement.gravity {
        blocks.push(layout.gravity);
    }
    let free = session.parameters().into_iter().filter(|id| session.parameter(*id).held.is_none());
    blocks.extend(free.filter(|id| judgement.determines(*id)).map(|id| layout.block(id)));
    let problem = &solved.posed.problem;
    let mut functions = stored_coordinates(problem, &solved.estimate.values, &blocks);
    functions.extend(moments.iter().map(|moment| moment.function.clone()));
    let stored = solved.covariance().of(&functions);
    let components =
        blocks.iter().flat_map(|id| (0..problem.block(*id).len()).map(|i| problem.block(*id).component_name(i)));
    let order: Vec<String> = components.chain((0..moments.len()).map(|index| format!("moments[{index}]"))).collect();
    CovarianceResult { matrix: stored.chunks(order.len().max(1)).map(<[f64]>::to_vec).collect(), order }
}

/// The choice of the last link's frame, told as something undetermined.
pub(crate) fn last_frame_choice(session: &Session) -> Option<Undetermined> {
    let last = session.joints.len() - 1;
    let name = Quantity::PositionOffset.name(&session.robot.chain.joints()[last].name);
    (session.held_reason(last, Quantity::PositionOffset) == Some(LAST_FRAME_CHOICE)).then(|| Undetermined {
        combination: name.clone(),
        parameters: vec![name],
        why: "a choice of the last link's frame: turning it turns the unknown moments and placements along".into(),
        cure: "state a load's position in the last link (position_m)".into(),
    })
}

/// That the readings do not tell gravity from its opposite.
pub(crate) fn unknown_sign() -> Undetermined {
    Undetermined {
        combination: "sign of gravity".into(),
        parameters: vec!["gravity".into()],
        why: "gravity the other way up, with all masses and moments negative, explains the readings as well".into(),
        cure: "state gravity's rough direction ([gravity] hemisphere), or attach a load of known mass at the end of known \
               lengths"
            .into(),
    }
}

/// Which parameters were set aside, in words.
fn set_aside_notes(session: &Session, solved: &Solved) -> Vec<String> {
    let tell = |aside: &SetAside| {
        let parameter = session.parameter(aside.parameter);
        if aside.is_idle_joint() {
            return format!("{} carries no gravity: its torque readings enter through its bias only.", parameter.owner);
        }
        format!(
            "The data say too little of {}: the rest, moments included, is estimated with it at {}.",
            parameter.name(),
            aside.value
        )
    };
    solved.set_aside.iter().map(tell).collect()
}

/// What every estimator's reader should know of frames, positions and loads.
pub(crate) fn session_notes(session: &Session) -> Vec<String> {
    let name = Quantity::PositionOffset.name(&session.robot.chain.joints()[0].name);
    let mut notes = vec![match session.joints[0].of(Quantity::PositionOffset).nominal {
        0.0 => format!("{name} is zero by definition of the base frame."),
        given => format!("{name} is held at {given:.6}, which defines the base frame."),
    }];
    for (index, joint) in session.robot.chain.joints().iter().enumerate() {
        let gain = session.joints[index].of(Quantity::PositionGain).nominal;
        let turns = session.poses.iter().map(|pose| (gain * pose.position[index]).abs()).fold(0.0, f64::max);
        if joint.kind == JointKind::Revolute && turns > IMPLAUSIBLE_ANGLE {
            notes.push(format!("{} reads up to {turns:.0} rad: is its unit deg, declared as rad?", joint.name));
        }
    }
    for (joint, count) in session.robot.chain.joints().iter().zip(&session.saturated).filter(|(_, count)| **count > 0) {
        notes.push(format!(
            "{count} torque readings of {} are at an end of the sensor's range: left out, as the true ones may be \
             anything beyond.",
            joint.name
        ));
    }
    notes.extend(session.selection_note());
    let cut = session.robot.chain.cut_joints();
    if !cut.is_empty() {
        notes.push(format!("The chain ends at its tip: what hangs on it by {} is left out.", cut.join(", ")));
    }
    for (index, load) in session.loads.iter().enumerate() {
        if session.poses.iter().all(|pose| pose.load != Some(index)) {
            notes.push(format!("No pose carries load `{}`: is a `load =` missing from a [[poses]]?", load.name));
        }
    }
    notes
}

/// No joint of an arm turns this far, rad: two turns.
const IMPLAUSIBLE_ANGLE: f64 = 4.0 * std::f64::consts::PI;

impl Solved {
    /// What is determined, with what was set aside counted as not.
    pub(crate) fn judge(&self, session: &Session) -> Judgement {
        self.judge_with_spreads(session, &session.spreads())
    }

    /// The same with given spreads (largest less smallest reading of each channel).
    pub(crate) fn judge_with_spreads(&self, session: &Session, spreads: &[f64]) -> Judgement {
        let (posed, values) = (&self.posed, &self.estimate.values);
        let mut judgement = judge(
            session,
            &posed.problem,
            values,
            &posed.layout,
            (&self.spectrum, self.covariance()),
            spreads,
            &self.idle,
        );
        judgement.gravity &= self.sign_known;
        judgement.combinations.extend(self.set_aside.iter().map(|aside| aside.combination.clone()));
        judgement.combinations.extend(self.readings.unread_and_unknown(session).into_iter().map(Combination::alone));
        judgement
    }

    pub(crate) fn situation<'s>(&self, session: &'s Session) -> Situation<'s> {
        let g = self.estimate.values.get(self.posed.layout.gravity);
        let read = (0..session.joints.len()).map(|joint| self.posed.rows.iter().any(|(_, j)| *j == joint)).collect();
        let unread = self.readings.unread_and_unknown(session);
        Situation { session, gravity: [g[0], g[1], g[2]], read, unread, idle: self.idle.clone() }
    }

    fn gravity(&self, session: &Session) -> GravityResult {
        let (problem, values, id) = (&self.posed.problem, &self.estimate.values, self.posed.layout.gravity);
        let axes = stored_coordinates(problem, values, &[id]);
        let radius = |_std: f64, along: [f64; 3]| {
            let of_axis = |(axis, share): (&LinearFunction, f64)| {
                axis.iter().map(|(column, c)| (*column, share * c)).collect::<Vec<_>>()
            };
            let function: LinearFunction = axes.iter().zip(along).flat_map(of_axis).collect();
            self.uncertainty.cone(&function)
        };
        let g = values.get(id);
        gravity_result([g[0], g[1], g[2]], &self.gravity_covariance(), session.asks("gravity"), radius)
    }
}
