//! The bias of a torque sensor that drifts with time, or with temperature.
//!
//! ```text
//!     y = k τ + b + d t            t: s since the session's first pose, of all tables
//!     y = k τ + b + e (T − T₀)     T₀: a temperature that the session states
//! ```
//!
//! Identified wherever the bias is and the poses are spread over time (temperatures). Where temperature rises evenly with
//! time the two drifts are one; where all poses of one place are read in one go, a drift passes for moments.

use gravcal_recording::Conditions;

use super::declare::{Declared, Options, RefusedOption, Site, Words};
use super::terms::TorqueFunction;
use crate::parameter::Limit;

/// `t`.
#[derive(Debug)]
struct Time;

impl TorqueFunction for Time {
    fn value(&self, _torque: f64, conditions: &Conditions) -> f64 {
        conditions.time.unwrap_or(0.0)
    }
}

/// `T − T₀`.
#[derive(Debug)]
struct Temperature {
    joint: usize,
    reference: f64,
}

impl TorqueFunction for Temperature {
    fn value(&self, _torque: f64, conditions: &Conditions) -> f64 {
        conditions.temperature.get(self.joint).map_or(0.0, |temperature| temperature - self.reference)
    }
}

pub(super) fn in_time(site: &Site<'_>) -> Vec<Declared> {
    let words = Words {
        convention: "reading = ... + torque_bias_drift * (time since the first pose)",
        cure: "record poses of the same kind again, hours later",
    };
    let (unit, limit) = (format!("{}/s", site.torque_unit), Limit::HalfSpread { channel: site.joint });
    vec![site.torque("torque_bias_drift", unit, words, limit, Time)]
}

pub(super) fn with_temperature(site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
    let reference = options.reference_degc.ok_or_else(|| RefusedOption {
        key: "reference_degC",
        message: "at which temperature is torque_bias the bias? add reference_degC, such as 25".to_owned(),
    })?;
    let words = Words {
        convention: "reading = ... + torque_bias_temperature_drift * (temperature - reference_degC)",
        cure: "record poses of the same kind again with the sensors some kelvins warmer or colder",
    };
    let (unit, limit) = (format!("{}/K", site.torque_unit), Limit::HalfSpread { channel: site.joint });
    let function = Temperature { joint: site.joint, reference };
    Ok(vec![site.torque("torque_bias_temperature_drift", unit, words, limit, function)])
}

#[cfg(test)]
mod tests {
    use crate::sensors::testing::{assert_told_apart, shoulder, undetermined, with_model};
    use crate::sensors::{Options, SensorModelName};

    const WARM: Options = Options { reference_degc: Some(30.0), degree: None, from: None, orders: None };

    #[test]
    fn a_drift_in_time_is_told_from_a_constant_bias() {
        assert_told_apart(&with_model(shoulder(), 1, SensorModelName::TorqueBiasInTime, &Options::default(), &[2e-3]));
    }

    #[test]
    fn a_drift_with_temperature_is_told_from_a_constant_bias() {
        assert_told_apart(&with_model(shoulder(), 2, SensorModelName::TorqueBiasWithTemperature, &WARM, &[0.6]));
    }

    #[test]
    fn poses_of_one_time_determine_no_drift() {
        let mut simulation = with_model(shoulder(), 1, SensorModelName::TorqueBiasInTime, &Options::default(), &[2e-3]);
        simulation.conditions.pose_interval = Some(0.0);
        assert_eq!(undetermined(&simulation.session(0)), ["joint2.torque_bias_drift"]);
    }

    #[test]
    fn where_temperature_rises_evenly_with_time_only_their_sum_is_determined() {
        let both = with_model(shoulder(), 1, SensorModelName::TorqueBiasInTime, &Options::default(), &[2e-3]);
        let mut session = with_model(both, 1, SensorModelName::TorqueBiasWithTemperature, &WARM, &[0.6]).session(0);
        for conditions in session.poses.iter_mut().map(|pose| &mut pose.conditions) {
            conditions.temperature = vec![30.0 + 1e-3 * conditions.time.unwrap(); 3];
        }
        assert_eq!(undetermined(&session), ["joint2.torque_bias_drift", "joint2.torque_bias_temperature_drift"]);
    }
}
