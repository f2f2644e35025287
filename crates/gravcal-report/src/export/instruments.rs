//! Gains and biases of instruments: wrist sensors and accelerometers.
//!
//! ```text
//!     reading = K sensed + b          sensed = K⁻¹ (reading − b)
//! ```
//!
//! What a wrist sensor senses is the force and the moment that its link exerts on what hangs beyond it, in the sensor's frame; of
//! an accelerometer at rest it is gravity's opposite. Axes that are not read are left out.

use gravcal_recording::EarlierEstimate;
use gravcal_robot_model::parameter::UNREAD;
use gravcal_robot_model::session::AuxiliarySensorKind;
use nalgebra::DMatrix;

use super::corrections::Taken;
use super::{ExportError, ExportFormat};
use crate::sensor_row::split_name;

/// What of an instrument is no matter of gain and bias, and therefore in the tables only.
const ELSEWHERE: [&str; 2] = ["tool_", "mounting_"];

/// One instrument.
#[derive(Debug)]
pub(super) struct InstrumentCorrection {
    pub name: String,
    /// Names of the axes that are read.
    pub axes: Vec<&'static str>,
    /// `K`, row by row: of a reading by what is sensed.
    pub gain: Vec<Vec<f64>>,
    /// `K⁻¹`.
    pub inverse_gain: Vec<Vec<f64>>,
    /// `b`.
    pub bias: Vec<f64>,
    /// Of each reading.
    pub reading_units: Vec<String>,
    /// Of what is sensed.
    pub units: Vec<&'static str>,
}

impl InstrumentCorrection {
    /// `−K⁻¹ b`.
    pub fn inverse_bias(&self) -> Vec<f64> {
        let row = |row: &Vec<f64>| -row.iter().zip(&self.bias).map(|(gain, bias)| gain * bias).sum::<f64>();
        self.inverse_gain.iter().map(row).collect()
    }
}

/// All instruments of a calibration, in its order.
pub(super) fn instruments(
    estimate: &EarlierEstimate,
    taken: &mut Taken<'_>,
    format: ExportFormat,
) -> Result<Vec<InstrumentCorrection>, ExportError> {
    let mut found: Vec<InstrumentCorrection> = Vec::new();
    for parameter in &estimate.parameters {
        let (owner, quantity) = split_name(&parameter.name);
        if found.iter().all(|other| other.name != owner)
            && let Some(kind) = kind(quantity)
        {
            let instrument = Named { estimate, owner, kind };
            instrument.refuse_more(format)?;
            found.push(instrument.correction(taken)?);
        }
    }
    Ok(found)
}

/// What it is of which this quantity is told first: the gain of its first axis.
fn kind(quantity: &str) -> Option<AuxiliarySensorKind> {
    let first = |kind: &AuxiliarySensorKind| quantity == format!("gain_{}", kind.axes()[0]);
    [AuxiliarySensorKind::ForceTorque, AuxiliarySensorKind::Accelerometer].into_iter().find(first)
}

struct Named<'a> {
    estimate: &'a EarlierEstimate,
    owner: &'a str,
    kind: AuxiliarySensorKind,
}

impl Named<'_> {
    fn name(&self, quantity: &str) -> String {
        format!("{}.{quantity}", self.owner)
    }

    /// Parameters that add to a reading besides gain and bias: a drift, a bias of each table.
    fn refuse_more(&self, format: ExportFormat) -> Result<(), ExportError> {
        let axes = self.kind.axes();
        let affine = |quantity: &str| match quantity.split_once('_') {
            Some(("bias", axis)) => axes.contains(&axis),
            Some(("gain", axis)) => match axis.split_once('_') {
                None => axes.contains(&axis),
                Some((reading, sensed)) => axes.contains(&reading) && axes.contains(&sensed),
            },
            _ => ELSEWHERE.iter().any(|elsewhere| quantity.starts_with(elsewhere)),
        };
        let own = self.estimate.parameters.iter().filter(|parameter| split_name(&parameter.name).0 == self.owner);
        let more = own.filter(|parameter| !affine(split_name(&parameter.name).1));
        let names: Vec<String> =
            more.filter(|p| p.held.is_none() || p.value.unwrap_or(p.nominal) != 0.0).map(|p| p.name.clone()).collect();
        if names.is_empty() { Ok(()) } else { Err(ExportError::BeyondAffine { format, names }) }
    }

    fn correction(&self, taken: &mut Taken<'_>) -> Result<InstrumentCorrection, ExportError> {
        let all = self.kind.axes();
        let read = |axis: &usize| {
            let gain = taken.parameter(&self.name(&format!("gain_{}", all[*axis])));
            gain.is_some_and(|gain| gain.held.as_deref() != Some(UNREAD))
        };
        let axes: Vec<usize> = (0..all.len()).filter(read).collect();
        let mut gain = vec![vec![0.0; axes.len()]; axes.len()];
        for (row, reading) in axes.iter().enumerate() {
            for (sensed, name) in all.iter().enumerate() {
                let quantity = match *reading == sensed {
                    true => format!("gain_{name}"),
                    false => format!("gain_{}_{name}", all[*reading]),
                };
                let Some(parameter) = taken.parameter(&self.name(&quantity)) else { continue };
                match axes.iter().position(|axis| *axis == sensed) {
                    Some(column) => gain[row][column] = taken.value(parameter),
                    // What is sensed along an axis that is not read cannot be taken off the others.
                    None => {
                        let (name, axis) = (self.owner.to_owned(), (*name).to_owned());
                        return Err(ExportError::UnreadAxis { name, axis });
                    }
                }
            }
        }
        let (mut bias, mut reading_units) = (Vec::new(), Vec::new());
        for axis in &axes {
            let name = self.name(&format!("bias_{}", all[*axis]));
            match taken.parameter(&name) {
                Some(parameter) => {
                    bias.push(taken.value(parameter));
                    reading_units.push(parameter.unit.clone());
                }
                None => taken.missing.push(name),
            }
        }
        Ok(InstrumentCorrection {
            name: self.owner.to_owned(),
            axes: axes.iter().map(|axis| all[*axis]).collect(),
            inverse_gain: inverse(&gain).ok_or_else(|| ExportError::ZeroGain { name: self.name("gain") })?,
            gain,
            bias,
            reading_units,
            units: axes.iter().map(|axis| self.kind.sensed_unit(*axis).trim_matches(['(', ')'])).collect(),
        })
    }
}

/// `None` of a matrix that has none.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    let inverse = DMatrix::from_fn(n, n, |i, j| matrix[i][j]).lu().try_inverse()?;
    Some((0..n).map(|i| (0..n).map(|j| inverse[(i, j)]).collect()).collect())
}
