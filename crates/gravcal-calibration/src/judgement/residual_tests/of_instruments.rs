//! What goes with what an instrument senses: a reading that shows what its other axes sense, as one does that is mounted otherwise than stated, and one that
//! is not proportional to what it senses.
//!
//! Columns are of the readings that the model predicts, less their means: errors of a reading are in its residual, too, and biases are unknowns.

use gravcal_estimation::EvaluateError;
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, Session};

use crate::joint::Solved;
use crate::result::{ResidualTest, ResidualTestKind};

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

/// What a test says of an axis, and what to do; nothing of a joint.
pub fn of_axis(session: &Session, test: &ResidualTest) -> Option<(String, String)> {
    let ResidualTest { channel, unit, .. } = test;
    let place = (session.joints.len()..session.channel_count()).find(|one| session.channel_name(*one) == *channel)?;
    let (instrument, _) = session.axis(place)?;
    let size = significant(test.size, 2);
    let known = match session.instruments[instrument].kind {
        AuxiliarySensorKind::Accelerometer => ", or say how well its mounting is known (mounting_std_deg)",
        AuxiliarySensorKind::ForceTorque => "",
    };
    match &test.kind {
        ResidualTestKind::Crosstalk { joint } => Some((
            format!("The reading of {channel} goes with what other axes sense, most with {joint}: {size} {unit}."),
            format!(
                "Measure the instrument's mounting (mounting.rpy_deg){known}; or let each axis have a gain for what each other one senses (gains = \"matrix\")."
            ),
        )),
        ResidualTestKind::TorqueNonlinearity => Some((
            format!(
                "The reading of {channel} is not proportional to what it senses: it is off by about {size} {unit} at the largest."
            ),
            "If it is at an end of its range, say where that is (lowest, highest in its readings); else use it where it is straight, or correct its readings before."
                .into(),
        )),
        _ => None,
    }
}
