//! `[[load]]` and `[[load_distance]]`: bodies of known mass, and how far apart their placements are.

use gravcal_robot_model::session::{Load, LoadDistance};
use serde::Deserialize;

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
    /// Its mass, taken as exact.
    ///
    /// Example: `mass_kg = 1.724`
    mass_kg: f64,
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
    let mass = document.positive(&field.key("mass_kg"), table.mass_kg, "a mass", "kg")?;
    let link = document.lookup(&field.key("link"), "link", &table.link, &context.link_names)?;
    let std_field = field.key("position_std_m");
    if table.position_std_m.is_some() && table.position_m.is_none() {
        return Err(document.error(&std_field, "a standard deviation of what? add position_m, or delete this"));
    }
    let std = table.position_std_m.map(|std| document.positive(&std_field, std, "a standard deviation", "m"));
    Ok(Load { name: table.name.clone(), mass, link, position: table.position_m, position_std: std.transpose()? })
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
    let positive = |std| document.positive(&field.key("distance_std_m"), std, "a standard deviation", "m");
    Ok(LoadDistance {
        between: [first, second],
        distance: document.positive(&field.key("distance_m"), table.distance_m, "a distance", "m")?,
        std: table.distance_std_m.map(positive).transpose()?,
    })
}
