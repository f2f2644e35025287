//! `sensor_models` of a joint, as sessions declare them and simulations give them true values.
//!
//! ```toml
//! sensor_models = [{ kind = "torque-bias-in-time", parameters = { torque_bias_drift = … } }]
//! ```

use std::collections::BTreeMap;

use gravcal_recording::nearest_name;
use gravcal_robot_model::Registry;
use gravcal_robot_model::parameter::Parameter;
use gravcal_robot_model::sensors::{Need, Options, RefusedOption, SensorModel, Side, Site, Term, declare_terms};
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::document::{Document, Field, FileError};

/// One entry of `sensor_models`; `V` is what may be said of a parameter.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(expecting = "a table")]
pub(crate) struct ModelTable<V> {
    kind: String,
    #[serde(default = "BTreeMap::new", skip_serializing_if = "BTreeMap::is_empty")]
    parameters: BTreeMap<String, V>,
    /// Everything else; which of it there may be is the model's.
    #[serde(flatten)]
    options: Table,
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

    /// Those of a joint.
    pub(crate) fn of(&self, joint: usize) -> &[ModelTable<()>] {
        self.by_joint.get(joint).map_or(&[], Vec::as_slice)
    }
}

/// A term with its parameters.
pub(crate) struct DeclaredInFile<'t, V> {
    pub term: Term,
    pub parameters: Vec<ParameterInFile<'t, V>>,
}

/// A parameter with what the file says of it, and where; or where its model stands.
pub(crate) struct ParameterInFile<'t, V> {
    pub parameter: Parameter,
    pub field: Field,
    pub said: Option<&'t V>,
}

impl<V> ModelTable<V> {
    /// The same without what is said of its parameters.
    pub fn without_parameters(&self) -> ModelTable<()> {
        ModelTable { kind: self.kind.clone(), parameters: BTreeMap::new(), options: self.options.clone() }
    }
}

/// What `sensor_models` are read against.
pub(crate) struct ModelContext<'a> {
    pub document: &'a Document,
    pub registry: &'a Registry,
    /// The field that holds them.
    pub models: Field,
}

/// The terms that a joint's `sensor_models` declare. `knows`: whether the poses say what a term needs; models that are `passed_over` are
/// not declared.
///
/// # Errors
/// A model, an option or a parameter that is not known; a condition that no column gives.
pub(crate) fn declare<'t, V>(
    context: &ModelContext<'_>,
    site: &Site<'_>,
    tables: &'t [ModelTable<V>],
    knows: impl Fn(Need) -> bool,
    passed_over: impl Fn(&dyn SensorModel) -> bool,
) -> Result<Vec<DeclaredInFile<'t, V>>, FileError> {
    context.check_kinds(tables)?;
    let mut all: Vec<DeclaredInFile<'t, V>> = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let field = context.models.at(index);
        let model = context.model(&field, &table.kind)?;
        if passed_over(model) {
            continue;
        }
        let declared = context.declared(&field, site, (model, table), &knows)?;
        // What the joint itself has, and shares with no other.
        let of_joint = |own: &&ParameterInFile<'_, V>| own.parameter.owner == site.joint_names()[site.joint()];
        let known = |name: &str| {
            let mut known = all.iter().flat_map(|own| &own.parameters).filter(of_joint);
            known.any(|own| own.parameter.quantity == name)
        };
        let names = declared.iter().flat_map(|own| &own.parameters).filter(of_joint);
        let mut names = names.map(|own| own.parameter.quantity.as_str());
        if let Some(twice) = names.find(|name| known(name)) {
            let message =
                format!("another model of this joint has a parameter `{twice}` already: give each its own name");
            return Err(context.document.error(&field, message));
        }
        all.extend(declared);
    }
    Ok(all)
}

