//! `rotor_inertia` of a joint: what its motor turns before the gear, felt where the torque is the motor's own.

use std::fmt;

use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::session::rotors::{rotor_inertia_parameter, rotor_inertia_unit};
use gravcal_robot_model::session::{JointPriors, ParameterPrior, units};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::context::Context;
use super::joints::{Entry, Said};
use super::parameter_prior::{ParameterPriorTable, start};
use crate::document::FileError;

/// `"unknown"`, or what is known of it.
#[derive(Debug)]
pub(super) enum RotorInertia {
    Unknown,
    Known(ParameterPriorTable),
}

/// Read by hand and not by an untagged enum, whose errors neither say what was found nor where.
impl<'de> Deserialize<'de> for RotorInertia {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RotorVisitor)
    }
}

struct RotorVisitor;

impl<'de> Visitor<'de> for RotorVisitor {
    type Value = RotorInertia;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("\"unknown\", or a table such as { nominal = 0.4, std = 0.1, unit = \"kg·m²\" }")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<RotorInertia, E> {
        match word {
            "unknown" => Ok(RotorInertia::Unknown),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<RotorInertia, A::Error> {
        ParameterPriorTable::deserialize(MapAccessDeserializer::new(table)).map(RotorInertia::Known)
    }
}

/// The place of each joint's rotor inertia among the further parameters, to which they are added; empty where no joint has one. `moves`:
/// whether the tables are recordings of an arm in motion.
pub(super) fn resolve(
    context: &Context<'_>,
    said: &[Said<'_>],
    (joints, moves): (&[JointPriors], bool),
    further: &mut Vec<Parameter>,
) -> Result<Vec<Option<usize>>, FileError> {
    let mut rotors = vec![None; joints.len()];
    for (index, said) in said.iter().enumerate() {
        let Some(entry) = said.rotor_inertia() else { continue };
        let (joint, refused) =
            (&context.robot.chain.joints()[index], |message| context.document.error(&entry.field, message));
        if !moves {
            return Err(refused(format!(
                "an arm that stands does not feel the rotor of `{}`: record it in motion (readings.motion = {{}}), or delete this",
                joint.name
            )));
        }
        if joints[index].torque_unit.is_none() {
            if entry.of_all {
                continue;
            }
            return Err(refused(format!(
                "joint `{}` has no column in readings.torque: name one, or delete this",
                joint.name
            )));
        }
        let prior = prior(context, &entry, rotor_inertia_unit(joint.kind))?;
        rotors[index] = Some(further.len());
        further.push(rotor_inertia_parameter(index, joint, prior));
    }
    Ok(if rotors.iter().any(Option::is_some) { rotors } else { Vec::new() })
}

fn prior(context: &Context<'_>, entry: &Entry<'_, RotorInertia>, unit: &str) -> Result<ParameterPrior, FileError> {
    let (document, field) = (context.document, &entry.field);
    let RotorInertia::Known(table) = entry.value else { return Ok(start(0.0)) };
    units::same(table.unit(), unit).map_err(|error| document.error(&field.key("unit"), error))?;
    let prior = table.prior(document, field)?;
    if prior.nominal >= 0.0 {
        return Ok(prior);
    }
    let key = if table.is_fixed() { "fixed" } else { "nominal" };
    let message = format!("{} {unit} is no inertia of a rotor: expected zero or more", prior.nominal);
    Err(document.error(&field.key(key), message))
}
