//! From a model to the terms of a session: what any crate may declare is checked here.

use std::ops::Range;
use std::sync::Arc;

use super::derivative_check::{TOLERANCE, WrongDerivative, check_term_derivatives};
use super::model::{Declared, ParameterSpec, SensorModel, Side, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Partials, Reads, SensorTerm};
use crate::parameter::{Limit, Parameter, SensorParameter};
use crate::session::{ParameterPrior, PriorKind};

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

    /// Whether the derivatives of `f` are what differences say, unless `f` looks after that itself. `own`: of its own parameters.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check_derivatives(&self, at: &Moment<'_>, own: &[f64]) -> Result<(), WrongDerivative> {
        match self.function.checks_derivatives() {
            true => Ok(()),
            false => check_term_derivatives(self.function.as_ref(), at, own, TOLERANCE),
        }
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
    check_parameters(declared.iter().flat_map(|term| &term.parameters))?;
    let name: Arc<str> = model.name().into();
    let term = |Declared { parameters, term: function }: Declared| {
        let reads = function.reads();
        check_reads(&reads, model.side(), site)?;
        let linear = model.side() == Side::Torque && reads.is_linear();
        let places = 0..parameters.len();
        let owner = site.names[site.joint];
        let parameters = parameters.into_iter().map(|spec| declared_parameter(owner, spec, linear)).collect();
        Ok((
            Term { joint: site.joint, model: Arc::clone(&name), side: model.side(), reads, places, function },
            parameters,
        ))
    };
    declared.into_iter().map(term).collect()
}

/// What is said of a parameter of `owner`, unless it is shared. Other readings may depend on a shared one otherwise, so it is no linear one.
pub(crate) fn declared_parameter(owner: &str, spec: ParameterSpec, linear: bool) -> Parameter {
    let ParameterSpec { name, unit, nominal, limit, convention, cure, shared } = spec;
    let linear = linear && shared.is_none();
    Parameter {
        owner: shared.unwrap_or_else(|| owner.to_owned()),
        quantity: name,
        unit,
        convention,
        prior: ParameterPrior { nominal, kind: PriorKind::Flat },
        fixed: None,
        limit,
        cure,
        linear,
        same_as: None,
    }
}

/// Names of parameters are keys of files, and told behind the name of what has them and a point; a fit starts where they start.
pub(crate) fn check_parameters<'s>(declared: impl IntoIterator<Item = &'s ParameterSpec>) -> Result<(), RefusedOption> {
    let declared: Vec<&ParameterSpec> = declared.into_iter().collect();
    let fits = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    let owners = declared.iter().filter_map(|spec| spec.shared.as_deref());
    if let Some(owner) = owners.into_iter().find(|owner| owner.is_empty() || !owner.chars().all(fits)) {
        let message = format!("parameters are shared under the name `{owner}`: expected letters, digits, `_` and `-`");
        return Err(RefusedOption::new("kind", message));
    }
    if let Some(message) = declared.iter().find_map(|spec| wrong_number(spec)) {
        return Err(RefusedOption::new("kind", message));
    }
    let names: Vec<&str> = declared.iter().map(|spec| spec.name.as_str()).collect();
    for (place, name) in names.iter().enumerate() {
        let wrong = if name.is_empty() || !name.chars().all(fits) {
            "expected letters, digits, `_` and `-`"
        } else if names[..place].contains(name) {
            "it names two of its parameters so"
        } else if SensorParameter::ALL.iter().any(|quantity| quantity.as_str() == *name) {
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

fn wrong_number(spec: &ParameterSpec) -> Option<String> {
    let ParameterSpec { name, nominal, limit, .. } = spec;
    if !nominal.is_finite() {
        return Some(format!("the model starts its parameter `{name}` at {nominal}: expected a finite number"));
    }
    match limit {
        Limit::Absolute(limit) | Limit::ShareOfNominal(limit) if limit.is_nan() || *limit <= 0.0 => Some(format!(
            "the model gives its parameter `{name}` the limit {limit}, beyond which a standard deviation misleads: expected a positive number"
        )),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_parameters_that_can_mean_nothing_are_refused() {
        let refused = |spec: ParameterSpec| check_parameters([&spec]).err().map(|refused| refused.message);
        let spec = |limit| ParameterSpec::new("drift", "N·m/s", limit);
        assert_eq!(refused(spec(Limit::Absolute(0.1)).starting_at(-2.0)), None);
        let start = refused(spec(Limit::Absolute(0.1)).starting_at(f64::NAN)).unwrap();
        assert_eq!(start, "the model starts its parameter `drift` at NaN: expected a finite number");
        for limit in [Limit::Absolute(-1.0), Limit::ShareOfNominal(0.0), Limit::Absolute(f64::NAN)] {
            assert!(refused(spec(limit)).unwrap().contains("expected a positive number"), "{limit:?}");
        }
    }
}
