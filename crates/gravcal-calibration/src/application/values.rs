//! A calibration's values as those of a session.

use std::collections::HashSet;

use gravcal_recording::{EarlierEstimate, EarlierParameter};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use super::error::ApplicationError;
use crate::joint::State;

/// Sees to it that a calibration's parameters are in the units of a session, as far as it has them.
///
/// # Errors
/// Names the first parameter that is in another unit.
pub fn check_units(session: &Session, calibration: &EarlierEstimate) -> Result<(), ApplicationError> {
    session.parameters().into_iter().try_for_each(|id| {
        let name = session.parameter_name(id);
        let found = calibration.parameters.iter().find(|found| found.name == name);
        found.map_or(Ok(()), |found| check_unit(session, id, found))
    })
}

fn check_unit(session: &Session, id: ParameterId, found: &EarlierParameter) -> Result<(), ApplicationError> {
    let here = session.parameter(id).unit;
    match found.unit == here {
        true => Ok(()),
        false => Err(ApplicationError::Unit { name: found.name.clone(), there: found.unit.clone(), here }),
    }
}

/// Sees to it that a session knows all that a calibration found of the readings of its joints: a model that is left out would pass
/// into torques and angles without a word.
pub(super) fn check_models(session: &Session, calibration: &EarlierEstimate) -> Result<(), ApplicationError> {
    let known: HashSet<String> = session.parameters().into_iter().map(|id| session.parameter_name(id)).collect();
    let joints: Vec<String> = session.robot.chain.joints().iter().map(|joint| format!("{}.", joint.name)).collect();
    let of_joint = |name: &str| joints.iter().any(|joint| name.starts_with(joint));
    let changes_nothing = |found: &EarlierParameter| found.held.is_some() && found.nominal == 0.0;
    let left_out = calibration.parameters.iter().filter(|found| of_joint(&found.name) && !known.contains(&found.name));
    let names: Vec<String> = left_out.filter(|found| !changes_nothing(found)).map(|found| found.name.clone()).collect();
    if names.is_empty() { Ok(()) } else { Err(ApplicationError::OtherModels { names }) }
}

/// A value for every parameter that readings depend on.
pub(super) fn values(
    session: &Session,
    calibration: &EarlierEstimate,
    nominal: bool,
) -> Result<State, ApplicationError> {
    let mut values = State::nominal(session);
    let mut undetermined = Vec::new();
    for id in session.parameters() {
        let (joint, is_torque) = match id {
            ParameterId::Sensor(joint, quantity) => {
                (joint, matches!(quantity, SensorParameter::TorqueGain | SensorParameter::TorqueBias))
            }
            // Behind the terms are the parameters of instruments and the like, which no joint's reading depends on.
            ParameterId::Further(index) => match session.terms.site(index) {
                Some(site) => site,
                None => continue,
            },
        };
        if is_torque && session.readings.torques[joint].is_none() {
            continue;
        }
        let name = session.parameter_name(id);
        let found = calibration.parameters.iter().find(|found| found.name == name);
        let found = found.ok_or_else(|| ApplicationError::OtherSession { name: name.clone() })?;
        check_unit(session, id, found)?;
        // What is fixed by a choice of frame has the value that was chosen.
        match found.value.or(found.held.as_ref().map(|_| found.nominal)) {
            Some(value) => *values.value_mut(id) = value,
            None if nominal => {}
            None => undetermined.push(name),
        }
    }
    values.share(session);
    // A joint without a torque sensor: any that reads nothing will do.
    for (sensor, torque) in values.sensors.iter_mut().zip(&session.readings.torques) {
        if torque.is_none() {
            sensor[SensorParameter::TorqueGain as usize] = 1.0;
        }
    }
    match undetermined.is_empty() {
        true => Ok(values),
        false => Err(ApplicationError::Undetermined { names: undetermined }),
    }
}
