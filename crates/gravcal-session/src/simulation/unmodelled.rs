//! What simulated sensors do besides, and no session says: drifts, harmonics and whatever else a sensor model knows.

use gravcal_recording::Conditions;
use gravcal_robot_model::State;
use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::sensors::{Moment, SensorTerms, Term};
use gravcal_robot_model::session::Session;

use super::experiment::Simulation;

/// Terms beyond those of the session, with their true values.
#[derive(Clone, Debug)]
pub struct Unmodelled {
    terms: SensorTerms,
    /// Those of the terms; gains, biases and offsets are zero, so that the terms alone are left.
    values: State,
    parameters: Vec<Parameter>,
}

impl Unmodelled {
    pub(super) fn none(template: &Session) -> Unmodelled {
        let sensors = vec![[0.0; 4]; template.joints.len()];
        let values = State { sensors, further: Vec::new(), ..State::nominal(template) };
        Unmodelled { terms: SensorTerms::default(), values, parameters: Vec::new() }
    }

    pub(super) fn add(&mut self, term: Term, parameters: Vec<Parameter>, values: Vec<f64>) {
        self.terms.extend([term]);
        self.values.further.extend(values);
        self.parameters.extend(parameters);
    }

    /// Its parameters with their true values.
    pub(super) fn parameters(&self) -> impl Iterator<Item = (&Parameter, f64)> {
        self.parameters.iter().zip(self.values.further.iter().copied())
    }
}

impl Simulation {
    /// True coordinates of all joints at these position readings, rad or m.
    pub(super) fn coordinates(&self, readings: &[f64], conditions: &Conditions) -> Vec<f64> {
        let mut coordinates = self.template.terms.coordinates(readings, conditions, &self.truth);
        if !self.unmodelled.terms.is_empty() {
            let more = self.unmodelled.terms.coordinates(readings, conditions, &self.unmodelled.values);
            coordinates.iter_mut().zip(more).for_each(|(coordinate, more)| *coordinate += more);
        }
        coordinates
    }

    /// What the torque sensors of all joints read at this moment.
    pub(super) fn torque_readings(&self, at: &Moment<'_>) -> Vec<f64> {
        let mut readings = self.template.terms.torque_readings(at, &self.truth);
        if !self.unmodelled.terms.is_empty() {
            let more = self.unmodelled.terms.torque_readings(at, &self.unmodelled.values);
            readings.iter_mut().zip(more).for_each(|(reading, more)| *reading += more);
        }
        readings
    }
}
