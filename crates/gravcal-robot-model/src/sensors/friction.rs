//! Friction that a torque sensor reads besides the torque that carries gravity.
//!
//! ```text
//!     y = k τ + b + f sgn(q̇)        Coulomb, by the side from which the joint came to a standstill
//!     y = k τ + b + v q̇             viscous, where the joint still moves; q̇: velocity of the position reading times its nominal gain
//!     y = k τ + b + f z(q; x)       Coulomb's, that builds up over a travel x: dz/dq = (sgn q̇ − z)/x      (Dahl, 1968)
//! ```
//!
//! `f` and `v` are in units of the reading; divided by `k` they are torques. Identified where joints come from both sides; if a
//! joint always came from one side, `f` is part of the bias. The travel is known from an arm in motion whose joints turn round often.

use super::model::{Declared, ParameterSpec, SensorModel, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Need, Partials, Reads, SensorTerm, scaled};
use crate::parameter::Limit;

/// The name of friction of the same size at all speeds.
pub const COULOMB: &str = "coulomb-friction";
/// The name of friction in proportion to the velocity.
pub const VISCOUS: &str = "viscous-friction";
/// The name of friction that builds up before a joint slides.
pub const PRESLIDING: &str = "presliding-friction";

/// Where a travel starts, rad or m; and the standard deviation beyond which one would mislead.
const TRAVEL: f64 = 1e-3;
const USEFUL_TRAVEL: f64 = 2e-3;
/// Where the size of friction that builds up starts, N·m or N: of none no travel could be known.
const SIZE: f64 = 1.0;

/// [`COULOMB`].
#[derive(Debug)]
pub(super) struct Coulomb;

/// [`VISCOUS`].
#[derive(Debug)]
pub(super) struct Viscous;

/// [`PRESLIDING`].
#[derive(Debug)]
pub(super) struct Presliding;

/// `f z(q; x)`.
#[derive(Debug)]
struct BuiltUp {
    joint: usize,
}

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

impl SensorTerm for BuiltUp {
    fn reads(&self) -> Reads {
        Reads::positions().condition(Need::Presliding)
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        let [size, travel] = [x[0], x[1]];
        let (state, by_travel) = at.presliding(self.joint, travel);
        if let Some(Partials { by_parameter, .. }) = partials {
            by_parameter.copy_from_slice(&[state, size * by_travel]);
        }
        size * state
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
            .in_equation("reading = ... + viscous_friction * velocity by the nominal position gain")
            .cured_by("record poses at different velocities of the joint, in both directions");
        Ok(vec![Declared::new([parameter], Velocity { joint: site.joint })])
    }
}

impl SensorModel for Presliding {
    fn name(&self) -> &str {
        PRESLIDING
    }

    fn help(&self) -> &str {
        "in motion: friction builds up over a travel after a reversal"
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        const EQUATION: &str =
            "reading = ... + coulomb_friction * z, dz/dposition = (sign of the velocity - z) / presliding_travel";
        let size = ParameterSpec::new("coulomb_friction", site.torque_unit(), site.half_spread())
            .starting_at(SIZE * site.torque_gain().abs())
            .in_equation(EQUATION)
            .cured_by("let the joint move in both directions");
        let travel = ParameterSpec::new("presliding_travel", site.coordinate(), Limit::Absolute(USEFUL_TRAVEL))
            .starting_at(TRAVEL)
            .in_equation(EQUATION)
            .cured_by("let the joint turn round more often, in many places");
        Ok(vec![Declared::new([size, travel], BuiltUp { joint: site.joint })])
    }
}

#[cfg(test)]
mod tests {
    use gravcal_recording::{Conditions, DahlFriction};

    use super::*;

    #[test]
    fn derivatives_of_friction_that_builds_up() {
        let mut friction = DahlFriction::new(1.0);
        [0.0, 0.1, 0.0985].into_iter().for_each(|position| friction.go(position));
        let conditions = Conditions { presliding: vec![None, friction.state()], ..Conditions::default() };
        let at = Moment::new(&[3.0, 4.0], &[0.1, 0.2], &[0.3, -1.2], &conditions);
        // Steps of a millionth are coarse for a travel: it has its own.
        let value = |travel: f64| BuiltUp { joint: 1 }.value(&at, &[0.7, travel], None);
        for travel in [2e-4, 1.2e-3, 5e-3] {
            let (mut by_parameter, step) = ([0.0; 2], 1e-9);
            let partials =
                Partials { by_parameter: &mut by_parameter, by_torque: &mut [0.0; 2], by_coordinate: &mut [0.0; 2] };
            let here = BuiltUp { joint: 1 }.value(&at, &[0.7, travel], Some(partials));
            let slope = (value(travel + step) - value(travel - step)) / (2.0 * step);
            assert!((by_parameter[1] - slope).abs() < 1e-5 * slope.abs(), "{travel}: {} {slope}", by_parameter[1]);
            assert!((by_parameter[0] - here / 0.7).abs() < 1e-12);
        }
        let (state, _) = at.presliding(1, 1.5e-3);
        assert!((state - (2.0 * f64::exp(-1.0) - 1.0)).abs() < 0.01, "{state}");
    }

    #[test]
    fn where_friction_was_not_followed_all_of_it_has_the_direction() {
        let conditions = Conditions { direction: vec![-1.0], presliding: vec![None], ..Conditions::default() };
        let at = Moment::new(&[3.0], &[0.1], &[0.3], &conditions);
        assert_eq!(BuiltUp { joint: 0 }.value(&at, &[0.7, 1e-3], None), -0.7);
    }
}
