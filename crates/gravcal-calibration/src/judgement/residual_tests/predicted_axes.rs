//! Readings of instruments that the model predicts, less their means, of which columns of terms are made: errors of a reading are in its residual, too, and
//! biases are unknowns.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::session::{AuxiliarySensor, Session};

use crate::joint::Solved;

/// Readings of the axes of instruments.
pub struct PredictedAxes {
    /// How many channels come before those of instruments.
    joints: usize,
    /// By axis and pose, less its mean, unit of the reading; zero where it is not read.
    readings: Vec<Vec<f64>>,
    /// The largest of each axis.
    largest: Vec<f64>,
    /// The instrument of each axis.
    instruments: Vec<usize>,
}

impl PredictedAxes {
    /// # Errors
    /// Where a residual cannot be evaluated at the solution.
    pub fn new(session: &Session, solved: &Solved) -> Result<PredictedAxes, EvaluateError> {
        let joints = session.joints.len();
        let axes = session.channel_count() - joints;
        let (mut readings, mut counts) = (vec![vec![0.0; session.poses.len()]; axes], vec![0.0; axes]);
        let whitened = solved.built.problem.residuals(&solved.estimate.values)?;
        let rows = || solved.built.rows.iter().zip(&whitened).filter(|(id, _)| id.channel >= joints);
        for (id, residual) in rows() {
            let read = session.reading(*id).map_or(0.0, |reading| reading.value);
            readings[id.channel - joints][id.pose] = read + residual * solved.readings().std(session, *id);
            counts[id.channel - joints] += 1.0;
        }
        let means: Vec<f64> =
            readings.iter().zip(counts).map(|(own, count)| own.iter().sum::<f64>() / f64::max(count, 1.0)).collect();
        rows().for_each(|(id, _)| readings[id.channel - joints][id.pose] -= means[id.channel - joints]);
        let largest = readings.iter().map(|own| own.iter().fold(0.0, |most: f64, one| most.max(one.abs()))).collect();
        let of_axis = |(place, instrument): (usize, &AuxiliarySensor)| vec![place; instrument.kind.axes().len()];
        let instruments = session.instruments.iter().enumerate().flat_map(of_axis).collect();
        Ok(PredictedAxes { joints, readings, largest, instruments })
    }

    /// What an axis reads.
    pub fn reading(&self, pose: usize, channel: usize) -> f64 {
        self.readings[channel - self.joints][pose]
    }

    /// A power of it in its share of the largest.
    pub fn power(&self, pose: usize, channel: usize, power: i32) -> f64 {
        match self.largest[channel - self.joints] {
            0.0 => 0.0,
            largest => (self.reading(pose, channel) / largest).powi(power),
        }
    }

    /// The other axes of the same instrument that read anything.
    pub fn others(&self, channel: usize) -> Vec<usize> {
        let own = channel - self.joints;
        let other = |axis: &usize| {
            *axis != own && self.instruments[*axis] == self.instruments[own] && self.largest[*axis] > 0.0
        };
        (0..self.largest.len()).filter(other).map(|axis| self.joints + axis).collect()
    }

    /// Of coefficients of these that of the axis which shows most, and the axis.
    pub fn shows_most(&self, channel: usize, coefficients: &[f64]) -> Option<(usize, f64)> {
        let shows = |(other, coefficient): &(usize, f64)| (coefficient * self.largest[other - self.joints]).abs();
        let others = self.others(channel).into_iter().zip(coefficients.iter().copied());
        others.max_by(|a, b| shows(a).total_cmp(&shows(b)))
    }
}
