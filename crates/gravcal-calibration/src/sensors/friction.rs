//! Friction that a torque sensor reads besides the torque that carries gravity.
//!
//! ```text
//!     y = k τ + b + f sgn(q̇)        Coulomb, by the side from which the joint came to a standstill
//!     y = k τ + b + v q̇             viscous, where the joint still moves
//! ```
//!
//! `f` and `v` are in units of the reading; divided by `k` they are torques. Identified where joints come from both sides; if a
//! joint always came from one side, `f` is part of the bias.

use gravcal_recording::Conditions;

use super::declare::{Declared, Site, Words};
use super::terms::TorqueFunction;
use crate::parameter::Limit;

/// 1, 0 or −1.
#[derive(Debug)]
struct Direction {
    joint: usize,
}

impl TorqueFunction for Direction {
    fn value(&self, _torque: f64, conditions: &Conditions) -> f64 {
        let by_velocity = || conditions.velocity.get(self.joint).map(|v| if *v == 0.0 { 0.0 } else { v.signum() });
        conditions.direction.get(self.joint).copied().or_else(by_velocity).unwrap_or(0.0)
    }
}

/// `q̇`, rad/s or m/s.
#[derive(Debug)]
struct Velocity {
    joint: usize,
}

impl TorqueFunction for Velocity {
    fn value(&self, _torque: f64, conditions: &Conditions) -> f64 {
        conditions.velocity.get(self.joint).copied().unwrap_or(0.0)
    }
}

pub(super) fn coulomb(site: &Site<'_>) -> Vec<Declared> {
    let words = Words {
        convention: "reading = ... + coulomb_friction * direction of approach",
        cure: "record poses that the joint comes to from the other side, too",
    };
    let limit = Limit::HalfSpread { channel: site.joint };
    vec![site.torque("coulomb_friction", site.torque_unit.to_owned(), words, limit, Direction { joint: site.joint })]
}

pub(super) fn viscous(site: &Site<'_>) -> Vec<Declared> {
    let words = Words {
        convention: "reading = ... + viscous_friction * velocity",
        cure: "record poses at different velocities of the joint, in both directions",
    };
    let unit = format!("{}/({}/s)", site.torque_unit, site.coordinate());
    let limit = Limit::HalfSpread { channel: site.joint };
    vec![site.torque("viscous_friction", unit, words, limit, Velocity { joint: site.joint })]
}

#[cfg(test)]
mod tests {
    use crate::sensors::testing::{assert_told_apart, shoulder, undetermined, with_model};
    use crate::sensors::{Options, SensorModelName};

    fn with(model: SensorModelName, truth: f64) -> crate::simulation::Simulation {
        with_model(shoulder(), 1, model, &Options::default(), &[truth])
    }

    #[test]
    fn coulomb_friction_is_told_from_a_constant_bias() {
        assert_told_apart(&with(SensorModelName::CoulombFriction, 3.0));
    }

    #[test]
    fn viscous_friction_is_told_from_a_constant_bias() {
        assert_told_apart(&with(SensorModelName::ViscousFriction, 120.0));
    }

    #[test]
    fn the_sign_of_the_velocity_is_a_direction() {
        let mut simulation = with(SensorModelName::CoulombFriction, 3.0);
        simulation.conditions.direction = false;
        assert_told_apart(&simulation);
    }

    #[test]
    fn poses_reached_from_one_side_leave_coulomb_friction_in_the_bias() {
        let mut session = with(SensorModelName::CoulombFriction, 3.0).session(0);
        session.poses.iter_mut().for_each(|pose| pose.conditions.direction = vec![1.0; 3]);
        assert_eq!(undetermined(&session), ["joint2.torque_bias", "joint2.coulomb_friction"]);
    }
}
