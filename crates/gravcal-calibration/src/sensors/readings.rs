//! From readings to true values and back, for given parameters.

use gravcal_recording::Conditions;

use super::terms::SensorTerms;
use crate::joint::Unknowns;
use crate::parameter::Quantity;

/// Steps of Newton's method at most, and the relative size of the last one.
const ITERATIONS: usize = 50;
const TOLERANCE: f64 = 1e-14;

impl SensorTerms {
    /// True coordinates of all joints at these position readings: `θ = s q + o + Σ a ψ(q)`, rad or m.
    pub fn coordinates(&self, readings: &[f64], values: &Unknowns) -> Vec<f64> {
        let affine = readings.iter().zip(&values.sensors).map(|(q, [_, _, s, o])| s * q + o);
        let mut coordinates: Vec<f64> = affine.collect();
        for (place, joint, function) in self.of_positions() {
            coordinates[joint] += values.further[place] * function.value(readings[joint]);
        }
        coordinates
    }

    /// What the torque sensors of all joints read at these torques: `y = k τ + b + Σ a φ(τ, conditions)`.
    pub fn torque_readings(&self, torque: &[f64], conditions: &Conditions, values: &Unknowns) -> Vec<f64> {
        let affine = torque.iter().zip(&values.sensors).map(|(torque, [k, b, _, _])| k * torque + b);
        let mut readings: Vec<f64> = affine.collect();
        for (joint, reading) in readings.iter_mut().enumerate() {
            for (place, function) in self.of_torque(joint) {
                let source = function.source().map_or(0.0, |source| torque[source]);
                *reading += values.further[place] * function.value(source, conditions);
            }
        }
        readings
    }

    /// The true torques of all joints behind these readings, by Newton's method from those of affine sensors. `None`
    /// where sensors saturate each other or their own terms so that it does not converge.
    pub fn torques(&self, readings: &[f64], conditions: &Conditions, values: &Unknowns) -> Option<Vec<f64>> {
        let affine = readings.iter().zip(&values.sensors).map(|(reading, [k, b, _, _])| (reading - b) / k);
        let mut torque = nalgebra::DVector::from_iterator(readings.len(), affine);
        let scale = torque.amax().max(1.0);
        for _ in 0..ITERATIONS {
            let mut slopes = nalgebra::DMatrix::zeros(readings.len(), readings.len());
            for (joint, sensor) in values.sensors.iter().enumerate() {
                slopes[(joint, joint)] = sensor[Quantity::TorqueGain as usize];
                for (place, function) in self.of_torque(joint) {
                    if let Some(source) = function.source() {
                        slopes[(joint, source)] += values.further[place] * function.slope(torque[source]);
                    }
                }
            }
            let found = self.torque_readings(torque.as_slice(), conditions, values);
            let missing =
                nalgebra::DVector::from_iterator(readings.len(), readings.iter().zip(found).map(|(r, f)| r - f));
            let step = slopes.lu().solve(&missing)?;
            torque += &step;
            if step.amax() <= TOLERANCE * scale {
                return Some(torque.as_slice().to_vec());
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use gravcal_recording::Conditions;

    use crate::joint::Unknowns;
    use crate::sensors::testing::every_term;
    use crate::testing::sarcos_shoulder;

    /// Torques behind the readings of sensors that do everything a model knows, full cross-talk and cubes included.
    #[test]
    fn torques_come_back_from_their_readings() {
        let terms = every_term();
        let further = (0..terms.len()).map(|k| 1e-3 * (1.0 + k as f64).sin()).collect();
        let values = Unknowns { further, ..sarcos_shoulder().truth };
        let conditions = Conditions {
            time: Some(3600.0),
            temperature: vec![31.0; 3],
            velocity: vec![0.1, -0.2, 0.3],
            acceleration: Vec::new(),
            direction: vec![1.0, -1.0, 1.0],
        };
        for torque in [[0.0; 3], [12.0, -30.0, 7.0], [-25.0, 18.0, -9.0]] {
            let readings = terms.torque_readings(&torque, &conditions, &values);
            let found = terms.torques(&readings, &conditions, &values).unwrap();
            let close = found.iter().zip(&torque).all(|(found, torque)| (found - torque).abs() < 1e-10);
            assert!(close, "{found:?} {torque:?}");
        }
    }

    #[test]
    fn readings_that_no_torque_explains_have_none() {
        let terms = every_term();
        let mut values = Unknowns { further: vec![0.0; terms.len()], ..sarcos_shoulder().truth };
        values.sensors[1][0] = 0.0;
        assert_eq!(terms.torques(&[2000.0; 3], &Conditions::default(), &values), None);
    }
}
