//! `sensor_models` of a joint, as sessions declare them and simulations give them true values.
//!
//! ```toml
//! sensor_models = [{ kind = "torque-bias-in-time", parameters = { torque_bias_drift = … } }]
//! ```

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::declare::{Options, Site};
use super::name::{Need, SensorModelName};
use super::terms::Term;
use crate::document::{Document, Field, FileError};
use crate::parameter::Parameter;

/// One entry of `sensor_models`; `V` is what may be said of a parameter.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(crate) struct ModelTable<V> {
    kind: String,
    #[serde(rename = "reference_degC", skip_serializing_if = "Option::is_none")]
    reference_degc: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    degree: Option<i32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orders: Option<Vec<u32>>,
    #[serde(default = "BTreeMap::new", skip_serializing_if = "BTreeMap::is_empty")]
    parameters: BTreeMap<String, V>,
}

/// The sensor models of a simulation's joints, as its sessions declare them; none by default.
#[derive(Clone, Debug, Default)]
pub struct DeclaredModels {
    by_joint: Vec<Vec<ModelTable<()>>>,
}

impl DeclaredModels {
    pub(crate) fn new(by_joint: Vec<Vec<ModelTable<()>>>) -> DeclaredModels {
        DeclaredModels { by_joint }
    }

    /// Joints that have any, with them.
    pub(crate) fn joints(&self) -> impl Iterator<Item = (usize, &Vec<ModelTable<()>>)> {
        self.by_joint.iter().enumerate().filter(|(_, models)| !models.is_empty())
    }
}

/// A term with what the file says of its parameter, and where; or where its model stands.
pub(crate) struct DeclaredInFile<'t, V> {
    pub parameter: Parameter,
    pub term: Term,
    pub field: Field,
    pub said: Option<&'t V>,
}

impl<V> ModelTable<V> {
    /// The same without what is said of its parameters.
    pub fn without_parameters(&self) -> ModelTable<()> {
        let ModelTable { kind, reference_degc, degree, from, orders, parameters: _ } = self;
        ModelTable {
            kind: kind.clone(),
            reference_degc: *reference_degc,
            degree: *degree,
            from: from.clone(),
            orders: orders.clone(),
            parameters: BTreeMap::new(),
        }
    }

    fn options(&self) -> Options {
        let (from, orders) = (self.from.clone(), self.orders.clone());
        Options { reference_degc: self.reference_degc, degree: self.degree, from, orders }
    }

    fn given(&self) -> Vec<&'static str> {
        let given = [
            ("reference_degC", self.reference_degc.is_some()),
            ("degree", self.degree.is_some()),
            ("from", self.from.is_some()),
            ("orders", self.orders.is_some()),
        ];
        given.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
    }
}

/// The terms that a joint's `sensor_models` declare. `models`: the field that holds them; `knows`: whether the poses say
/// what a model needs; models that are `passed_over` are not declared.
///
/// # Errors
/// A model, an option or a parameter that is not known; a condition that no column gives.
pub(crate) fn declare<'t, V>(
    document: &Document,
    models: &Field,
    site: &Site<'_>,
    tables: &'t [ModelTable<V>],
    knows: impl Fn(Need) -> bool,
    passed_over: impl Fn(SensorModelName) -> bool,
) -> Result<Vec<DeclaredInFile<'t, V>>, FileError> {
    document.check_names(tables.iter().map(|table| table.kind.as_str()), |i| models.at(i).key("kind"))?;
    let mut all = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let field = models.at(index);
        let model: SensorModelName = table.kind.parse().map_err(|error| document.error(&field.key("kind"), error))?;
        if passed_over(model) {
            continue;
        }
        if let Some(key) = table.given().into_iter().find(|key| !model.options().contains(key)) {
            return Err(document.error(&field.key(key), format!("{model} has no such option: delete it")));
        }
        check_need(document, &field, site, model, &knows)?;
        let options = table.options();
        let refused = |refused: super::RefusedOption| document.error(&field.key(refused.key), refused.message);
        let declared = model.declare(site, &options).map_err(refused)?;
        let names: Vec<&str> = declared.iter().map(|(parameter, _)| parameter.quantity.as_str()).collect();
        for name in table.parameters.keys() {
            document.lookup(&field.key("parameters").key(name), "parameter", name, &names)?;
        }
        all.extend(declared.into_iter().map(|(parameter, term)| {
            let said = table.parameters.get(&parameter.quantity);
            let place = said.map(|_| field.key("parameters").key(&parameter.quantity));
            DeclaredInFile { field: place.unwrap_or_else(|| field.clone()), said, parameter, term }
        }));
    }
    Ok(all)
}

fn check_need(
    document: &Document,
    field: &Field,
    site: &Site<'_>,
    model: SensorModelName,
    knows: impl Fn(Need) -> bool,
) -> Result<(), FileError> {
    if !model.is_of_position() && !site.reads_torque {
        let message =
            format!("joint `{}` has no column in readings.torque: name one, or delete this", site.names[site.joint]);
        return Err(document.error(field, message));
    }
    match model.need() {
        Some(need) if !knows(need) => {
            Err(document.error(&field.key("kind"), format!("{model} needs {}", in_words(need))))
        }
        _ => Ok(()),
    }
}

fn in_words(need: Need) -> &'static str {
    match need {
        Need::Time => "the time of each pose: add readings.time = { column = \"…\", unit = \"s\" }",
        Need::Temperature => {
            "the temperature of each pose: add readings.temperature = { columns = \"…\", unit = \"degC\" }"
        }
        Need::Velocity => {
            "the velocity of each joint: add readings.velocity = { columns = […], unit = \"rad/s\" }, one for each joint, \
             or { slope_over_s = … }"
        }
        Need::Direction => {
            "to know from which side the joints came: add readings.direction = { columns = […] } (cells 1, 0, -1), or \
             readings.velocity = { columns = […], unit = \"rad/s\" }, one for each joint, \
             or { slope_over_s = … }"
        }
    }
}

/// What a number written in one unit is multiplied with to be in a parameter's own.
///
/// # Errors
/// The unit is missing or another; the message says which fit.
pub(crate) fn to_unit_of(unit: &str, written: Option<&str>) -> Result<f64, String> {
    let also = match unit {
        "rad" => Some(("deg", 1f64.to_radians())),
        "m" => Some(("mm", 1e-3)),
        _ => None,
    };
    match (written, also) {
        (Some(written), _) if without_brackets(written) == without_brackets(unit) => Ok(1.0),
        (Some(written), Some((other, factor))) if written == other => Ok(factor),
        (written, also) => {
            let accepted = also.map_or_else(String::new, |(other, _)| format!(" or `{other}`"));
            let found =
                written.map_or("the unit is missing".to_owned(), |unit| format!("the unit `{unit}` does not fit"));
            Err(format!("{found}: expected `{unit}`{accepted}"))
        }
    }
}

/// `count/(N·m)` and `count/N·m` are one unit; so are the spellings of the newton metre.
fn without_brackets(unit: &str) -> String {
    unit.replace(['(', ')', ' '], "").replace("N*m", "N·m").replace("Nm", "N·m")
}
