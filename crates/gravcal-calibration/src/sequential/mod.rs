//! The sequential estimator: the paper's steps 1, 2 and 3, from the base outward, each step's result frozen for the
//! next.
//!
//! **Where standing joints are.** Step 2 uses each pose's own reading of the joint before the swept one (paper, eq. (16)), so
//! that a deflection which its sensor sees is no error. Step 3 fits a sinusoid to a whole sweep, and takes the mean of the
//! readings of the joints that stand. What sensors do not see the steps cannot know: see [`crate::session::Deflection`] for
//! the joint estimator.
//!
//! **When a step tells nothing.** Where its readings leave a number open, and where they rule out its model: its own χ², with
//! what the errors of earlier steps may do to it, has a probability below 0.001.

mod bias;
mod carried;
mod contradiction;
mod differences;
mod fitting;
mod found;
mod gain;
mod gravity;

use gravcal_estimation::BlockId;
use gravcal_estimation::statistics::Quantile;

use crate::joint::{self, EstimateError, Readings, Signals, Unknowns, solve_posed};
use crate::judgement::{determined_moments, gravity_result};
use crate::parameter::{ParameterId, Quantity};
use crate::result::{
    Brief, CovarianceResult, Detail, EstimatorResult, NoiseSource, ParameterResult, UncertaintyResult, Undetermined,
    Verdict,
};
use crate::session::Session;
use crate::workbench::Workbench;

use bias::Bias;
use carried::CarriedErrors;
use contradiction::NoiseKnowledge;
use gain::Gain;

pub use crate::plan::{LoadPair, Plan};
pub use found::{Found, Frozen, Missing};
pub use gravity::Gravity;

/// What the steps found for one joint.
#[derive(Clone, Debug)]
pub struct SensorValues {
    /// Step 3.
    pub torque_gain: Found,
    /// Step 1.
    pub torque_bias: Found,
    /// Step 1.
    pub position_gain: Found,
    /// Step 3.
    pub position_offset: Found,
}

impl SensorValues {
    /// What was found for one quantity.
    pub fn of(&self, quantity: Quantity) -> &Found {
        match quantity {
            Quantity::TorqueGain => &self.torque_gain,
            Quantity::TorqueBias => &self.torque_bias,
            Quantity::PositionGain => &self.position_gain,
            Quantity::PositionOffset => &self.position_offset,
        }
    }
}

/// What the steps found.
#[derive(Clone, Debug)]
pub struct SequentialValues {
    /// One for each joint.
    pub sensors: Vec<SensorValues>,
    /// Step 2.
    pub gravity: Result<Gravity, Missing>,
    /// Largest |residual| of the sinusoids of step 1 by joint, unit of the torque reading.
    pub largest_residuals: Vec<Option<f64>>,
    /// Solver iterations of all steps.
    pub iterations: usize,
    /// The readings with the noise that was stated or found.
    pub readings: Readings,
    /// Why there is nothing that the steps could do.
    pub impossible: Option<Missing>,
    /// Degrees of freedom of the residuals of step 1 by joint, none where it had no sweep.
    noise_freedom: Vec<usize>,
    errors: CarriedErrors,
}

/// Why the steps have nothing to do, if they have not.
fn impossible(session: &Session, plan: &Plan) -> Option<Missing> {
    if !session.robot.chain.is_serial() {
        return Some(Missing::new(
            "the steps go from joint to joint along one serial chain, and this robot branches or has joints that mimic others",
            "rely on the joint estimator (--estimator joint)",
        ));
    }
    plan.sweeps.is_empty().then(|| {
        Missing::new(
            "the session has no sweeps, which the steps are made of",
            "rely on the joint estimator; or sweep one joint while the others stand (`gravcal check` tells the rule)",
        )
    })
}

/// Results that steps are handed instead of those of the steps before: to learn which step's errors reach what.
#[derive(Clone, Copy, Debug, Default)]
pub struct Handed<'a> {
    /// Torque biases and position gains instead of those of step 1.
    pub step_1: Option<&'a Unknowns>,
    /// Gravity in base coordinates, m/s², instead of that of step 2.
    pub gravity: Option<[f64; 3]>,
}

