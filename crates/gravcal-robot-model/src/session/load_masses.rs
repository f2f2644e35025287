//! Masses of loads that were weighed with an error, as parameters of a session.
//!
//! All torque gains are measured against the loads' masses: how well these are known is how well any gain is. Loads of the same nominal mass
//! and standard deviation are one body, weighed once and hung at several places, and share one mass.

use super::contents::Session;
use super::known::Load;
use super::parameter_prior::{ParameterPrior, PriorKind};
use super::parameters::GAIN_LIMIT;
use crate::parameter::{Limit, Parameter, ParameterId};

/// The mass of a load that was weighed to `std`, kg. `same_as`: the place of the same body's mass, where another load has it.
fn load_mass_parameter(load: &Load, std: f64, same_as: Option<usize>) -> Parameter {
    Parameter {
        owner: format!("load.{}", load.name),
        quantity: "mass".into(),
        unit: "kg".into(),
        convention: "mass of the load".into(),
        prior: ParameterPrior { nominal: load.mass, kind: PriorKind::Gaussian { std } },
        fixed: None,
        limit: Limit::ShareOfNominal(GAIN_LIMIT),
        cure: "weigh the load on a better scale".into(),
        linear: false,
        same_as,
    }
}

/// By load, the place of its mass among the further parameters, to which they are added; empty where all are exact. `std`: how well each was
/// weighed, kg.
pub fn add_load_masses(loads: &[Load], std: &[Option<f64>], further: &mut Vec<Parameter>) -> Vec<Option<usize>> {
    if std.iter().all(Option::is_none) {
        return Vec::new();
    }
    let mut places: Vec<Option<usize>> = Vec::with_capacity(loads.len());
    for (index, (load, of_this)) in loads.iter().zip(std).enumerate() {
        let Some(of_this) = *of_this else {
            places.push(None);
            continue;
        };
        let same = (0..index).find(|other| loads[*other].mass == load.mass && std[*other] == Some(of_this));
        let same_as = same.and_then(|other| places[other]);
        let root = same_as.and_then(|place| further[place].same_as).or(same_as);
        places.push(Some(further.len()));
        further.push(load_mass_parameter(load, of_this, root));
    }
    places
}

impl Session {
    /// The parameter that a load's mass is; nothing where it is exact, or unknown.
    pub fn load_mass(&self, load: usize) -> Option<ParameterId> {
        let place = self.load_masses.get(load).copied().flatten()?;
        Some(ParameterId::Further(self.further[place].same_as.unwrap_or(place)))
    }

    /// The loads whose mass a parameter is.
    pub fn loads_of_mass(&self, id: ParameterId) -> impl Iterator<Item = usize> {
        (0..self.loads.len()).filter(move |load| self.load_mass(*load) == Some(id))
    }

    /// How well a load's mass is known, as a share of it; zero where it is exact.
    pub fn relative_mass_std(&self, load: usize) -> f64 {
        match self.load_mass(load).map(|id| self.prior(id)) {
            Some(ParameterPrior { nominal, kind: PriorKind::Gaussian { std } }) => std / nominal,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_at_several_places_has_one_mass() {
        let load =
            |name: &str, mass: f64| Load { name: name.into(), mass, link: 0, position: None, position_std: None };
        let loads = [load("a", 2.0), load("b", 1.0), load("c", 2.0), load("d", 2.0), load("e", 2.0)];
        let mut further = Vec::new();
        let std = [Some(0.01), None, Some(0.01), Some(0.02), Some(0.01)];
        let places = add_load_masses(&loads, &std, &mut further);
        assert_eq!(places, [Some(0), None, Some(1), Some(2), Some(3)]);
        let same: Vec<Option<usize>> = further.iter().map(|parameter| parameter.same_as).collect();
        assert_eq!(same, [None, Some(0), None, Some(0)]);
        assert_eq!(further[2].name(), "load.d.mass");
        assert!(add_load_masses(&loads, &[None; 5], &mut further).is_empty() && further.len() == 4);
    }
}
