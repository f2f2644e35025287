//! The three steps, one after the other (paper, section 3.2).

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use super::bias::find_bias;
use super::carried::CarriedErrors;
use super::gain::{Gain, find_gain};
use super::gravity::find_gravity;
use super::values::{Gravity, SequentialValues, impossible};
use crate::joint::{self, MeasurementSet, Signals, State};
use crate::plan::Plan;

/// Results that steps are handed instead of those of the steps before: to learn which step's errors reach what.
#[derive(Clone, Copy, Debug, Default)]
pub struct Handed<'a> {
    /// Torque biases and position gains instead of those of step 1.
    pub step_1: Option<&'a State>,
    /// Gravity in base coordinates, m/s², instead of that of step 2.
    pub gravity: Option<[f64; 3]>,
}

/// Runs the paper's procedure.
pub fn run_steps(session: &Session, plan: &Plan, environment: &SolveEnvironment<'_>) -> SequentialValues {
    run_steps_handed(session, plan, Handed::default(), environment)
}

/// The same with some results handed in.
pub fn run_steps_handed(
    session: &Session,
    plan: &Plan,
    handed: Handed<'_>,
    environment: &SolveEnvironment<'_>,
) -> SequentialValues {
    let joints = 0..session.joints.len();
    let mut readings = joint::select(session, Signals::All);
    if !session.robot.chain.is_serial() {
        return SequentialValues::without_steps(session, plan, readings);
    }

    environment.report("step 1: torque biases and position gains");
    let mut errors = CarriedErrors::none(session.joints.len());
    let mut biases = Vec::new();
    for joint in joints.clone() {
        let mut find = |readings: &MeasurementSet| find_bias(session, plan, readings, joint, &mut errors, environment);
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

    environment.report("step 2: gravity");
    let mut errors = known.errors.clone();
    known.gravity = find_gravity(session, plan, &known, &mut errors, environment);
    known.iterations += known.gravity.as_ref().map_or(0, |g| g.iterations);
    if let Some(vector) = handed.gravity {
        known.gravity = Ok(Gravity { vector, covariance: vec![0.0; 9], assumed: None, iterations: 0 });
        errors.forget(errors.gravity());
    }
    known.errors = errors;

    environment.report("step 3: torque gains and position offsets");
    for joint in joints {
        let mut errors = known.errors.clone();
        let Gain { torque_gain, position_offset, iterations } =
            find_gain(session, plan, &known, joint, &mut errors, environment);
        known.errors = errors;
        known.sensors[joint].torque_gain = torque_gain;
        known.sensors[joint].position_offset = position_offset;
        known.iterations += iterations;
    }
    known.respect_exact_knowledge(session);
    known
}