/// Runs the paper's procedure.
pub fn run_steps(session: &Session, plan: &Plan, workbench: &Workbench<'_>) -> SequentialValues {
    run_steps_handed(session, plan, Handed::default(), workbench)
}

/// The same with some results handed in.
pub fn run_steps_handed(
    session: &Session,
    plan: &Plan,
    handed: Handed<'_>,
    workbench: &Workbench<'_>,
) -> SequentialValues {
    let joints = 0..session.joints.len();
    let mut readings = joint::select(session, Signals::All);
    if !session.robot.chain.is_serial() {
        return SequentialValues::without_steps(session, plan, readings);
    }

    workbench.tell("step 1: torque biases and position gains");
    let mut errors = CarriedErrors::none(session.joints.len());
    let mut biases = Vec::new();
    for joint in joints.clone() {
        let mut find = |readings: &Readings| bias::find_bias(session, plan, readings, joint, &mut errors, workbench);
        let mut bias = find(&readings);
        if let (Some(std), true) = (bias.residual_std, session.noise_estimated()[joint]) {
            readings.noise[joint] = std;
            bias = find(&readings);
        } else if let Some(variance) = bias.residual_std.and_then(|std| readings.beyond_noise(session, joint, std)) {
            readings.unexplained[joint] = variance;
            bias = find(&readings);
        }
        biases.push(bias);
    }
    let mut known = SequentialValues::after_step_1(&biases, readings, errors, impossible(session, plan));
    if let Some(values) = handed.step_1 {
        known.take_step_1(values);
    }

    workbench.tell("step 2: gravity");
    let mut errors = known.errors.clone();
    known.gravity = gravity::find_gravity(session, plan, &known, &mut errors, workbench);
    known.iterations += known.gravity.as_ref().map_or(0, |g| g.iterations);
    if let Some(vector) = handed.gravity {
        known.gravity = Ok(Gravity { vector, covariance: vec![0.0; 9], assumed: None, iterations: 0 });
        errors.forget(errors.gravity());
    }
    known.errors = errors;

    workbench.tell("step 3: torque gains and position offsets");
    for joint in joints {
        let mut errors = known.errors.clone();
        let Gain { torque_gain, position_offset, iterations } =
            gain::find_gain(session, plan, &known, joint, &mut errors, workbench);
        known.errors = errors;
        known.sensors[joint].torque_gain = torque_gain;
        known.sensors[joint].position_offset = position_offset;
        known.iterations += iterations;
    }
    known.respect_exact_knowledge(session);
    known
}

impl SequentialValues {
    fn after_step_1(
        biases: &[Bias],
        readings: Readings,
        errors: CarriedErrors,
        impossible: Option<Missing>,
    ) -> SequentialValues {
        let not_yet = || Err(Missing::new("not reached", ""));
        SequentialValues {
            sensors: biases
                .iter()
                .map(|bias| SensorValues {
                    torque_gain: not_yet(),
                    torque_bias: bias.torque_bias.clone(),
                    position_gain: bias.position_gain.clone(),
                    position_offset: not_yet(),
                })
                .collect(),
            gravity: Err(Missing::new("not reached", "")),
            largest_residuals: biases.iter().map(|b| b.largest_residual).collect(),
            iterations: biases.iter().map(|b| b.iterations).sum(),
            readings,
            impossible,
            noise_freedom: biases.iter().map(|b| b.degrees_of_freedom).collect(),
            errors,
        }
    }

    fn without_steps(session: &Session, plan: &Plan, readings: Readings) -> SequentialValues {
        let not_done = || Err(Missing::new("not reached", ""));
        let sensors = session.joints.iter().map(|_| SensorValues {
            torque_gain: not_done(),
            torque_bias: not_done(),
            position_gain: not_done(),
            position_offset: not_done(),
        });
        let mut known = SequentialValues {
            sensors: sensors.collect(),
            gravity: Err(Missing::new("not reached", "")),
            largest_residuals: vec![None; session.joints.len()],
            iterations: 0,
            readings,
            impossible: impossible(session, plan),
            noise_freedom: vec![0; session.joints.len()],
            errors: CarriedErrors::none(session.joints.len()),
        };
        known.respect_exact_knowledge(session);
        known
    }

