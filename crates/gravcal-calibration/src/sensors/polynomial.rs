//! A torque sensor whose gain depends on the torque.
//!
//! ```text
//!     y = k τ + k₂ τ² + k₃ τ³ + b
//! ```
//!
//! Identified where the joint's torque covers a wide range on both sides, and the scale of its gain is. The common scale of
//! all gains, which no bare pose determines, scales these as well: `k₂` by its square, `k₃` by its cube.

use super::model::{Declared, ParameterSpec, SensorModel, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Partials, Reads, SensorTerm};
use crate::parameter::Limit;

/// `torque-gain-polynomial`.
#[derive(Debug)]
pub(super) struct Polynomial;

/// `kₙ τⁿ`.
#[derive(Debug)]
struct Power {
    joint: usize,
    power: i32,
}

impl SensorTerm for Power {
    fn reads(&self) -> Reads {
        Reads::positions().torque(self.joint).linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        let torque = at.torque(self.joint);
        let function = torque.powi(self.power);
        if let Some(Partials { by_parameter, by_torque, .. }) = partials {
            by_parameter[0] = function;
            by_torque[self.joint] = x[0] * (f64::from(self.power) * torque.powi(self.power - 1));
        }
        x[0] * function
    }
}

impl SensorModel for Polynomial {
    fn name(&self) -> &str {
        "torque-gain-polynomial"
    }

    fn help(&self) -> &str {
        "the torque gain depends on the torque"
    }

    fn options(&self) -> &[&str] {
        &["degree"]
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let degree = match options.whole_number("degree")?.unwrap_or(3) {
            2 => 2,
            3 => 3,
            other => {
                let message = format!("{other} is no degree of the polynomial: expected 2 or 3");
                return Err(RefusedOption::new("degree", message));
            }
        };
        let joint = site.joint;
        let term = |power: i32| {
            let unit = format!("{}/({})^{power}", site.torque_unit(), site.effort(joint));
            let limit = Limit::GainChange { joint, power: power - 1 };
            let parameter = ParameterSpec::new(format!("torque_gain_{power}"), unit, limit)
                .in_equation(
                    "reading = torque_gain * torque + torque_gain_2 * torque^2 + torque_gain_3 * torque^3 + torque_bias",
                )
                .cured_by("add poses, and loads, that turn the joint's torque from one extreme to the other");
            Declared::new([parameter], Power { joint, power })
        };
        Ok((2..=degree).map(term).collect())
    }
}

#[cfg(test)]
mod tests {
    use gravcal_solvers::VariableProjection;

    use crate::result::EstimatorResult;
    use crate::sensors::Options;
    use crate::sensors::testing::{assert_told_apart, estimate, estimate_by, shoulder, undetermined, with_model};

    #[test]
    fn a_curved_characteristic_is_told_from_a_straight_one() {
        let truth = [4e-3, -4e-4];
        let options = Options::default();
        assert_told_apart(&with_model(shoulder(), 1, "torque-gain-polynomial", &options, &truth));
    }

    /// Readings are no longer linear in the moments, and variable projection must not take them for it.
    #[test]
    fn every_method_ends_at_the_same_polynomial() {
        let options = Options::default().with("degree", 2);
        let simulation = with_model(shoulder(), 1, "torque-gain-polynomial", &options, &[4e-3]);
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
        let options = Options::default().with("degree", 2);
        let simulation = with_model(shoulder(), 1, "torque-gain-polynomial", &options, &[4e-3]);
        let mut session = simulation.session(0);
        session.poses.retain(|pose| pose.load.is_none());
        let open = undetermined(&session);
        assert!(open.contains(&"joint2.torque_gain".to_owned()), "{open:?}");
        assert!(!open.contains(&"joint2.torque_bias".to_owned()), "{open:?}");
    }
}
