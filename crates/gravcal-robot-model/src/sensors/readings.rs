//! From readings to true values and back, for given parameters.

use gravcal_recording::Conditions;
use nalgebra::{DMatrix, DVector};

use super::term::{Moment, Partials};
use super::terms::SensorTerms;
use crate::parameter::SensorParameter;
use crate::state::State;

/// Steps of Newton's method at most, and the relative size of the last one.
const ITERATIONS: usize = 50;
const TOLERANCE: f64 = 1e-14;

impl SensorTerms {
    /// True coordinates of all joints at these position readings: `θ = s q + o + Σ f(q, conditions)`, rad or m.
    pub fn coordinates(&self, readings: &[f64], conditions: &Conditions, values: &State) -> Vec<f64> {
        let affine = readings.iter().zip(&values.sensors).map(|(q, [_, _, s, o])| s * q + o);
        let mut coordinates: Vec<f64> = affine.collect();
        let at = Moment::new(&[], &[], readings, conditions);
        for term in self.of_positions() {
            coordinates[term.joint] += term.value(&at, &values.further, None);
        }
        coordinates
    }

    /// What the torque sensors of all joints read at this moment: `y = k τ + b + Σ f(τ, θ, q, conditions)`.
    pub fn torque_readings(&self, at: &Moment<'_>, values: &State) -> Vec<f64> {
        let affine = values.sensors.iter().enumerate().map(|(joint, [k, b, _, _])| k * at.torque(joint) + b);
        let mut readings: Vec<f64> = affine.collect();
        for (joint, reading) in readings.iter_mut().enumerate() {
            for term in self.of_torque(joint) {
                *reading += term.value(at, &values.further, None);
            }
        }
        readings
    }

    /// The true torques of all joints behind these readings, by Newton's method from those of affine sensors. `at`: the moment; its
    /// torques do not matter. `None` where sensors saturate each other or their own terms so that it does not converge.
    pub fn torques(&self, readings: &[f64], at: &Moment<'_>, values: &State) -> Option<Vec<f64>> {
        let affine = readings.iter().zip(&values.sensors).map(|(reading, [k, b, _, _])| (reading - b) / k);
        let mut torque = DVector::from_iterator(readings.len(), affine);
        let scale = torque.amax().max(1.0);
        for _ in 0..ITERATIONS {
            let found = torque.as_slice().to_vec();
            let at = at.with_torque(&found);
            let reported = self.torque_readings(&at, values);
            let missing = DVector::from_iterator(readings.len(), readings.iter().zip(reported).map(|(r, f)| r - f));
            let step = self.slopes(&at, values).lu().solve(&missing)?;
            torque += &step;
            if step.amax() <= TOLERANCE * scale {
                return Some(torque.as_slice().to_vec());
            }
        }
        None
    }

    /// Derivatives of all readings by all torques.
    fn slopes(&self, at: &Moment<'_>, values: &State) -> DMatrix<f64> {
        let joints = values.sensors.len();
        let mut slopes = DMatrix::zeros(joints, joints);
        for (joint, sensor) in values.sensors.iter().enumerate() {
            slopes[(joint, joint)] = sensor[SensorParameter::TorqueGain as usize];
            for term in self.of_torque(joint) {
                let [mut by_parameter, mut by_torque, mut by_coordinate] =
                    [term.places.len(), joints, joints].map(|count| vec![0.0; count]);
                let partials = Partials {
                    by_parameter: &mut by_parameter,
                    by_torque: &mut by_torque,
                    by_coordinate: &mut by_coordinate,
                };
                term.value(at, &values.further, Some(partials));
                term.reads.torques().iter().for_each(|source| slopes[(joint, *source)] += by_torque[*source]);
            }
        }
        slopes
    }
}

#[cfg(test)]
mod tests {
    use gravcal_recording::Conditions;

    use crate::sensors::Moment;
    use crate::sensors::testing::every_term;
    use crate::state::State;

    /// Three joints, whose terms have these parameters.
    fn values(further: Vec<f64>) -> State {
        State {
            gravity: [0.0, 0.0, -9.8],
            sensors: vec![[7.12, 2075.0, 0.988, 0.0], [5.97, 2008.0, 0.995, 2.342], [6.5, 2050.0, 1.01, 0.2]],
            further,
            inertia: Vec::new(),
            tensors: Vec::new(),
            with_payloads: Vec::new(),
            sweep_moments: Vec::new(),
            loads: Vec::new(),
            deflections: Vec::new(),
            static_friction: Vec::new(),
            at_rest: Vec::new(),
            growing_friction: Vec::new(),
            bending: Vec::new(),
            lengths: Vec::new(),
            axes: Vec::new(),
        }
    }

    /// Torques behind the readings of sensors that do everything a model knows, full cross-talk and cubes included.
    #[test]
    fn torques_come_back_from_their_readings() {
        let terms = every_term();
        let values = values((0..terms.len()).map(|k| 1e-3 * (1.0 + k as f64).sin()).collect());
        let conditions = Conditions {
            time: Some(3600.0),
            temperature: vec![31.0; 3],
            velocity: vec![0.1, -0.2, 0.3],
            acceleration: Vec::new(),
            direction: vec![1.0, -1.0, 1.0],
            presliding: Vec::new(),
            further: Vec::new(),
        };
        for torque in [[0.0; 3], [12.0, -30.0, 7.0], [-25.0, 18.0, -9.0]] {
            let at = Moment::new(&torque, &[0.1, 0.2, 0.3], &[0.3, 0.2, 0.1], &conditions);
            let readings = terms.torque_readings(&at, &values);
            let found = terms.torques(&readings, &at, &values).unwrap();
            let close = found.iter().zip(&torque).all(|(found, torque)| (found - torque).abs() < 1e-10);
            assert!(close, "{found:?} {torque:?}");
        }
    }

    #[test]
    fn readings_that_no_torque_explains_have_none() {
        let terms = every_term();
        let mut values = values(vec![0.0; terms.len()]);
        values.sensors[1][0] = 0.0;
        let conditions = Conditions::default();
        let at = Moment::new(&[0.0; 3], &[0.0; 3], &[0.0; 3], &conditions);
        assert_eq!(terms.torques(&[2000.0; 3], &at, &values), None);
    }
}
