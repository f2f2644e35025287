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
