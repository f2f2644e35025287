//! The steps' values in words and numbers.

use gravcal_estimation::BlockId;
use gravcal_estimation::statistics::Quantile;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use super::found::Missing;
use super::values::SequentialValues;
use crate::joint::{self, EstimateError, MeasurementSet, solve_built};
use crate::judgement::{concerns, determined_moments, gravity_result};
use crate::result::{
    Brief, CovarianceResult, EstimatorResult, NoiseSource, ParameterResult, UncertaintyResult, Undetermined, Verdict,
};

/// Tells the steps' values. To judge them on the same footing as the joint estimator, the joint problem is solved
/// for what the steps leave out (masses, moments, placements, parameters not found) with their values held.
///
/// # Errors
/// Where that problem has no answer at all.
pub fn report_steps(
    session: &Session,
    known: &SequentialValues,
    environment: &SolveEnvironment<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let Brief { verdict, termination, iterations, gravity, parameters } = report_steps_briefly(session, known);
    let undetermined = report_missing(session, known);
    let any = verdict != Verdict::Failed;
    let mut result = EstimatorResult {
        iterations,
        gravity,
        parameters,
        covariance: report_covariance(session, known),
        undetermined,
        uncertainty: any.then(|| report_uncertainty(session, &known.readings)),
        notes: report_notes(session, known),
        ..EstimatorResult::blank("sequential", verdict, termination)
    };
    if let Some(start) = known.as_start(session) {
        environment.report("judging the sequential values on all readings");
        let start = joint::start_around(session, &known.readings, &start)?;
        let mut built = joint::build_problem(session, &known.readings, &start)?;
        let fixed = found_blocks(&built, known);
        built.problem = built.problem.with_fixed(&fixed, "found by the sequential steps");
        let solved = solve_built(built, environment)?;
        if !solved.estimate.termination.converged() {
            result.notes.push(format!("The fit below is no optimum: {}.", solved.estimate.termination));
        }
        let moments = determined_moments(
            &solved.built.problem,
            &solved.estimate.values,
            &solved.built.variables,
            &solved.analysis,
            solved.covariance(),
            &[],
        );
        result.moments = moments.into_iter().map(|moment| moment.reported).collect();
        result.detail.singular_values = solved.analysis.singular_values().to_vec();
        result.fit = Some(joint::fit_with_held_out(session, &solved, environment)?);
    }
    result.concerns = concerns(&result);
    Ok(result)
}

/// The same of sensors and gravity alone, without judging it.
pub fn report_steps_briefly(session: &Session, known: &SequentialValues) -> Brief {
    let parameters = report_parameters(session, known);
    let asked = session.asks("gravity");
    let gravity = known.gravity.as_ref().ok();
    let complete = parameters.iter().all(|p| p.determined || !p.asked) && (gravity.is_some() || !asked);
    let any = parameters.iter().any(|p| p.determined && p.held.is_none()) || gravity.is_some();
    Brief {
        verdict: match (any, complete) {
            (false, _) => Verdict::Failed,
            (true, true) => Verdict::Determined,
            (true, false) => Verdict::PartlyDetermined,
        },
        termination: match known.impossible {
            None => "three steps, each with the results of the steps before frozen".into(),
            Some(_) => "no step was taken".into(),
        },
        iterations: known.iterations,
        gravity: gravity.map(|g| {
            let std = |axis: usize| g.covariance[4 * axis].max(0.0).sqrt();
            let ci95 = std::array::from_fn(|axis| Quantile::normal().interval(g.vector[axis], std(axis)));
            gravity_result(g.vector, &g.covariance, ci95, asked, |std, _| Quantile::normal().cone(std))
        }),
        parameters,
    }
}

fn report_uncertainty(session: &Session, readings: &MeasurementSet) -> UncertaintyResult {
    let source = match session.noise_estimated().contains(&true) {
        true => NoiseSource::Residuals,
        false if readings.unexplained_found(session) => NoiseSource::StatedAndUnexplained,
        false => NoiseSource::Stated,
    };
    UncertaintyResult::Noise { source, widened_by: None }
}

fn found_blocks(built: &joint::JointProblem, known: &SequentialValues) -> Vec<BlockId> {
    let sensors = built.variables.sensors.iter().zip(&known.sensors).flat_map(|(ids, sensor)| {
        SensorParameter::ALL.into_iter().filter(|q| sensor.of(*q).is_ok()).map(|q| ids[q as usize])
    });
    // Whatever else sensors do, the steps take it as it is assumed.
    sensors.chain([built.variables.gravity]).chain(built.variables.further_once()).collect()
}

