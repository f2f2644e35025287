//! A torque sensor whose gain depends on the torque.
//!
//! ```text
//!     y = k τ + k₂ τ² + k₃ τ³ + b
//! ```
//!
//! Identified where the joint's torque covers a wide range on both sides, and the scale of its gain is. The common scale of
//! all gains, which no bare pose determines, scales these as well: `k₂` by its square, `k₃` by its cube.

use gravcal_recording::Conditions;

use super::declare::{Declared, Options, RefusedOption, Site, Words};
use super::terms::TorqueFunction;
use crate::parameter::Limit;

/// `τⁿ`.
#[derive(Debug)]
struct Power {
    joint: usize,
    power: i32,
}

impl TorqueFunction for Power {
    fn source(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn value(&self, torque: f64, _conditions: &Conditions) -> f64 {
        torque.powi(self.power)
    }

    fn slope(&self, torque: f64) -> f64 {
        f64::from(self.power) * torque.powi(self.power - 1)
    }

    fn is_straight(&self) -> bool {
        false
    }
}

pub(super) fn declare(site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
    let degree = options.degree.unwrap_or(3);
    if !(2..=3).contains(&degree) {
        let message = format!("{degree} is no degree of the polynomial: expected 2 or 3");
        return Err(RefusedOption { key: "degree", message });
    }
    let words = Words {
        convention: "reading = torque_gain * torque + torque_gain_2 * torque^2 + torque_gain_3 * torque^3 + torque_bias",
        cure: "add poses, and loads, that turn the joint's torque from one extreme to the other",
    };
    let joint = site.joint;
    let term = |power: i32| {
        let unit = format!("{}/({})^{power}", site.torque_unit, site.effort(joint));
        let limit = Limit::GainChange { joint, power: power - 1 };
        site.torque(format!("torque_gain_{power}"), unit, words, limit, Power { joint, power })
    };
    Ok((2..=degree).map(term).collect())
}

#[cfg(test)]
mod tests {
    use gravcal_solvers::VariableProjection;

    use crate::result::EstimatorResult;
    use crate::sensors::testing::{assert_told_apart, estimate, estimate_by, shoulder, undetermined, with_model};
    use crate::sensors::{Options, SensorModelName};

    #[test]
    fn a_curved_characteristic_is_told_from_a_straight_one() {
        let truth = [4e-3, -4e-4];
        let options = Options::default();
        assert_told_apart(&with_model(shoulder(), 1, SensorModelName::TorqueGainPolynomial, &options, &truth));
    }

    /// Readings are no longer linear in the moments, and variable projection must not take them for it.
    #[test]
    fn every_method_ends_at_the_same_polynomial() {
        let options = Options { degree: Some(2), ..Options::default() };
        let simulation = with_model(shoulder(), 1, SensorModelName::TorqueGainPolynomial, &options, &[4e-3]);
        let session = simulation.session(0);
        let value = |result: EstimatorResult| {
            let told = result.parameters.into_iter().find(|told| told.name == "joint2.torque_gain_2").unwrap();
            (told.value.unwrap(), told.std.unwrap())
        };
        let (expected, std) = value(estimate(&session));
        let (found, _) = value(estimate_by(&VariableProjection::default(), &session));
        assert!((found - expected).abs() < 1e-4 * std, "{found} {expected}");
    }

    /// Without the load the scale of all gains is free, and the polynomial's coefficients with it.
    #[test]
    fn bare_poses_leave_its_scale_with_that_of_the_gains() {
        let options = Options { degree: Some(2), ..Options::default() };
        let simulation = with_model(shoulder(), 1, SensorModelName::TorqueGainPolynomial, &options, &[4e-3]);
        let mut session = simulation.session(0);
        session.poses.retain(|pose| pose.load.is_none());
        let open = undetermined(&session);
        assert!(open.contains(&"joint2.torque_gain".to_owned()), "{open:?}");
        assert!(!open.contains(&"joint2.torque_bias".to_owned()), "{open:?}");
    }
}
