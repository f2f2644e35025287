//! A position sensor whose reading runs unevenly: eccentricity, and the ripple of a harmonic drive.
//!
//! ```text
//!     θ = s q + o + Σ_n [a_n sin(n φ) + c_n cos(n φ)],    φ = s₀ q
//! ```
//!
//! `s₀` is the nominal gain, so that `φ` is the angle that the sensor shows. `n = 1` is a disc mounted off its centre; a harmonic
//! drive ripples twice a turn of its input. Identified where the joint moves through a good part of a period, loaded so that gravity turns
//! with it; over a short range the first order looks like gain and offset.

use super::model::{Declared, ParameterSpec, SensorModel, Side, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Partials, Reads, SensorTerm, scaled};
use crate::parameter::Limit;

/// Largest standard deviation of an amplitude that is of use, rad: that of an offset.
const USEFUL: f64 = 0.1;

/// `position-harmonics`.
#[derive(Debug)]
pub(super) struct Harmonics;

/// `a sin(n s₀ q)` or `c cos(n s₀ q)`.
#[derive(Debug)]
struct Harmonic {
    joint: usize,
    /// `n s₀`, rad a unit of the reading.
    frequency: f64,
    function: fn(f64) -> f64,
}

impl SensorTerm for Harmonic {
    fn reads(&self) -> Reads {
        Reads::positions().linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        scaled(x, (self.function)(self.frequency * at.position(self.joint)), partials)
    }
}

impl SensorModel for Harmonics {
    fn name(&self) -> &str {
        "position-harmonics"
    }

    fn help(&self) -> &str {
        "the position reading runs unevenly: eccentricity, ripple"
    }

    fn side(&self) -> Side {
        Side::Position
    }

    fn options(&self) -> &[&str] {
        &["orders"]
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let refused = |message: String| RefusedOption::new("orders", message);
        if !site.turns(site.joint) {
            let message = "the joint slides, and only one that turns has harmonics";
            return Err(RefusedOption::new("kind", message));
        }
        let orders = options.whole_numbers("orders")?.unwrap_or_default();
        if orders.is_empty() {
            return Err(refused("how many periods a turn? add orders, such as [1] for an eccentric disc".into()));
        }
        if let Some(order) = orders.iter().enumerate().find(|(i, order)| **order < 1 || orders[..*i].contains(order)) {
            return Err(refused(format!(
                "{} is zero or stands twice: expected different whole numbers from 1",
                order.1
            )));
        }
        let term = |name: &str, order: i64, function: fn(f64) -> f64| {
            let frequency = order as f64 * site.position_gain();
            let name = format!("{name}_{order}");
            let parameter = ParameterSpec::new(name, site.coordinate(), Limit::Absolute(USEFUL))
                .in_equation(
                    "coordinate = ... + position_sine_<n> * sin(n * angle) + position_cosine_<n> * cos(n * angle), angle = \
                     nominal position_gain * reading",
                )
                .cured_by(
                    "add poses that move the joint through a whole period, at several positions of the joints before it",
                );
            Declared::new([parameter], Harmonic { joint: site.joint, frequency, function })
        };
        let of_order =
            |order: &i64| [term("position_sine", *order, f64::sin), term("position_cosine", *order, f64::cos)];
        Ok(orders.iter().flat_map(of_order).collect())
    }
}
