//! Torques that the model predicts, of which columns of terms are made: errors of a reading are in its residual, too.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::Solved;

/// Torques as their sensors read them, without biases.
pub struct PredictedTorques {
    /// By pose and joint, gain times torque, unit of the reading; zero where the joint is not read.
    readings: Vec<Vec<f64>>,
    /// By joint.
    gains: Vec<f64>,
    /// The largest reading of each joint.
    largest: Vec<f64>,
}

impl PredictedTorques {
    /// # Errors
    /// Where a residual cannot be evaluated without gains.
    pub fn new(session: &Session, solved: &Solved) -> Result<PredictedTorques, EvaluateError> {
        let joints = session.joints.len();
        let (mut readings, mut largest) = (vec![vec![0.0; joints]; session.poses.len()], vec![0.0; joints]);
        for (ReadingId { pose, channel }, reading) in solved.built.rows.iter().zip(solved.gravity_readings(session)?) {
            if *channel < joints {
                readings[*pose][*channel] = reading;
                largest[*channel] = f64::max(largest[*channel], reading.abs());
            }
        }
        let gain = |joint: usize| solved.built.variables.sensors[joint][SensorParameter::TorqueGain as usize];
        let gains = (0..joints).map(|joint| solved.estimate.values.scalar(gain(joint))).collect();
        Ok(PredictedTorques { readings, gains, largest })
    }

    /// Gain times torque, unit of the reading.
    pub fn reading(&self, pose: usize, joint: usize) -> f64 {
        self.readings[pose][joint]
    }

    /// The torque, N·m.
    pub fn torque(&self, pose: usize, joint: usize) -> f64 {
        if self.gains[joint] == 0.0 { 0.0 } else { self.readings[pose][joint] / self.gains[joint] }
    }

    /// A power of the reading in its share of the largest.
    pub fn power(&self, pose: usize, joint: usize, power: i32) -> f64 {
        if self.largest[joint] == 0.0 { 0.0 } else { (self.readings[pose][joint] / self.largest[joint]).powi(power) }
    }

    /// Of the coefficients of [`others`](Self::others), that of the joint whose torque shows most, and the joint.
    pub fn shows_most(&self, joint: usize, coefficients: &[f64]) -> Option<(usize, f64)> {
        let shows =
            |(other, coefficient): &(usize, f64)| (coefficient * self.largest[*other] / self.gains[*other]).abs();
        let others = self.others(joint).into_iter().zip(coefficients.iter().copied());
        others.max_by(|a, b| shows(a).total_cmp(&shows(b)))
    }

    /// Joints whose torque is known at any pose, but one.
    pub fn others(&self, joint: usize) -> Vec<usize> {
        (0..self.largest.len()).filter(|other| *other != joint && self.largest[*other] > 0.0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wrist of hardly any torque has the largest coefficient, which is noise; the gain of the last one is 10.
    #[test]
    fn the_joint_that_shows_most_is_not_the_one_of_the_largest_coefficient() {
        let predicted = PredictedTorques {
            readings: Vec::new(),
            gains: vec![1.0, 1.0, 1.0, 10.0],
            largest: vec![50.0, 20.0, 0.1, 20.0],
        };
        assert_eq!(predicted.shows_most(0, &[0.01, -0.5, 0.02]), Some((1, 0.01)));
        assert_eq!(predicted.shows_most(1, &[0.001, -0.5, -0.03]), Some((3, -0.03)));
    }
}
