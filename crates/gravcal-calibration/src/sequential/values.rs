//! What the steps found.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use super::bias::Bias;
use super::carried::CarriedErrors;
use super::contradiction::NoiseScale;
use super::found::{Found, Frozen, Missing};
use crate::joint::{MeasurementSet, State};
use crate::plan::Plan;

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
    pub fn of(&self, quantity: SensorParameter) -> &Found {
        match quantity {
            SensorParameter::TorqueGain => &self.torque_gain,
            SensorParameter::TorqueBias => &self.torque_bias,
            SensorParameter::PositionGain => &self.position_gain,
            SensorParameter::PositionOffset => &self.position_offset,
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
    pub readings: MeasurementSet,
    /// Why there is nothing that the steps could do.
    pub impossible: Option<Missing>,
    /// Degrees of freedom of the residuals of step 1 by joint, none where it had no sweep.
    noise_freedom: Vec<usize>,
    pub(super) errors: CarriedErrors,
}

impl SequentialValues {
    pub(super) fn after_step_1(
        biases: &[Bias],
        readings: MeasurementSet,
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

    pub(super) fn without_steps(session: &Session, plan: &Plan, readings: MeasurementSet) -> SequentialValues {
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

    pub(super) fn take_step_1(&mut self, values: &State) {
        let exact = |joint: usize, quantity: SensorParameter| {
            Ok(Frozen { value: values.sensors[joint][quantity as usize], std: 0.0 })
        };
        for (joint, sensor) in self.sensors.iter_mut().enumerate() {
            sensor.torque_bias = exact(joint, SensorParameter::TorqueBias);
            sensor.position_gain = exact(joint, SensorParameter::PositionGain);
        }
        self.errors = CarriedErrors::none(self.sensors.len());
    }

    /// How the noise of a joint's torque readings is known, which steps 2 and 3 are held against.
    pub(super) fn noise_scale(&self, session: &Session, joint: usize) -> NoiseScale {
        let found = session.noise_estimated()[joint] || self.readings.unexplained_found_of(session, joint);
        match (found, self.noise_freedom[joint]) {
            (false, _) => NoiseScale::Stated,
            (true, 0) => NoiseScale::Unknown,
            (true, freedom) => NoiseScale::Found(freedom),
        }
    }

    /// What the session gives as exact is no result of a step.
    pub(super) fn respect_exact_knowledge(&mut self, session: &Session) {
        for (joint, sensor) in self.sensors.iter_mut().enumerate() {
            for quantity in SensorParameter::ALL {
                if session.fixed_reason(joint, quantity).is_some() {
                    let exact = Ok(Frozen { value: session.joints[joint].of(quantity).nominal, std: 0.0 });
                    match quantity {
                        SensorParameter::TorqueGain => sensor.torque_gain = exact,
                        SensorParameter::TorqueBias => sensor.torque_bias = exact,
                        SensorParameter::PositionGain => sensor.position_gain = exact,
                        SensorParameter::PositionOffset => sensor.position_offset = exact,
                    }
                }
            }
        }
    }

    /// A start for the joint problem: what was found, the nominal values for the rest. `None` without gravity.
    pub fn as_start(&self, session: &Session) -> Option<State> {
        let mut start = State::nominal(session);
        start.gravity = self.gravity.as_ref().ok()?.vector;
        for (values, sensor) in start.sensors.iter_mut().zip(&self.sensors) {
            for quantity in SensorParameter::ALL {
                if let Ok(found) = sensor.of(quantity) {
                    values[quantity as usize] = found.value;
                }
            }
        }
        Some(start)
    }
}

/// Why the steps have nothing to do, if they have not.
pub(super) fn impossible(session: &Session, plan: &Plan) -> Option<Missing> {
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

/// Gravity as step 2 found it.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// Base coordinates, m/s².
    pub vector: [f64; 3],
    /// Its covariance, 3 × 3, row-major, conditional on step 1.
    pub covariance: Vec<f64>,
    /// What had to be taken at its nominal value, in words.
    pub assumed: Option<String>,
    /// Solver iterations.
    pub iterations: usize,
}
