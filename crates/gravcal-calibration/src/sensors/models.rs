//! What each named model declares.

use super::declare::{Declared, Options, RefusedOption, Site};
use super::name::SensorModelName;
use super::terms::Term;
use super::{crosstalk, drift, friction, harmonics, polynomial};
use crate::parameter::Parameter;

impl SensorModelName {
    /// Its parameters and terms for one joint.
    pub(crate) fn declare(self, site: &Site<'_>, options: &Options) -> Result<Vec<(Parameter, Term)>, RefusedOption> {
        let term = |declared: Declared| {
            (declared.parameter, Term { joint: site.joint, model: self, function: declared.function })
        };
        Ok(self.functions(site, options)?.into_iter().map(term).collect())
    }

    fn functions(self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        match self {
            SensorModelName::TorqueBiasInTime => Ok(drift::in_time(site)),
            SensorModelName::TorqueBiasWithTemperature => drift::with_temperature(site, options),
            SensorModelName::TorqueGainPolynomial => polynomial::declare(site, options),
            SensorModelName::CoulombFriction => Ok(friction::coulomb(site)),
            SensorModelName::ViscousFriction => Ok(friction::viscous(site)),
            SensorModelName::TorqueCrosstalk => crosstalk::declare(site, options),
            SensorModelName::PositionHarmonics => harmonics::declare(site, options),
        }
    }
}
