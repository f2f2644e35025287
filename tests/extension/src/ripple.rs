//! A torque sensor in a gear whose reading ripples with the joint's angle; derivatives by hand.
//!
//! ```text
//!     y = k τ + b + a sin(n q + φ)
//! ```

use gravcal::calibration::parameter::Limit;
use gravcal::calibration::sensors::{
    Declared, Moment, Options, ParameterSpec, Partials, Reads, RefusedOption, SensorModel, SensorTerm, Site,
};

/// `kind = "torque-ripple"`; `order`: roughly how many periods a radian, `amplitude`: roughly how high, in the unit of the reading.
#[derive(Debug)]
pub struct Ripple;

/// `a sin(n q + φ)`.
#[derive(Debug)]
struct Wave {
    joint: usize,
}

impl SensorTerm for Wave {
    fn reads(&self) -> Reads {
        Reads::positions()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        let (amplitude, order, phase) = (x[0], x[1], x[2]);
        let position = at.position(self.joint);
        let (sine, cosine) = (order * position + phase).sin_cos();
        if let Some(partials) = partials {
            partials.by_parameter.copy_from_slice(&[sine, amplitude * cosine * position, amplitude * cosine]);
        }
        amplitude * sine
    }
}

impl SensorModel for Ripple {
    fn name(&self) -> &str {
        "torque-ripple"
    }

    fn help(&self) -> &str {
        "the torque reading ripples with the joint's angle"
    }

    fn options(&self) -> &[&str] {
        &["order", "amplitude"]
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let positive = |key: &str, what: &str| {
            let number = options.number(key)?.filter(|number| *number > 0.0);
            number.ok_or_else(|| RefusedOption::new(key, format!("{what} add {key}, a number above zero")))
        };
        let order = positive("order", "how many periods are there a radian?")?;
        let amplitude = positive("amplitude", "roughly how high is the ripple?")?;
        let parameter = |name: &str, unit: &str, nominal: f64, useful: f64| {
            ParameterSpec::new(name, unit, Limit::Absolute(useful))
                .starting_at(nominal)
                .in_equation("reading = ... + ripple_amplitude * sin(ripple_order * position + ripple_phase)")
                .cured_by("add poses that move the joint through several periods of the ripple")
        };
        let parameters = [
            parameter("ripple_amplitude", site.torque_unit(), amplitude, 0.5 * amplitude),
            parameter("ripple_order", "1/rad", order, 0.1),
            parameter("ripple_phase", "rad", 0.0, 0.2),
        ];
        Ok(vec![Declared::new(parameters, Wave { joint: site.joint() })])
    }
}

#[cfg(test)]
mod tests {
    use gravcal::calibration::sensors::check_term_derivatives;
    use gravcal::recording::Conditions;

    use super::*;

    #[test]
    fn derivatives() {
        let conditions = Conditions::default();
        let at = Moment::new(&[3.0, 4.0], &[0.1, 0.2], &[0.3, -1.2], &conditions);
        check_term_derivatives(&Wave { joint: 1 }, &at, &[2.0, 6.0, 0.4], 1e-6).unwrap();
    }
}
