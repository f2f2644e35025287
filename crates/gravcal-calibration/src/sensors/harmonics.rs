//! A position sensor whose reading runs unevenly: eccentricity, and the ripple of a harmonic drive.
//!
//! ```text
//!     θ = s q + o + Σ_n [a_n sin(n φ) + c_n cos(n φ)],    φ = s₀ q
//! ```
//!
//! `s₀` is the nominal gain, so that `φ` is the angle that the sensor shows. `n = 1` is a disc mounted off its centre; a harmonic
//! drive ripples twice a turn of its input. Identified where the joint moves through a good part of a period, loaded so that gravity turns
//! with it; over a short range the first order looks like gain and offset.

use gravcal_dynamics::JointKind;

use super::declare::{Declared, Options, RefusedOption, Site, Words};
use super::terms::PositionFunction;

/// Largest standard deviation of an amplitude that is of use, rad: that of an offset.
const USEFUL: f64 = 0.1;

/// `sin(n s₀ q)` or `cos(n s₀ q)`.
#[derive(Debug)]
struct Harmonic {
    /// `n s₀`, rad a unit of the reading.
    frequency: f64,
    function: fn(f64) -> f64,
}

impl PositionFunction for Harmonic {
    fn value(&self, reading: f64) -> f64 {
        (self.function)(self.frequency * reading)
    }
}

pub(super) fn declare(site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
    let refused = |message: String| RefusedOption { key: "orders", message };
    if site.kinds[site.joint] == JointKind::Prismatic {
        return Err(RefusedOption {
            key: "kind",
            message: "the joint slides, and only one that turns has harmonics".into(),
        });
    }
    let orders = options.orders.as_deref().unwrap_or_default();
    if orders.is_empty() {
        return Err(refused("how many periods a turn? add orders, such as [1] for an eccentric disc".into()));
    }
    if let Some(order) = orders.iter().enumerate().find(|(i, order)| **order == 0 || orders[..*i].contains(order)) {
        return Err(refused(format!("{} is zero or stands twice: expected different whole numbers from 1", order.1)));
    }
    let words = Words {
        convention: "coordinate = ... + position_sine_<n> * sin(n * angle) + position_cosine_<n> * cos(n * angle), angle = \
                     nominal position_gain * reading",
        cure: "add poses that move the joint through a whole period, at several positions of the joints before it",
    };
    let term = |name: &str, order: u32, function: fn(f64) -> f64| {
        let frequency = f64::from(order) * site.position_gain;
        site.position(format!("{name}_{order}"), words, USEFUL, Harmonic { frequency, function })
    };
    let of_order = |order: &u32| [term("position_sine", *order, f64::sin), term("position_cosine", *order, f64::cos)];
    Ok(orders.iter().flat_map(of_order).collect())
}

#[cfg(test)]
mod tests {
    use crate::sensors::testing::{assert_told_apart, shoulder, undetermined, with_model};
    use crate::sensors::{Options, SensorModelName};

    fn orders(orders: &[u32]) -> Options {
        Options { orders: Some(orders.to_vec()), ..Options::default() }
    }

    #[test]
    fn eccentricity_is_told_from_an_even_scale() {
        let truth = [0.02, -0.015];
        assert_told_apart(&with_model(shoulder(), 1, SensorModelName::PositionHarmonics, &orders(&[1]), &truth));
    }

    #[test]
    fn ripple_is_told_from_an_even_scale() {
        let truth = [0.01, 0.004, -0.003, 0.006];
        assert_told_apart(&with_model(shoulder(), 2, SensorModelName::PositionHarmonics, &orders(&[2, 4]), &truth));
    }

    /// Nothing is said of a joint's scale by readings at one place of it.
    #[test]
    fn a_joint_that_stands_still_has_no_harmonics() {
        let simulation = with_model(shoulder(), 2, SensorModelName::PositionHarmonics, &orders(&[1]), &[0.02, 0.01]);
        let mut session = simulation.session(0);
        session.poses.retain(|pose| pose.position[2] == -std::f64::consts::FRAC_PI_2);
        let open = undetermined(&session);
        for name in ["joint3.position_sine_1", "joint3.position_cosine_1"] {
            assert!(open.contains(&name.to_owned()), "{open:?}");
        }
    }
}
