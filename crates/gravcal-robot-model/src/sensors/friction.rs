//! Friction that a torque sensor reads besides the torque that carries gravity.
//!
//! ```text
//!     y = k τ + b + f sgn(q̇)        Coulomb, by the side from which the joint came to a standstill
//!     y = k τ + b + v q̇             viscous, where the joint still moves
//! ```
//!
//! `f` and `v` are in units of the reading; divided by `k` they are torques. Identified where joints come from both sides; if a
//! joint always came from one side, `f` is part of the bias.

use super::model::{Declared, ParameterSpec, SensorModel, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Need, Partials, Reads, SensorTerm, scaled};

/// The name of friction of the same size at all speeds.
pub const COULOMB: &str = "coulomb-friction";
/// The name of friction in proportion to the velocity.
pub const VISCOUS: &str = "viscous-friction";

/// [`COULOMB`].
#[derive(Debug)]
pub(super) struct Coulomb;

/// [`VISCOUS`].
#[derive(Debug)]
pub(super) struct Viscous;

/// `f sgn(q̇)`.
#[derive(Debug)]
struct Direction {
    joint: usize,
}

impl SensorTerm for Direction {
    fn reads(&self) -> Reads {
        Reads::positions().condition(Need::Direction).linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        scaled(x, at.direction(self.joint), partials)
    }
}

/// `v q̇`.
#[derive(Debug)]
struct Velocity {
    joint: usize,
}

impl SensorTerm for Velocity {
    fn reads(&self) -> Reads {
        Reads::positions().condition(Need::Velocity).linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        scaled(x, at.velocity(self.joint), partials)
    }
}

impl SensorModel for Coulomb {
    fn name(&self) -> &str {
        COULOMB
    }

    fn help(&self) -> &str {
        "the torque reading depends on the side from which the joint came"
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let parameter = ParameterSpec::new("coulomb_friction", site.torque_unit(), site.half_spread())
            .in_equation("reading = ... + coulomb_friction * direction of approach")
            .cured_by("record poses that the joint comes to from the other side, too");
        Ok(vec![Declared::new([parameter], Direction { joint: site.joint })])
    }
}

impl SensorModel for Viscous {
    fn name(&self) -> &str {
        VISCOUS
    }

    fn help(&self) -> &str {
        "the torque reading depends on the joint's velocity"
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let unit = format!("{}/({}/s)", site.torque_unit(), site.coordinate());
        let parameter = ParameterSpec::new("viscous_friction", unit, site.half_spread())
            .in_equation("reading = ... + viscous_friction * velocity")
            .cured_by("record poses at different velocities of the joint, in both directions");
        Ok(vec![Declared::new([parameter], Velocity { joint: site.joint })])
    }
}
