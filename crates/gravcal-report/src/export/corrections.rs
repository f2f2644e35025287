//! Gain and bias of each joint's sensors, for formats that know nothing else.

use gravcal_recording::{EarlierEstimate, EarlierParameter};
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::NO_TORQUE_SENSOR;

use super::instruments::{InstrumentCorrection, instruments};
use super::{ExportError, ExportFormat};
use crate::sensor_row::{is_friction, split_name};

/// What turns the readings of all joints into what they truly say.
#[derive(Debug)]
pub(super) struct Corrections {
    pub joints: Vec<JointCorrection>,
    /// None for a format that has no place for them.
    pub instruments: Vec<InstrumentCorrection>,
    /// In base coordinates, m/s², where it is determined.
    pub gravity: Option<[f64; 3]>,
    /// What is not as the data determine it, or left out.
    pub remarks: Vec<String>,
}

/// One joint.
#[derive(Debug)]
pub(super) struct JointCorrection {
    pub name: String,
    /// `reading = gain · torque + bias`; `None` without a torque sensor.
    pub torque: Option<Torque>,
    /// `coordinate = gain · reading + offset`.
    pub position: Position,
}

#[derive(Debug)]
pub(super) struct Torque {
    pub gain: f64,
    pub bias: f64,
    /// Of the reading.
    pub reading_unit: String,
    /// Of the torque.
    pub unit: String,
}

#[derive(Debug)]
pub(super) struct Position {
    pub gain: f64,
    pub offset: f64,
    /// Of the reading.
    pub reading_unit: String,
    /// Of the coordinate.
    pub unit: String,
}

impl Corrections {
    pub fn new(estimate: &EarlierEstimate, nominal: bool, format: ExportFormat) -> Result<Corrections, ExportError> {
        let torques = !format.is_robot();
        let mut taken =
            Taken { estimate, nominal, torques, undetermined: Vec::new(), missing: Vec::new(), remarks: Vec::new() };
        let names = joint_names(estimate);
        refuse_more(estimate, &names, format)?;
        taken.remarks.extend(friction_left_out(estimate, &names, format));
        let joints: Vec<JointCorrection> = names.iter().filter_map(|name| taken.joint(name)).collect();
        let instruments = if format.is_robot() { Vec::new() } else { instruments(estimate, &mut taken, format)? };
        let Taken { undetermined, missing, mut remarks, .. } = taken;
        if !missing.is_empty() {
            return Err(ExportError::Missing { names: missing });
        }
        if !undetermined.is_empty() {
            return Err(ExportError::Undetermined { names: undetermined });
        }
        for joint in &joints {
            let torque = joint.torque.iter().map(|torque| (torque.gain, SensorParameter::TorqueGain));
            if let Some((_, quantity)) =
                torque.chain([(joint.position.gain, SensorParameter::PositionGain)]).find(|(gain, _)| *gain == 0.0)
            {
                return Err(ExportError::ZeroGain { name: quantity.name(&joint.name) });
            }
        }
        if estimate.gravity.is_none() {
            remarks.push("gravity is not determined, and left out".to_owned());
        }
        remarks.extend(left_out(estimate, &names, &instruments));
        Ok(Corrections { joints, instruments, gravity: estimate.gravity, remarks })
    }
}

/// The joints, in the order of the calibration: whatever has a parameter of [`SensorParameter::ALL`].
fn joint_names(estimate: &EarlierEstimate) -> Vec<String> {
    let mut joints: Vec<String> = Vec::new();
    for parameter in &estimate.parameters {
        let (owner, quantity) = split_name(&parameter.name);
        let of_joint = SensorParameter::ALL.iter().any(|known| known.as_str() == quantity);
        if of_joint && joints.iter().all(|joint| joint != owner) {
            joints.push(owner.to_owned());
        }
    }
    joints
}

/// Parameters of joints' sensors beyond the four that say something. A robot's description holds nothing of torque readings anyway.
fn refuse_more(estimate: &EarlierEstimate, joints: &[String], format: ExportFormat) -> Result<(), ExportError> {
    let beyond = |parameter: &&EarlierParameter| {
        let (owner, quantity) = split_name(&parameter.name);
        let affine = SensorParameter::ALL.iter().any(|known| known.as_str() == quantity);
        let nothing = parameter.held.is_some() && parameter.value.unwrap_or(parameter.nominal) == 0.0;
        let no_place = format.is_robot() && of_torque_reading(parameter);
        !affine && !nothing && !no_place && !is_friction(quantity) && joints.iter().any(|joint| joint == owner)
    };
    let names: Vec<String> = estimate.parameters.iter().filter(beyond).map(|found| found.name.clone()).collect();
    if names.is_empty() { Ok(()) } else { Err(ExportError::BeyondAffine { format, names }) }
}

