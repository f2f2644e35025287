//! The bias of a torque sensor that drifts with time, or with temperature.
//!
//! ```text
//!     y = k τ + b + d t            t: s since the session's first pose, of all tables
//!     y = k τ + b + e (T − T₀)     T₀: a temperature that the session states
//! ```
//!
//! Identified wherever the bias is and the poses are spread over time (temperatures). Where temperature rises evenly with
//! time the two drifts are one; where all poses of one place are read in one go, a drift passes for moments.

use super::model::{Declared, ParameterSpec, SensorModel, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Need, Partials, Reads, SensorTerm, scaled};

/// `torque-bias-in-time`.
#[derive(Debug)]
pub(super) struct DriftInTime;

/// `torque-bias-with-temperature`.
#[derive(Debug)]
pub(super) struct DriftWithTemperature;

/// `d t`.
#[derive(Debug)]
struct Time;

impl SensorTerm for Time {
    fn reads(&self) -> Reads {
        Reads::positions().condition(Need::Time).linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        scaled(x, at.time(), partials)
    }
}

/// `e (T − T₀)`.
#[derive(Debug)]
struct Temperature {
    joint: usize,
    reference: f64,
}

impl SensorTerm for Temperature {
    fn reads(&self) -> Reads {
        Reads::positions().condition(Need::Temperature).linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        scaled(x, at.temperature(self.joint).map_or(0.0, |temperature| temperature - self.reference), partials)
    }
}

impl SensorModel for DriftInTime {
    fn name(&self) -> &str {
        "torque-bias-in-time"
    }

    fn help(&self) -> &str {
        "the torque bias drifts linearly in time"
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let unit = format!("{}/s", site.torque_unit());
        let parameter = ParameterSpec::new("torque_bias_drift", unit, site.half_spread())
            .in_equation("reading = ... + torque_bias_drift * (time since the first pose)")
            .cured_by("record poses of the same kind again, hours later");
        Ok(vec![Declared::new([parameter], Time)])
    }
}

impl SensorModel for DriftWithTemperature {
    fn name(&self) -> &str {
        "torque-bias-with-temperature"
    }

    fn help(&self) -> &str {
        "the torque bias drifts linearly with temperature"
    }

    fn options(&self) -> &[&str] {
        &["reference_degC"]
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let reference = options.number("reference_degC")?.ok_or_else(|| {
            RefusedOption::new(
                "reference_degC",
                "at which temperature is torque_bias the bias? add reference_degC, such as 25".to_owned(),
            )
        })?;
        let unit = format!("{}/K", site.torque_unit());
        let parameter = ParameterSpec::new("torque_bias_temperature_drift", unit, site.half_spread())
            .in_equation("reading = ... + torque_bias_temperature_drift * (temperature - reference_degC)")
            .cured_by("record poses of the same kind again with the sensors some kelvins warmer or colder");
        Ok(vec![Declared::new([parameter], Temperature { joint: site.joint, reference })])
    }
}
