//! From a model to the terms of a session: what any crate may declare is checked here.

use std::ops::Range;
use std::sync::Arc;

use super::model::{Declared, ParameterSpec, SensorModel, Side, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Partials, Reads, SensorTerm};
use crate::parameter::{Parameter, Quantity};
use crate::session::{Knowledge, KnowledgeKind};

/// A term of one joint's sensor, with the places of its parameters.
#[derive(Clone, Debug)]
pub struct Term {
    /// The sensor's joint.
    pub joint: usize,
    /// The name of the model that it is a part of; terms of one declaration share it.
    pub model: Arc<str>,
    /// Which sensor it is of.
    pub side: Side,
    /// What it reads.
    pub reads: Reads,
    /// Among all parameters of terms.
    pub places: Range<usize>,
    function: Arc<dyn SensorTerm>,
}

impl Term {
    /// `f`. `values`: of the parameters of all terms.
    pub fn value(&self, at: &Moment<'_>, values: &[f64], partials: Option<Partials<'_>>) -> f64 {
        self.value_of(at, &values[self.places.clone()], partials)
    }

    /// `f`. `own`: of its own parameters.
    pub fn value_of(&self, at: &Moment<'_>, own: &[f64], partials: Option<Partials<'_>>) -> f64 {
        self.function.value(at, own, partials)
    }
}

/// What a model declares for the sensor of a joint: terms, each with its parameters.
pub fn declare_terms(
    model: &dyn SensorModel,
    site: &Site<'_>,
    options: &Options,
) -> Result<Vec<(Term, Vec<Parameter>)>, RefusedOption> {
    let declared = model.declare(site, options)?;
    check_names(&declared)?;
    let name: Arc<str> = model.name().into();
    let term = |Declared { parameters, term: function }: Declared| {
        let reads = function.reads();
        check_reads(&reads, model.side(), site)?;
        let linear = model.side() == Side::Torque && reads.is_linear();
        let places = 0..parameters.len();
        let parameters = parameters.into_iter().map(|spec| parameter(site, spec, linear)).collect();
        Ok((
            Term { joint: site.joint, model: Arc::clone(&name), side: model.side(), reads, places, function },
            parameters,
        ))
    };
    declared.into_iter().map(term).collect()
}

fn parameter(site: &Site<'_>, spec: ParameterSpec, linear: bool) -> Parameter {
    let ParameterSpec { name, unit, nominal, limit, convention, cure } = spec;
    Parameter {
        owner: site.names[site.joint].to_owned(),
        quantity: name,
        unit,
        convention,
        knowledge: Knowledge { nominal, kind: KnowledgeKind::Start },
        held: None,
        limit,
        cure,
        linear,
    }
}

/// Names of parameters are keys of files, and told behind the joint's name and a point.
fn check_names(declared: &[Declared]) -> Result<(), RefusedOption> {
    let names: Vec<&str> = declared.iter().flat_map(|term| &term.parameters).map(|spec| spec.name.as_str()).collect();
    for (place, name) in names.iter().enumerate() {
        let fits = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
        let wrong = if name.is_empty() || !name.chars().all(fits) {
            "expected letters, digits, `_` and `-`"
        } else if names[..place].contains(name) {
            "it names two of its parameters so"
        } else if Quantity::ALL.iter().any(|quantity| quantity.as_str() == *name) {
            "every sensor has a parameter of this name already"
        } else {
            continue;
        };
        return Err(RefusedOption::new("kind", format!("the model names a parameter `{name}`: {wrong}")));
    }
    Ok(())
}

fn check_reads(reads: &Reads, side: Side, site: &Site<'_>) -> Result<(), RefusedOption> {
    let refused = |message: String| Err(RefusedOption::new("kind", message));
    if let Some(joint) = reads.torques().iter().chain(reads.coordinates()).find(|joint| **joint >= site.names.len()) {
        let count = site.names.len();
        return refused(format!(
            "the model reads joint number {joint}, counted from 0, but the robot has {count} joints"
        ));
    }
    if side == Side::Position && !(reads.torques().is_empty() && reads.coordinates().is_empty()) {
        return refused("a model of a position sensor reads positions and conditions only, but this one reads torques or coordinates".into());
    }
    Ok(())
}