    fn take_step_1(&mut self, values: &Unknowns) {
        let exact =
            |joint: usize, quantity: Quantity| Ok(Frozen { value: values.sensors[joint][quantity as usize], std: 0.0 });
        for (joint, sensor) in self.sensors.iter_mut().enumerate() {
            sensor.torque_bias = exact(joint, Quantity::TorqueBias);
            sensor.position_gain = exact(joint, Quantity::PositionGain);
        }
        self.errors = CarriedErrors::none(self.sensors.len());
    }

    /// How the noise of a joint's torque readings is known, which steps 2 and 3 are held against.
    fn noise_knowledge(&self, session: &Session, joint: usize) -> NoiseKnowledge {
        let found = session.noise_estimated()[joint] || self.readings.unexplained_found_of(session, joint);
        match (found, self.noise_freedom[joint]) {
            (false, _) => NoiseKnowledge::Stated,
            (true, 0) => NoiseKnowledge::Unknown,
            (true, freedom) => NoiseKnowledge::Found(freedom),
        }
    }

    /// What the session gives as exact is no result of a step.
    fn respect_exact_knowledge(&mut self, session: &Session) {
        for (joint, sensor) in self.sensors.iter_mut().enumerate() {
            for quantity in Quantity::ALL {
                if session.held_reason(joint, quantity).is_some() {
                    let exact = Ok(Frozen { value: session.joints[joint].of(quantity).nominal, std: 0.0 });
                    match quantity {
                        Quantity::TorqueGain => sensor.torque_gain = exact,
                        Quantity::TorqueBias => sensor.torque_bias = exact,
                        Quantity::PositionGain => sensor.position_gain = exact,
                        Quantity::PositionOffset => sensor.position_offset = exact,
                    }
                }
            }
        }
    }

    /// A start for the joint problem: what was found, the nominal values for the rest. `None` without gravity.
    pub fn as_start(&self, session: &Session) -> Option<Unknowns> {
        let mut start = Unknowns::nominal(session);
        start.gravity = self.gravity.as_ref().ok()?.vector;
        for (values, sensor) in start.sensors.iter_mut().zip(&self.sensors) {
            for quantity in Quantity::ALL {
                if let Ok(found) = sensor.of(quantity) {
                    values[quantity as usize] = found.value;
                }
            }
        }
        Some(start)
    }
}

/// Tells the steps' values. To judge them on the same footing as the joint estimator, the joint problem is solved
/// for what the steps leave out (masses, moments, placements, parameters not found) with their values held.
///
/// # Errors
/// Where that problem has no answer at all.
pub fn tell_steps(
    session: &Session,
    known: &SequentialValues,
    workbench: &Workbench<'_>,
) -> Result<EstimatorResult, EstimateError> {
    let Brief { verdict, termination, iterations, gravity, parameters } = tell_steps_briefly(session, known);
    let undetermined = tell_missing(session, known);
    let any = verdict != Verdict::Failed;
    let mut result = EstimatorResult {
        name: "sequential".into(),
        verdict,
        termination,
        iterations,
        trace: Vec::new(),
        gravity,
        covariance: tell_covariance(session, known),
        moments: Vec::new(),
        deflections: Vec::new(),
        position_errors: Vec::new(),
        sensor_models: Vec::new(),
        residual_tests: Vec::new(),
        undetermined,
        active_constraints: Vec::new(),
        weak: Vec::new(),
        held: Vec::new(),
        uncertainty: any.then(|| tell_uncertainty(session, &known.readings)),
        loss: None,
        outliers: Vec::new(),
        fit: None,
        notes: tell_notes(session, known),
        detail: Detail::default(),
        parameters,
    };
    if let Some(start) = known.as_start(session) {
        workbench.tell("judging the sequential values on all readings");
        let start = joint::start_around(session, &known.readings, &start)?;
        let mut posed = joint::pose(session, &known.readings, &start)?;
        let held = found_blocks(&posed, known);
        posed.problem = posed.problem.holding(&held, "found by the sequential steps");
        let solved = solve_posed(known.readings.clone(), posed, workbench)?;
        if !solved.estimate.termination.converged() {
            result.notes.push(format!("The fit below is no optimum: {}.", solved.estimate.termination));
        }
        let moments = determined_moments(
            &solved.posed.problem,
            &solved.estimate.values,
            &solved.posed.layout,
            &solved.spectrum,
            solved.covariance(),
            &[],
        );
        result.moments = moments.into_iter().map(|moment| moment.told).collect();
        result.detail.singular_values = solved.spectrum.singular_values().to_vec();
        result.fit = Some(joint::fit_with_held_out(session, &solved, workbench)?);
    }
    Ok(result)
}

