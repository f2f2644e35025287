//! `[[load]]` and `[[load_distance]]`: bodies of known or unknown mass, and how far apart placements are.

use std::fmt;

use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::session::load_masses::add_load_masses;
use gravcal_robot_model::session::{AuxiliarySensor, AuxiliarySensorKind, InertiaPrior, Load, LoadDistance, Session};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};

use super::context::Context;
use crate::document::{Document, Field, FileError};

/// `[[load]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct LoadTable {
    /// Its name, by which tables refer to it.
    ///
    /// Example: `name = "plate-a"`
    name: String,
    /// Its mass: a number, taken as exact; or what was weighed and how well, `{ nominal = 1.724, std = 0.005 }` in kg, which the torque gains'
    /// standard deviations then include (loads of the same nominal mass and std are one body, weighed once); or `"unknown"`: mass, centre of
    /// mass and, in motion, inertia tensor are found. That takes torque gains that are known, or another load of known mass, and poses without
    /// it.
    ///
    /// Example: `mass_kg = 1.724`
    mass_kg: WrittenMass,
    /// The link that carries it.
    ///
    /// Example: `link = "link3"`
    link: String,
    /// Its centre of mass in that link's frame.
    ///
    /// Default: unknown.
    /// Example: `position_m = [0, 0, 0.1]`
    position_m: Option<[f64; 3]>,
    /// How well that is known.
    ///
    /// Default: exact.
    /// Example: `position_std_m = 0.001`
    position_std_m: Option<f64>,
}

/// How heavy a load is.
///
/// Read by hand and not by an untagged enum, whose errors neither say what was found nor where.
#[derive(Clone, Copy, Debug)]
enum WrittenMass {
    Unknown,
    Exact(f64),
    Weighed(WeighedMass),
}

/// A mass and how well it is known.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { nominal = 1.724, std = 0.005 }, in kg")]
struct WeighedMass {
    nominal: f64,
    std: f64,
}

impl WrittenMass {
    /// kg; no number where it is unknown.
    fn nominal(self) -> f64 {
        match self {
            WrittenMass::Unknown => f64::NAN,
            WrittenMass::Exact(mass) | WrittenMass::Weighed(WeighedMass { nominal: mass, .. }) => mass,
        }
    }
}

impl<'de> Deserialize<'de> for WrittenMass {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MassVisitor)
    }
}

struct MassVisitor;