/// That torques come with the joints' friction, which is no part of a sensor.
fn friction_left_out(estimate: &EarlierEstimate, joints: &[String], format: ExportFormat) -> Option<String> {
    let rubs = |joint: &&String| {
        estimate.parameters.iter().any(|parameter| {
            let (owner, quantity) = split_name(&parameter.name);
            let nothing = parameter.held.is_some() && parameter.value.unwrap_or(parameter.nominal) == 0.0;
            owner == joint.as_str() && is_friction(quantity) && !nothing
        })
    };
    let names: Vec<&str> = joints.iter().filter(rubs).map(String::as_str).collect();
    (!names.is_empty() && !format.is_robot()).then(|| {
        format!(
            "friction of {} left out, which csv, markdown and latex hold: the true torque here is what gravity asks for and the friction \
             together",
            names.join(", ")
        )
    })
}

/// Whether it adds to what a torque sensor reads, by the equation in which it stands.
fn of_torque_reading(parameter: &EarlierParameter) -> bool {
    parameter.convention.starts_with("reading =")
}

/// What of instruments the format does not hold: all of those that it has no place for, or what is no gain and no bias.
fn left_out(estimate: &EarlierEstimate, joints: &[String], instruments: &[InstrumentCorrection]) -> Option<String> {
    let here = |parameter: &&EarlierParameter| {
        let (owner, quantity) = split_name(&parameter.name);
        let held_here = quantity.starts_with("gain_") || quantity.starts_with("bias_");
        let joint = joints.iter().any(|joint| joint == owner);
        joint || (held_here && instruments.iter().any(|instrument| instrument.name == owner))
    };
    let mut left: Vec<&str> = Vec::new();
    for parameter in estimate.parameters.iter().filter(|parameter| !here(parameter)) {
        let owner = split_name(&parameter.name).0;
        let partly = instruments.iter().any(|instrument| instrument.name == owner);
        left.push(if partly { &parameter.name } else { owner });
    }
    left.dedup();
    let reported = format!("{} left out, which csv, markdown and latex hold", left.join(", "));
    (!left.is_empty()).then_some(reported)
}

/// Values as they are taken.
pub(super) struct Taken<'a> {
    estimate: &'a EarlierEstimate,
    nominal: bool,
    /// Whether what torque sensors read has a place in the format.
    torques: bool,
    undetermined: Vec<String>,
    pub missing: Vec<String>,
    remarks: Vec<String>,
}

impl<'a> Taken<'a> {
    /// `None` where one of the parameters is missing, which is then named.
    fn joint(&mut self, name: &str) -> Option<JointCorrection> {
        let names = SensorParameter::ALL.map(|quantity| quantity.name(name));
        let found = names.each_ref().map(|name| self.parameter(name));
        let [Some(torque_gain), Some(torque_bias), Some(position_gain), Some(position_offset)] = found else {
            let missing = names.into_iter().zip(found).filter(|(_, found)| found.is_none());
            self.missing.extend(missing.map(|(name, _)| name));
            return None;
        };
        let read = torque_gain.held.as_deref() != Some(NO_TORQUE_SENSOR);
        let torque = (read && self.torques).then(|| Torque {
            gain: self.value(torque_gain),
            bias: self.value(torque_bias),
            reading_unit: torque_bias.unit.clone(),
            unit: other_unit(&torque_gain.unit, &torque_bias.unit),
        });
        if !read && self.torques {
            self.remarks.push(format!("{name} has no torque sensor"));
        }
        let position = Position {
            gain: self.value(position_gain),
            offset: self.value(position_offset),
            reading_unit: other_unit(&position_gain.unit, &position_offset.unit),
            unit: position_offset.unit.clone(),
        };
        Some(JointCorrection { name: name.to_owned(), torque, position })
    }

    pub fn parameter(&self, name: &str) -> Option<&'a EarlierParameter> {
        self.estimate.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// What is determined, or chosen; else the nominal value, if that may be.
    pub fn value(&mut self, parameter: &EarlierParameter) -> f64 {
        match (&parameter.held, parameter.value) {
            (None, Some(value)) => return value,
            (Some(why), value) => {
                let value = value.unwrap_or(parameter.nominal);
                self.remarks.push(format!("{} is held at {value}: {why}", parameter.name));
                return value;
            }
            (None, None) if self.nominal => {
                let EarlierParameter { name, nominal, .. } = parameter;
                self.remarks.push(format!("{name} is not determined; its nominal value {nominal} stands here"));
            }
            (None, None) => self.undetermined.push(parameter.name.clone()),
        }
        parameter.nominal
    }
}

/// Of `count/(N·m)` that which is not `count`.
fn other_unit(ratio: &str, known: &str) -> String {
    let other = ratio.strip_prefix(known).and_then(|rest| rest.strip_prefix('/')).unwrap_or(ratio);
    other.trim_start_matches('(').trim_end_matches(')').to_owned()
}