/// Gravity's covariance and the variances of what the steps found: between steps, and between the parameters of one
/// step, nothing is known to the sequential estimator, and zeros stand for it.
fn report_covariance(session: &Session, known: &SequentialValues) -> CovarianceResult {
    let joints = session.robot.chain.joints().iter().zip(&known.sensors).enumerate();
    let found = joints.flat_map(|(index, (joint, sensor))| {
        SensorParameter::ALL.into_iter().filter_map(move |quantity| {
            let free = session.fixed_reason(index, quantity).is_none();
            let frozen = sensor.of(quantity).as_ref().ok().filter(|_| free)?;
            Some((quantity.name(&joint.name), frozen.std * frozen.std))
        })
    });
    let gravity = known.gravity.as_ref().ok();
    let axes = if gravity.is_some() { 3 } else { 0 };
    let (names, variances): (Vec<String>, Vec<f64>) = found.unzip();
    let order: Vec<String> =
        ["gravity.x", "gravity.y", "gravity.z"][..axes].iter().map(|n| (*n).to_owned()).chain(names).collect();
    let entry = |i: usize, j: usize| match gravity {
        Some(gravity) if i < axes && j < axes => gravity.covariance[3 * i + j],
        _ if i == j => variances[i - axes],
        _ => 0.0,
    };
    let matrix = (0..order.len()).map(|i| (0..order.len()).map(|j| entry(i, j)).collect()).collect();
    CovarianceResult { order, matrix }
}

fn report_parameters(session: &Session, known: &SequentialValues) -> Vec<ParameterResult> {
    let quantile = Quantile::normal();
    let report = |id: ParameterId| {
        let mut reported = ParameterResult::blank(session, id);
        let ParameterId::Sensor(joint, quantity) = id else {
            reported.determined = false;
            return reported;
        };
        match known.sensors[joint].of(quantity) {
            Ok(found) if reported.determined => {
                reported.value = Some(found.value);
                reported.std = Some(found.std);
                reported.ci95 = Some(quantile.interval(found.value, found.std));
            }
            _ => reported.determined = false,
        }
        reported
    };
    session.parameters().into_iter().map(report).collect()
}

/// What was not found, parameters with one and the same reason together.
fn report_missing(session: &Session, known: &SequentialValues) -> Vec<Undetermined> {
    if let Some(missing) = &known.impossible {
        return vec![Undetermined {
            combination: "everything".into(),
            ..missing.clone().report(vec!["everything".into()])
        }];
    }
    let mut reasons: Vec<(Missing, Vec<String>)> = Vec::new();
    let mut add = |missing: &Missing, name: String| match reasons.iter_mut().find(|(m, _)| m == missing) {
        Some((_, names)) => names.push(name),
        None => reasons.push((missing.clone(), vec![name])),
    };
    if let Err(missing) = &known.gravity {
        add(missing, "gravity".into());
    }
    for (joint, sensor) in known.sensors.iter().enumerate() {
        for quantity in SensorParameter::ALL {
            if let Err(missing) = sensor.of(quantity) {
                add(missing, quantity.name(&session.robot.chain.joints()[joint].name));
            }
        }
    }
    for id in session.parameters() {
        let name = session.parameter_name(id);
        if matches!(id, ParameterId::Further(_)) && session.asks(&name) {
            add(&Missing::new(ONLY_AFFINE, "use the joint estimator"), name);
        }
    }
    let mut reported: Vec<Undetermined> = reasons.into_iter().map(|(missing, names)| missing.report(names)).collect();
    reported.extend(joint::last_frame_choices(session));
    reported
}

const ONLY_AFFINE: &str = "the sequential procedure knows only gains, biases and offsets of joint sensors";

fn report_notes(session: &Session, known: &SequentialValues) -> Vec<String> {
    let mut notes = joint::session_notes(session);
    if known.impossible.is_some() {
        return notes;
    }
    notes.push(
        "Standard deviations are those of each step given the frozen results of the steps before it; the errors of \
         those results are not in them, and no covariance between steps is known."
            .into(),
    );
    let unheeded = [
        (!session.instruments.is_empty(), "instruments"),
        (!session.residuals.is_empty(), "residuals"),
        (session.earlier.is_some(), "earlier calibrations"),
    ];
    notes.extend(
        unheeded.into_iter().filter(|(there, _)| *there).map(|(_, what)| format!("The steps do not heed {what}.")),
    );
    notes.extend(known.gravity.as_ref().ok().and_then(|g| g.assumed.clone()));
    if !session.terms.is_empty() {
        notes.push(
            "The steps know only affine sensors: their values are those of readings without further terms.".into(),
        );
    }
    let largest: Vec<String> = known
        .largest_residuals
        .iter()
        .enumerate()
        .filter_map(|(joint, largest)| {
            let unit = session.joints[joint].torque_unit.map_or_else(String::new, |u| u.to_string());
            Some(format!("{} {:.2} {unit}", session.robot.chain.joints()[joint].name, (*largest)?))
        })
        .collect();
    if !largest.is_empty() {
        notes.push(format!("Largest residual of the sinusoids of step 1: {}.", largest.join(", ")));
    }
    notes
}