impl<'de> Visitor<'de> for MassVisitor {
    type Value = WrittenMass;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a mass in kg, such as 1.724 or { nominal = 1.724, std = 0.005 }, or \"unknown\"")
    }

    fn visit_f64<E: Error>(self, mass: f64) -> Result<WrittenMass, E> {
        match mass.is_nan() {
            true => Err(E::invalid_value(Unexpected::Float(mass), &self)),
            false => Ok(WrittenMass::Exact(mass)),
        }
    }

    fn visit_i64<E: Error>(self, mass: i64) -> Result<WrittenMass, E> {
        Ok(WrittenMass::Exact(mass as f64))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<WrittenMass, E> {
        match text {
            "unknown" => Ok(WrittenMass::Unknown),
            other => Err(E::invalid_type(Unexpected::Str(other), &self)),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<WrittenMass, A::Error> {
        WeighedMass::deserialize(MapAccessDeserializer::new(table)).map(WrittenMass::Weighed)
    }
}

/// `[[load_distance]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct LoadDistanceTable {
    /// Names of two loads on one link.
    ///
    /// Example: `between = ["plate-a", "plate-b"]`
    between: [String; 2],
    /// Distance between their centres of mass.
    ///
    /// Example: `distance_m = 0.402`
    distance_m: f64,
    /// How well it is known.
    ///
    /// Default: 1e-6.
    /// Example: `distance_std_m = 0.0005`
    distance_std_m: Option<f64>,
}

/// What the `[[load]]` come to.
pub(super) fn resolve(context: &Context<'_>, tables: &[LoadTable]) -> Result<Vec<Load>, FileError> {
    let names = tables.iter().map(|table| table.name.as_str());
    context.document.check_names(names, |i| Field::new("load").at(i).key("name"))?;
    tables.iter().enumerate().map(|(i, table)| load(context, &Field::new("load").at(i), table)).collect()
}

fn load(context: &Context<'_>, field: &Field, table: &LoadTable) -> Result<Load, FileError> {
    let document = context.document;
    let mass = table.mass_kg.nominal();
    match table.mass_kg {
        WrittenMass::Unknown => {}
        WrittenMass::Exact(mass) => {
            document.positive(&field.key("mass_kg"), mass, "a mass", "kg")?;
        }
        WrittenMass::Weighed(WeighedMass { nominal, std }) => {
            document.positive(&field.key("mass_kg").key("nominal"), nominal, "a mass", "kg")?;
            document.positive(&field.key("mass_kg").key("std"), std, "a standard deviation", "kg")?;
        }
    }
    let link = document.lookup(&field.key("link"), "link", &table.link, &context.link_names)?;
    let std_field = field.key("position_std_m");
    if table.position_std_m.is_some() && table.position_m.is_none() {
        return Err(document.error(&std_field, "a standard deviation of what? add position_m, or delete this"));
    }
    if mass.is_nan() && table.position_m.is_some() {
        let message = "of a load of unknown mass the centre of mass is found, too: delete this, or state the mass";
        return Err(document.error(&field.key("position_m"), message));
    }
    let std = table.position_std_m.map(|std| document.positive(&std_field, std, "a standard deviation", "m"));
    Ok(Load { name: table.name.clone(), mass, link, position: table.position_m, position_std: std.transpose()? })
}

/// By load, the place of its mass among the further parameters, to which they are added.
pub(super) fn masses(
    context: &Context<'_>,
    tables: &[LoadTable],
    loads: &[Load],
    further: &mut Vec<Parameter>,
) -> Result<Vec<Option<usize>>, FileError> {
    let std = |table: &LoadTable| match table.mass_kg {
        WrittenMass::Weighed(WeighedMass { std, .. }) => Some(std),
        WrittenMass::Unknown | WrittenMass::Exact(_) => None,
    };
    let std: Vec<Option<f64>> = tables.iter().map(std).collect();
    for (index, (load, std)) in loads.iter().zip(&std).enumerate() {
        if std.is_some_and(|std| std >= load.mass) {
            let message = "a mass that may as well be none: write \"unknown\", or weigh the load";
            return Err(context.document.error(&Field::new("load").at(index).key("mass_kg").key("std"), message));
        }
    }
    Ok(add_load_masses(loads, &std, further))
}

/// What the `[[load_distance]]` come to.
pub(super) fn resolve_distances(
    document: &Document,
    loads: &[Load],
    tables: &[LoadDistanceTable],
) -> Result<Vec<LoadDistance>, FileError> {
    let mut distances: Vec<LoadDistance> = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let field = Field::new("load_distance").at(index);
        let known = distance(document, &field, loads, table)?;
        let same = |other: &LoadDistance| {
            let [a, b] = known.between;
            other.between == [a, b] || other.between == [b, a]
        };
        if let Some(first) = distances.iter().position(same) {
            let message = format!("the distance between these two loads is already load_distance[{first}]: keep one");
            return Err(document.error(&field.key("between"), message));
        }
        distances.push(known);
    }
    Ok(distances)
}

fn distance(
    document: &Document,
    field: &Field,
    loads: &[Load],
    table: &LoadDistanceTable,
) -> Result<LoadDistance, FileError> {
    let between = field.key("between");
    let names: Vec<&str> = loads.iter().map(|load| load.name.as_str()).collect();
    let find = |end: usize| document.lookup(&between.at(end), "load", &table.between[end], &names);
    let [first, second] = [find(0)?, find(1)?];
    if first == second {
        return Err(document.error(&between, "a load is no distance from itself: name two loads"));
    }
    if loads[first].link != loads[second].link {
        let message = "the two loads are on different links, so their distance changes as the robot moves: name two on \
                       one link";
        return Err(document.error(&between, message));
    }
    if loads[first].is_unknown() || loads[second].is_unknown() {
        let message = "a distance says nothing of a load of unknown mass: state mass_kg of both, or delete this";
        return Err(document.error(&between, message));
    }
    let positive = |std| document.positive(&field.key("distance_std_m"), std, "a standard deviation", "m");
    Ok(LoadDistance {
        between: [first, second],
        distance: document.positive(&field.key("distance_m"), table.distance_m, "a distance", "m")?,
        std: table.distance_std_m.map(positive).transpose()?,
    })
}

/// What a load of unknown mass goes together with.
pub(super) fn check_unknown(document: &Document, session: &Session) -> Result<(), FileError> {
    let Some(index) = session.loads.iter().position(Load::is_unknown) else { return Ok(()) };
    let field = Field::new("load").at(index).key("mass_kg");
    if session.inertia == InertiaPrior::Sweep {
        let message = "a load of unknown mass is told from its link by the link's moments, and those of sweeps are of no single link: write \
                       [inertia] description = \"link\"";
        return Err(document.error(&field, message));
    }
    let feels = |instrument: &AuxiliarySensor| instrument.kind == AuxiliarySensorKind::ForceTorque;
    if let Some(wrist) = session.instruments.iter().find(|instrument| feels(instrument)) {
        let message = format!(
            "joint torques find a load of unknown mass, and the force-torque sensor `{}` feels it, too, which this version cannot put \
             together: leave the sensor out, or state the mass",
            wrist.name
        );
        return Err(document.error(&field, message));
    }
    Ok(())
}