impl ModelContext<'_> {
    fn model(&self, field: &Field, kind: &str) -> Result<&dyn SensorModel, FileError> {
        self.registry.sensor_model(kind).map_err(|error| self.document.error(&field.key("kind"), error))
    }

    /// A joint has each model once, but for those that may be repeated.
    fn check_kinds<V>(&self, tables: &[ModelTable<V>]) -> Result<(), FileError> {
        let repeatable = |kind: &str| self.registry.sensor_model(kind).is_ok_and(SensorModel::is_repeatable);
        let once: Vec<(usize, &str)> =
            tables.iter().map(|table| table.kind.as_str()).enumerate().filter(|(_, kind)| !repeatable(kind)).collect();
        let place = |place: usize| self.models.at(once[place].0).key("kind");
        self.document.check_names(once.iter().map(|(_, kind)| *kind), place)
    }

    fn declared<'t, V>(
        &self,
        field: &Field,
        site: &Site<'_>,
        (model, table): (&dyn SensorModel, &'t ModelTable<V>),
        knows: &impl Fn(Need) -> bool,
    ) -> Result<Vec<DeclaredInFile<'t, V>>, FileError> {
        let options = Options::of(table.options.clone());
        self.check_options(field, model, &options)?;
        if model.side() == Side::Torque && !site.reads_torque() {
            let joint = site.joint_names()[site.joint()];
            let message = format!("joint `{joint}` has no column in readings.torque: name one, or delete this");
            return Err(self.document.error(field, message));
        }
        let refused = |RefusedOption { keys, message }: RefusedOption| {
            self.document.error(&keys.iter().fold(field.clone(), |field, key| field.key(key)), message)
        };
        let declared = declare_terms(model, site, &options).map_err(refused)?;
        self.check_needs(field, model, declared.iter().map(|(term, _)| term), knows)?;
        let names: Vec<&str> = declared.iter().flat_map(|(_, own)| own).map(|own| own.quantity.as_str()).collect();
        for name in table.parameters.keys() {
            self.document.lookup(&field.key("parameters").key(name), "parameter", name, &names)?;
        }
        let in_file = |parameter: Parameter| {
            let said = table.parameters.get(&parameter.quantity);
            let place = said.map(|_| field.key("parameters").key(&parameter.quantity));
            ParameterInFile { field: place.unwrap_or_else(|| field.clone()), said, parameter }
        };
        let with_parameters = |(term, parameters): (Term, Vec<Parameter>)| DeclaredInFile {
            term,
            parameters: parameters.into_iter().map(in_file).collect(),
        };
        Ok(declared.into_iter().map(with_parameters).collect())
    }

    fn check_options(&self, field: &Field, model: &dyn SensorModel, options: &Options) -> Result<(), FileError> {
        check_options(self.document, field, (model.name(), model.options(), &["parameters"]), options)
    }

    fn check_needs<'d>(
        &self,
        field: &Field,
        model: &dyn SensorModel,
        mut terms: impl Iterator<Item = &'d Term>,
        knows: &impl Fn(Need) -> bool,
    ) -> Result<(), FileError> {
        let unknown = terms.find_map(|term| term.reads.needs().iter().copied().find(|need| !knows(*need)));
        match unknown {
            None => Ok(()),
            Some(need) => {
                let message = format!("{} needs {}", model.name(), in_words(need));
                Err(self.document.error(&field.key("kind"), message))
            }
        }
    }
}

/// Sees to it that a model has every option that is said of it; `others`: keys that stand beside them.
pub(crate) fn check_options(
    document: &Document,
    field: &Field,
    (model, known, others): (&str, &[&str], &[&str]),
    options: &Options,
) -> Result<(), FileError> {
    let Some(key) = options.keys().find(|key| !known.contains(key)) else { return Ok(()) };
    let known: Vec<&str> = known.iter().chain(others).copied().collect();
    let near = nearest_name(key, &known).map_or_else(|| "delete it".into(), |near| format!("did you mean `{near}`?"));
    Err(document.error(&field.key(key), format!("{model} has no such option: {near}")))
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
        Need::Presliding => {
            "the motion of the joint from moment to moment: record the arm in motion and say readings.motion = {}; of standstills and slow \
             sweeps kind = \"coulomb-friction\" is the model"
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