/// The same of sensors and gravity alone, without judging it.
pub fn tell_steps_briefly(session: &Session, known: &SequentialValues) -> Brief {
    let parameters = tell_parameters(session, known);
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

fn tell_uncertainty(session: &Session, readings: &Readings) -> UncertaintyResult {
    let source = match session.noise_estimated().contains(&true) {
        true => NoiseSource::Residuals,
        false if readings.unexplained_found(session) => NoiseSource::StatedAndUnexplained,
        false => NoiseSource::Stated,
    };
    UncertaintyResult::Noise { source, widened_by: None }
}

fn found_blocks(posed: &joint::JointProblem, known: &SequentialValues) -> Vec<BlockId> {
    let sensors =
        posed.layout.sensors.iter().zip(&known.sensors).flat_map(|(ids, sensor)| {
            Quantity::ALL.into_iter().filter(|q| sensor.of(*q).is_ok()).map(|q| ids[q as usize])
        });
    // Whatever else sensors do, the steps take it as it is assumed.
    sensors.chain([posed.layout.gravity]).chain(posed.layout.further.iter().copied()).collect()
}

/// Gravity's covariance and the variances of what the steps found: between steps, and between the parameters of one
/// step, nothing is known to the sequential estimator, and zeros stand for it.
fn tell_covariance(session: &Session, known: &SequentialValues) -> CovarianceResult {
    let joints = session.robot.chain.joints().iter().zip(&known.sensors).enumerate();
    let found = joints.flat_map(|(index, (joint, sensor))| {
        Quantity::ALL.into_iter().filter_map(move |quantity| {
            let free = session.held_reason(index, quantity).is_none();
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

fn tell_parameters(session: &Session, known: &SequentialValues) -> Vec<ParameterResult> {
    let quantile = Quantile::normal();
    let tell = |id: ParameterId| {
        let mut told = session.blank_parameter(id);
        let ParameterId::Sensor(joint, quantity) = id else {
            told.determined = false;
            return told;
        };
        match known.sensors[joint].of(quantity) {
            Ok(found) if told.determined => {
                told.value = Some(found.value);
                told.std = Some(found.std);
                told.ci95 = Some(quantile.interval(found.value, found.std));
            }
            _ => told.determined = false,
        }
        told
    };
    session.parameters().into_iter().map(tell).collect()
}

/// What was not found, parameters with one and the same reason together.
fn tell_missing(session: &Session, known: &SequentialValues) -> Vec<Undetermined> {
    if let Some(missing) = &known.impossible {
        return vec![Undetermined {
            combination: "everything".into(),
            ..missing.clone().tell(vec!["everything".into()])
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
        for quantity in Quantity::ALL {
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
    let mut told: Vec<Undetermined> = reasons.into_iter().map(|(missing, names)| missing.tell(names)).collect();
    told.extend(joint::last_frame_choices(session));
    told
}

const ONLY_AFFINE: &str = "the sequential procedure knows only gains, biases and offsets of joint sensors";

fn tell_notes(session: &Session, known: &SequentialValues) -> Vec<String> {
    let mut notes = joint::session_notes(session);
    if known.impossible.is_some() {
        return notes;
    }
    notes.push(
        "Standard deviations are those of each step given the frozen results of the steps before it; the errors of \
         those results are not in them, and no covariance between steps is known."
            .into(),
    );
    let unheeded =
        [(!session.instruments.is_empty(), "instruments"), (session.earlier.is_some(), "earlier calibrations")];
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

#[cfg(test)]
mod tests;
